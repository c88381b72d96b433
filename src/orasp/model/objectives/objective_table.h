#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <variant>

#include "orasp/model/objectives/callable.h"
#include "orasp/model/objectives/changeover.h"
#include "orasp/model/objectives/completion.h"
#include "orasp/model/objectives/cubesat_zone.h"
#include "orasp/model/objectives/expression.h"
#include "orasp/model/objectives/fleet_objectives.h"
#include "orasp/model/objectives/fuel.h"
#include "orasp/model/objectives/indexed.h"
#include "orasp/model/objectives/piece_cost.h"
#include "orasp/model/objectives/retried.h"
#include "orasp/model/objectives/route.h"
#include "orasp/model/objectives/sum.h"
#include "orasp/model/objectives/time.h"
#include "orasp/model/objectives/travel.h"

namespace orasp {

/// The parameters of one objective.
using ObjectiveParameters = std::variant<PieceCost, CubesatZone, Indexed, TimeObjective, Travel,
                                         Fuel, CompletionObjective, Changeover, Route, Expression,
                                         Callable, WeightedSum, Retried, Makespan, FleetTravel>;

/// One type of objective: what a file calls it, and who knows all about it.
struct ObjectiveRow {
  std::string_view type;
  const ObjectiveKind& (*kind)();
  /// Whether it judges plans of several robots, and none of one.
  bool of_fleet = false;
  /// Whether it looks at what the steps before left behind.
  bool looks_back = false;
  /// Whether a file may name it.
  bool in_files = true;
  /// What it has no meaning without, if there is something: "a formula".
  std::string_view needs{};
  /// Where the numbers are fixed: the type that states the same ones key by key.
  std::string_view stated_as{};
};

/// All of them, in the order of the documentation.
inline constexpr auto kObjectiveRows = std::to_array<ObjectiveRow>({
    {.type = "piece_cost", .kind = piece_cost_kind},
    {.type = "cubesat", .kind = cubesat_kind, .stated_as = "piece_cost"},
    {.type = "cubesat_zone", .kind = cubesat_zone_kind},
    {.type = "custom", .kind = custom_kind, .stated_as = "piece_cost"},
    {.type = "indexed", .kind = indexed_kind},
    {.type = "time", .kind = time_kind},
    {.type = "travel", .kind = travel_kind},
    {.type = "fuel", .kind = fuel_kind},
    {.type = "completion", .kind = completion_kind},
    {.type = "changeover", .kind = changeover_kind, .looks_back = true, .needs = "an attribute"},
    {.type = "route", .kind = route_kind, .looks_back = true},
    {.type = "expression", .kind = expression_kind, .needs = "a formula"},
    {.type = "sum", .kind = sum_kind, .needs = "its terms"},
    {.type = "makespan", .kind = makespan_kind, .of_fleet = true},
    {.type = "fleet_travel", .kind = fleet_travel_kind, .of_fleet = true},
    {.type = "callable",
     .kind = callable_kind,
     .in_files = false,
     .needs = "a function of the step"},
    {.type = "retried", .kind = retried_kind, .in_files = false, .needs = "what one attempt earns"},
});

/// The row of a type; null if there is none.
[[nodiscard]] constexpr const ObjectiveRow* objective_row(std::string_view type) {
  const auto* const row = std::ranges::find(kObjectiveRows, type, &ObjectiveRow::type);
  return row == kObjectiveRows.end() ? nullptr : row;
}

namespace detail {

template <class Wanted>
constexpr auto types_where(Wanted wanted) {
  constexpr auto kSize = static_cast<std::size_t>(std::ranges::count_if(kObjectiveRows, Wanted{}));
  std::array<std::string_view, kSize> types;
  std::size_t next = 0;
  for (const ObjectiveRow& row : kObjectiveRows) {
    if (wanted(row)) types[next++] = row.type;
  }
  return types;
}

}  // namespace detail

/// The types a problem file may name for one robot.
inline constexpr auto kObjectiveTypes =
    detail::types_where([](const ObjectiveRow& row) { return row.in_files && !row.of_fleet; });
/// Those of them that judge a step by itself, whatever came before.
inline constexpr auto kPlainObjectiveTypes = detail::types_where(
    [](const ObjectiveRow& row) { return row.in_files && !row.of_fleet && !row.looks_back; });
/// The types that a problem file with `fleet` may name for its robots together.
inline constexpr auto kFleetObjectiveTypes =
    detail::types_where([](const ObjectiveRow& row) { return row.of_fleet; });
/// The types a problem file may name.
inline constexpr auto kFileObjectiveTypes =
    detail::types_where([](const ObjectiveRow& row) { return row.in_files; });

}  // namespace orasp
