#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "orasp/model/formula.h"
#include "orasp/model/objectives/objective_table.h"
#include "orasp/model/vector3.h"

namespace orasp {

/// What a step earns: a reward r(s, a); a plan's reward is the sum over its steps, and more is
/// better. `type` is the name in the problem file, `parameters` are those of its formula in
/// docs/format.md. Several types share a formula: `cubesat` and `custom` are a PieceCost whose
/// numbers are fixed. objectives/objective_table.h lists all types.
struct Objective {
  using Parameters = ObjectiveParameters;
  std::string type;
  Parameters parameters;

  /// `cubesat`.
  Objective();
  Objective(std::string objective_type, Parameters objective_parameters);

  /// An objective with all parameters at their defaults. @throws InputError for an unknown type, or
  /// for `expression`, `sum` and `callable`, which have no meaning without parameters.
  [[nodiscard]] static Objective named(std::string_view type);

  /// The type that the user stated: of a Retried, that of one attempt.
  [[nodiscard]] const std::string& stated_type() const;

  /// Whether it judges plans of several robots (kFleetObjectiveTypes) and no plan of one.
  [[nodiscard]] bool of_fleet() const;
};

struct WeightedObjective {
  double weight = 1;
  Objective objective;
};

/// How deep a `sum` may hold further sums: 1 for a sum of plain objectives.
inline constexpr std::size_t kMaxSumDepth = 16;

/// Checks what can be checked without an assembly: `type` and `parameters` fit, every number is
/// finite and in range, the formula compiles. Problem's constructor calls it; `place` stands in
/// front of error messages.
/// @throws InputError with one sentence for the first fault.
void check_objective(const Objective& objective, const std::string& place);

}  // namespace orasp
