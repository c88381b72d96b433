#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/fleet/fleet.h"
#include "orasp/learning/dqn.h"
#include "orasp/learning/policy.h"
#include "orasp/method_options.h"
#include "orasp/model/problem.h"
#include "orasp/model/transition_system.h"
#include "orasp/planners/a_star.h"
#include "orasp/planners/bellman_ford.h"
#include "orasp/planners/value_iteration.h"
#include "orasp/symmetry/symmetry.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"
#include "orasp/task/task.h"

namespace orasp {

struct GraphPolicy;

/// The options of all methods, each with its defaults. A method's row in the table picks its own.
struct Options {
  /// Of every method that draws random numbers.
  std::uint64_t seed = 1;
  ValueIterationOptions value_iteration{};
  BellmanFordOptions bellman_ford{};
  /// The upper bound on what is left that orasp-search, a-star, beam and q-learning use.
  BoundKind bound = BoundKind::Best;
  /// Whether value-iteration, dijkstra, bellman-ford, a-star and beam take states that differ by
  /// an exchange of equal parts for one.
  SymmetryUse symmetry = SymmetryUse::Auto;
  /// How dqn trains; its seed is `seed`.
  DqnOptions dqn{};
  /// What dqn plans with; empty: it trains a policy first.
  std::shared_ptr<const Policy> policy{};
  /// Or a policy for many products. Whether the problem is of its kind is for the caller to see
  /// (require_kind() of io/graph_policy_file.h).
  std::shared_ptr<const GraphPolicy> graph_policy{};
};

/// What a row of the catalogue is handed: a task, what was derived from it once, options and
/// budget. Exactly one of `system` and `fleet` is there: the rules of one robot, or of several,
/// by the objective of the problem. A value of references, for the time of one call.
struct Request {
  const Task& task;
  const TransitionSystem* system;
  const FleetProblem* fleet;
  const Options& options;
  const Budget& budget;

  [[nodiscard]] FleetOptions fleet_options() const { return {.steps = task.steps}; }
};

/// What a method is for.
enum class Role {
  /// It chooses among the others.
  Chooser,
  /// It searches for a plan.
  Search,
  /// It looks at everything, to check the others on small problems.
  Check,
  /// A baseline that takes minutes where the others take milliseconds.
  Baseline,
  /// It learns from episodes.
  Learner,
};

/// One row of the catalogue: a method for one robot, for several, or for both.
struct Planner {
  std::string_view name;
  /// One line, for help texts.
  std::string_view summary;
  Role role = Role::Search;
  /// Proves that a plan is optimal, or that there is none, if it is not stopped.
  bool exact = false;
  /// Proves a bound on what any plan earns, and that its plan is optimal where it meets that.
  bool bounds = false;
  /// Whether it plans for one robot.
  bool one_robot = true;
  /// Whether it plans for several robots.
  bool fleets = false;
  /// Whether it plans for attempts that may fail.
  bool uncertain = false;
  /// Why the method does not take what is asked beyond what these columns say: a clause that goes
  /// on from its name. Empty where it takes it; null where nothing stands in its way. Where run()
  /// meets the same obstacle it throws the same words as a Refusal. Looks at the problem, not for a
  /// plan.
  std::optional<std::string> (*obstacle)(const Request&) = nullptr;
  /// The same of what is seen at once: solve() asks it before run(), which need not ask again.
  std::optional<std::string> (*misfit)(const Request&) = nullptr;
  Result (*run)(const Request&) = nullptr;
  /// The rows of its options; --seed and --steps are not among them, since every method takes them.
  std::span<const OptionSpec> (*options)() = no_options;
};

/// All methods, in the order of the documentation. The one table: command line, tests, docs and
/// benchmarks walk it.
[[nodiscard]] std::span<const Planner> planners();
/// Those that plan for one robot, in the same order.
[[nodiscard]] std::vector<const Planner*> one_robot_planners();

/// @throws InputError `unknown method "astr"; the methods are ...; did you mean "a-star"?`.
[[nodiscard]] const Planner& find_planner(std::string_view name);

/// Why `method` does not take `task`, in one sentence that names methods which do; empty where it
/// takes it. The only source of refusals: solve() throws this sentence.
/// @throws InputError for an unknown method, and where the task makes no sense for any method.
[[nodiscard]] std::optional<std::string> obstacle(const Task& task, std::string_view method,
                                                  const Options& options = {},
                                                  const Budget& budget = {});
/// The same for the whole of a problem.
[[nodiscard]] std::optional<std::string> obstacle(const Problem& problem, std::string_view method,
                                                  const Options& options = {},
                                                  const Budget& budget = {});

/// Answers a task by the method called `method` (see planners()): the one front door, for one robot
/// and for several, for the whole job and for what is left of it.
///
///     const Problem problem = orasp::load_scenario("hubble");
///     orasp::solve(problem, "value-iteration").reward;             // -0.9902
///     const Problem lattice = orasp::load_scenario("fleet-lattice");
///     orasp::solve(lattice, "fleet-search").fleet_plan.makespan(); // 4
///
/// Every plan is replayed by the independent check (model/plan_check.h, fleet/fleet_validate.h)
/// before it is returned: it is legal and earns what is claimed. Status::Optimal only with proof.
/// @throws InputError where the method does not take the task: obstacle().
/// @throws std::logic_error where a method's plan fails the check, which is a fault of ours.
[[nodiscard]] Result solve(const Task& task, std::string_view method, const Options& options = {},
                           const Budget& budget = {});
/// The same for the whole of a problem, which need not outlive the call.
[[nodiscard]] Result solve(const Problem& problem, std::string_view method,
                           const Options& options = {}, const Budget& budget = {});

/// The check of solve() alone, for results that did not come out of it: nothing where `result` has
/// no plan. @throws std::logic_error where its plan breaks a rule or earns another reward than
/// stated.
void require_honest(const Task& task, const Result& result);

}  // namespace orasp
