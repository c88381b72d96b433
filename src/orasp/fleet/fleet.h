#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/model/connection_set.h"
#include "orasp/model/problem.h"

namespace orasp {

/// Several robots take a product apart in synchronous steps (Culbertson, Bandyopadhyay and
/// Schwager, IROS 2019).
///
/// A part without connections is in the depot; every subassembly has a site of its own. In a step
/// each part has one motion: it stays, or it moves along one signed axis. A connection is cut by
/// the motions of its two parts and nothing else: equal motions keep it, other motions must pull it
/// apart along its axis. A part that moves or leaves its site needs a robot of its own; a part that
/// stays cannot change its site, except for the depot. docs/format.md, section "Fleet problems",
/// states every rule.

/// Place 0 is the depot, place s is site s, in the order of the problem file.
using PlaceIndex = std::uint32_t;
inline constexpr PlaceIndex kDepot = 0;

/// How a part moves in a step: 0 stays, d + 1 goes along direction d of kDirectionNames.
using Motion = std::uint8_t;
inline constexpr Motion kStay = 0;
inline constexpr std::size_t kNumMotions = kDirectionNames.size() + 1;
[[nodiscard]] constexpr Motion motion_along(std::size_t direction) {
  return static_cast<Motion>(direction + 1);
}
/// Of a motion that is not kStay.
[[nodiscard]] constexpr std::size_t direction_of(Motion motion) {
  return motion - std::size_t{1};
}
/// "stay", "+x" ... "-z".
[[nodiscard]] constexpr std::string_view motion_name(Motion motion) {
  return motion == kStay ? std::string_view("stay") : kDirectionNames[direction_of(motion)];
}

/// A fleet problem: a checked view on a Problem, which must outlive it. Immutable. Indices of parts
/// and connections are those of the problem.
///
///     const Problem problem = load_scenario("fleet-lattice");
///     const FleetProblem fleet(problem);            // InputError where something is missing
///     fleet.robots();                               // 4
///     fleet.squared_distance(kDepot, 2);            // 5 m^2
class FleetProblem {
 public:
  /// @throws InputError with one sentence: no `fleet`, no site, a connection without `axis` or of a
  /// part to itself,
  ///         an attempt that may fail, the direction assembly (a plan read backwards assembles).
  explicit FleetProblem(const Problem& problem);
  /// A problem that goes out of scope at once.
  explicit FleetProblem(Problem&&) = delete;

  [[nodiscard]] const Problem& problem() const { return *problem_; }
  [[nodiscard]] std::size_t num_parts() const { return problem_->num_parts(); }
  [[nodiscard]] std::size_t num_connections() const { return problem_->num_connections(); }
  [[nodiscard]] std::size_t robots() const { return problem_->spec().fleet->robots; }
  [[nodiscard]] std::size_t num_sites() const { return problem_->spec().fleet->sites.size(); }
  /// Depot and sites: num_sites() + 1.
  [[nodiscard]] std::size_t num_places() const { return num_sites() + 1; }
  /// Coordinates in m.
  [[nodiscard]] const std::array<double, 2>& place(PlaceIndex place) const {
    return place == kDepot ? problem_->spec().fleet->depot
                           : problem_->spec().fleet->sites[place - 1];
  }
  /// "depot", "site 1".
  [[nodiscard]] static std::string place_name(PlaceIndex place);
  /// What moving one part from `a` to `b` counts in the objective travel, in m^2.
  [[nodiscard]] double squared_distance(PlaceIndex a, PlaceIndex b) const;

  /// The direction (of kDirectionNames) in which the first part of connection `c` comes off the
  /// second.
  [[nodiscard]] std::size_t axis(ConnectionIndex c) const { return axis_[c]; }
  /// Spatial axes that are needed: 1 (x), 2 (x, y) or 3.
  [[nodiscard]] std::size_t dimensions() const { return dimensions_; }
  /// Whether these motions of its first and its second part pull connection `c` apart.
  [[nodiscard]] bool pulls_apart(ConnectionIndex c, Motion first, Motion second) const {
    const Motion away = motion_along(axis_[c]);
    const Motion back = motion_along(opposite(axis_[c]));
    return first == away ? second == kStay || second == back : first == kStay && second == back;
  }
  /// Subassemblies that there may be after a step, and at the start: one a site, and the limit of
  /// the problem.
  [[nodiscard]] std::size_t most_subassemblies() const { return most_subassemblies_; }

  /// Why there is no plan, where that shows without search; empty where search must tell.
  [[nodiscard]] std::optional<std::string> infeasibility() const;

 private:
  const Problem* problem_;
  std::vector<std::size_t> axis_;
  std::size_t dimensions_ = 1;
  std::size_t most_subassemblies_ = 0;
};

/// A block that robots hold in a step: one part that leaves for the depot, or a subassembly that
/// moves.
struct FleetMove {
  std::vector<PartIndex> parts;     ///< ascending
  std::vector<std::size_t> robots;  ///< from 1, one for each part, in the order of `parts`
  PlaceIndex from = kDepot;
  PlaceIndex to = kDepot;
  Motion motion = kStay;
  double distance = 0;  ///< m^2: squared distance, summed over the parts

  friend bool operator==(const FleetMove&, const FleetMove&) = default;
};

struct FleetStep {
  std::vector<ConnectionIndex> cut;  ///< ascending
  std::vector<FleetMove> moves;      ///< by their first part
  std::size_t robots_used = 0;
  double distance = 0;  ///< m^2, of all moves

  friend bool operator==(const FleetStep&, const FleetStep&) = default;
};

/// A plan in the order of disassembly.
struct FleetPlan {
  std::vector<PlaceIndex> start;  ///< of each part
  std::vector<FleetStep> steps;

  [[nodiscard]] std::size_t makespan() const { return steps.size(); }
  /// m^2, of all steps.
  [[nodiscard]] double travel() const;
  /// All connections in the order in which they are cut.
  [[nodiscard]] std::vector<ConnectionIndex> sequence() const;

  friend bool operator==(const FleetPlan&, const FleetPlan&) = default;
};

/// What stands where.
struct FleetState {
  ConnectionSet open;              ///< connections not yet cut
  std::vector<PlaceIndex> places;  ///< of each part

  friend bool operator==(const FleetState&, const FleetState&) = default;
};

/// The whole product with its pieces at these sites, one for each part (the depot for a part
/// without connections).
[[nodiscard]] FleetState fleet_start(const FleetProblem& fleet, std::span<const PlaceIndex> places);

/// The step that these motions and new places of all parts make, and the state after it in `state`.
/// Follows the rules, does not check them (fleet/fleet_validate.h does): cuts every connection
/// whose parts move differently, and gives robots from 1 to the parts that move or leave.
[[nodiscard]] FleetStep fleet_step(const FleetProblem& fleet, FleetState& state,
                                   std::span<const Motion> motions,
                                   std::span<const PlaceIndex> places);

}  // namespace orasp
