#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "orasp/model/formula.h"
#include "orasp/model/tolerance.h"

namespace orasp {

struct Step;  // model/transition_system.h

/// A point or a displacement, in metres.
using Vector3 = std::array<double, 3>;

/// `piece_cost` and the objectives that are one with fixed numbers, `cubesat` and `custom`:
/// `completion` if the step completes; else -(operation + pieces[|A|] + pieces[|B|]) if it
/// separates; else -operation.
struct PieceCost {
  double operation = 0;
  std::map<std::size_t, double>
      pieces{};  ///< cost by number of parts; 0 where a size is not listed
  double completion = 0;
};

/// `cubesat_zone`: the Markov form of the minimum-fuel CubeSat with a construction zone. No
/// parameters.
struct CubesatZone {};

/// `indexed`: n - i if i < n - 1, else -1; n connections are present, i is the connection's index
/// in the file.
struct Indexed {};

/// `time`: -(duration + transfer of the moved piece if it separates), in seconds.
struct TimeObjective {
  Vector3 depot{};
  double speed = 1;     ///< m/s, above 0
  double transfer = 1;  ///< s, used where a part of the moved piece has no position
};

/// `travel`: -(parts in the moved piece) * squared distance of its centroid to the depot, if it
/// separates.
struct Travel {
  Vector3 depot{};
};

/// `fuel`: propellant in kg of a low-thrust tug that flies out empty and back with the moved piece.
struct Fuel {
  double dry_mass = 6;  ///< kg
  double delta_v = 30;  ///< m/s
  double isp = 200;     ///< s, above 0
};

/// `completion`: +join if it separates, -step always, +bonus if it completes.
struct CompletionObjective {
  double join = 100;
  double step = 1;
  double bonus = 1000;
};

/// `expression`: a formula over the variables of FormulaVariables and named constants.
struct Expression {
  std::string formula{};
  std::map<std::string, double> constants{};
  Vector3 depot{};  ///< for the variable `distance`
  /// Set by io (parse_objective); a formula cannot be evaluated without one.
  FormulaCompiler compiler{};
};

/// Any function of the step. It must be pure and safe to call from several threads at once.
struct Callable {
  std::string name = "callable";
  std::function<double(const Step&)> reward{};
  /// Least and greatest reward that one step can earn, if known. ORASP Search needs the greatest.
  double least = -kInfinity;
  double greatest = kInfinity;
};

/// `makespan`, of a fleet: -1 for every step of the plan, in which all robots may move. No
/// parameters.
struct Makespan {};

/// `fleet_travel`, of a fleet: -(sum over all parts of the squared distance that they move in the
/// step), in square metres. No parameters.
struct FleetTravel {};

struct WeightedObjective;

/// `sum`: the weighted sum of other objectives.
struct WeightedSum {
  std::vector<WeightedObjective> terms;
};

/// What a step earns: a reward r(s, a); a plan's reward is the sum over its steps, and more is
/// better. `type` is the name in the problem file; `parameters` says which formula of
/// docs/format.md it is. Several types share a formula: `cubesat` and `custom` are PieceCost with
/// their numbers filled in.
struct Objective {
  using Parameters =
      std::variant<PieceCost, CubesatZone, Indexed, TimeObjective, Travel, Fuel,
                   CompletionObjective, Expression, Callable, WeightedSum, Makespan, FleetTravel>;
  std::string type;
  Parameters parameters;

  /// `cubesat`.
  Objective();
  Objective(std::string objective_type, Parameters objective_parameters);

  /// An objective with all parameters at their defaults. @throws InputError for an unknown type, or
  /// for `expression`, `sum` and `callable`, which have no meaning without parameters.
  [[nodiscard]] static Objective named(std::string_view type);

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

/// The types a problem file may name for one robot, in the order of the documentation.
inline constexpr std::array<std::string_view, 11> kObjectiveTypes = {
    "piece_cost", "cubesat", "cubesat_zone", "custom",     "indexed", "time",
    "travel",     "fuel",    "completion",   "expression", "sum"};
/// The types that a problem file with `fleet` may name for its robots together.
inline constexpr std::array<std::string_view, 2> kFleetObjectiveTypes = {"makespan",
                                                                         "fleet_travel"};

}  // namespace orasp
