#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

#include "orasp/fleet/fleet_heuristics.h"
#include "orasp/fleet/fleet_mip.h"
#include "orasp/fleet/fleet_result.h"
#include "orasp/fleet/fleet_search.h"
#include "orasp/learning/dqn.h"
#include "orasp/learning/policy.h"
#include "orasp/learning/q_learning.h"
#include "orasp/mip/mip.h"
#include "orasp/model/problem.h"
#include "orasp/planners/a_star.h"
#include "orasp/planners/and_or.h"
#include "orasp/planners/beam.h"
#include "orasp/planners/bellman_ford.h"
#include "orasp/planners/dijkstra.h"
#include "orasp/planners/exhaustive.h"
#include "orasp/planners/greedy.h"
#include "orasp/planners/orasp_search.h"
#include "orasp/planners/random_sequence.h"
#include "orasp/planners/value_iteration.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// The options of all planners, each with its defaults. A planner's row in the table picks its own.
struct Options {
  std::uint64_t seed = 1;  ///< of every planner that draws random numbers
  ValueIterationOptions value_iteration;
  BellmanFordOptions bellman_ford;
  BoundKind bound = BoundKind::Best;     ///< of orasp-search, a-star, beam and q-learning
  DqnOptions dqn;                        ///< but for its seed
  std::shared_ptr<const Policy> policy;  ///< of dqn: plan with it; empty: train first
};

/// One row of the catalogue: a method for one robot, for several, or for both.
struct Planner {
  std::string_view name;
  std::string_view summary;       ///< one line, for help texts
  bool exact = false;             ///< proves optimality or infeasibility if it is not stopped
  bool builds_graph = false;      ///< needs H in memory
  std::size_t max_connections;    ///< refuses larger problems; 0: no limit of its own
  bool (*available)() = nullptr;  ///< false where a library was left out of the build
  Result (*run)(const TransitionSystem&, const Options&, const Budget&) = nullptr;
  /// Of a method for several robots; empty for the others.
  FleetResult (*run_fleet)(const FleetProblem&, const FleetOptions&, const Budget&) = nullptr;
};

/// All planners, in the order of the documentation. The one table: command line, tests, docs and
/// benchmarks walk it. Methods for fleets alone (no `run`) come last.
[[nodiscard]] std::span<const Planner> planners();
/// Those that plan for one robot (with `run`).
[[nodiscard]] std::span<const Planner> one_robot_planners();

/// @throws InputError `unknown method 'astr'; known: ...`.
[[nodiscard]] const Planner& find_planner(std::string_view name);

/// Runs the planner called `method` (see planners()). Every plan it returns is legal;
/// Status::Optimal only with proof. Exceptions: InputError only.
///
///     const Problem problem = orasp::load_scenario("hubble");
///     const Result result = orasp::solve(problem, "value-iteration");
///     result.reward;    // -0.9902
[[nodiscard]] Result solve(const Problem& problem, std::string_view method,
                           const Options& options = {}, const Budget& budget = {});

/// Runs a method for several robots; "auto" chooses one and says which.
///
///     const Problem problem = orasp::load_scenario("fleet-lattice");
///     const FleetResult result = orasp::solve_fleet(FleetProblem(problem), "fleet-search");
///     result.plan.makespan();    // 4
[[nodiscard]] FleetResult solve_fleet(const FleetProblem& fleet, std::string_view method,
                                      const FleetOptions& options = {}, const Budget& budget = {});

}  // namespace orasp
