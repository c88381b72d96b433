#include "orasp/catalogue.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "orasp/fleet/fleet_validate.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/objectives/retried.h"
#include "orasp/model/plan_check.h"
#include "orasp/planners/planner_support.h"

namespace orasp {

namespace {

/// How many methods a refusal names.
constexpr std::size_t kMostRecommended = 4;

/// What was derived from a task once: the rules of one robot, or of several.
struct Derived {
  std::optional<TransitionSystem> system;
  std::optional<FleetProblem> fleet;

  explicit Derived(const Task& task) {
    if (!task.problem.objective().of_fleet()) {
      system.emplace(task.problem, task.situation);
      if (task.steps)
        throw InputError("a horizon of " + std::to_string(*task.steps) +
                         " steps is for the objectives makespan and fleet_travel of several "
                         "robots; one robot makes a step for every connection");
      return;
    }
    fleet.emplace(task.problem);
    if (!task.whole())
      throw InputError("the objective " + task.problem.objective().type +
                       " is one of several robots, whose plans are made for the whole product and "
                       "not for what is left of it");
  }

  [[nodiscard]] Request request(const Task& task, const Options& options,
                                const Budget& budget) const {
    return {.task = task,
            .system = system ? &*system : nullptr,
            .fleet = fleet ? &*fleet : nullptr,
            .options = options,
            .budget = budget};
  }
};

/// What the columns of the table say without a look at the row's own limits.
std::optional<std::string> wrong_kind(const Planner& planner, const Request& request) {
  const Problem& problem = request.task.problem;
  if (request.fleet != nullptr && !planner.fleets)
    return "plans for one robot, and " + problem.objective().type + " is an objective of several";
  if (request.system != nullptr && !planner.one_robot)
    return "plans for several robots, and " + problem.objective().type + " is an objective of one";
  if (problem.uncertain() && !planner.uncertain) {
    return "plans for attempts that always succeed, and an attempt at connection \"" +
           problem.connection_id(*problem.first_uncertain()) +
           "\" may fail (its success is below 1)";
  }
  if (problem.uncertain() && request.system != nullptr && request.system->wide())
    return "plans for attempts that may fail where every connection is handled and steps earn what "
           "they earn whatever came before; here a goal or costs between steps say otherwise";
  return std::nullopt;
}

/// Where failures change nothing, and the method does not look at them itself: the problem in which
/// every attempt succeeds and costs what the attempts cost together.
std::optional<Problem> without_failures(const Planner& planner, const Request& request) {
  const bool sees_failures = planner.uncertain && planner.role != Role::Chooser;
  if (request.system == nullptr || request.system->wide() || sees_failures ||
      !request.task.problem.only_retries())
    return std::nullopt;
  return attempts_paid(request.task.problem);
}

/// The task with another problem over the same connections, which must outlive it.
Task same_task(const Problem& problem, const Task& task) {
  Task same(problem, task.situation);
  same.steps = task.steps;
  return same;
}

/// What is known of a sequence as a policy where failures change nothing. `earned` are the
/// expected rewards of its steps.
Expectation expectation_of(const Task& task, const Result& result,
                           const std::vector<double>& earned) {
  Expectation expectation;
  if (result.status != Status::Optimal)
    expectation.error = result.bound ? std::max(0.0, *result.bound - result.reward) : kInfinity;
  ConnectionSet open = task.situation.open;
  for_each_connection(task.situation.inaccessible.view(),
                      [&](ConnectionIndex connection) { open.erase(connection); });
  for (std::size_t i = 0; i < result.sequence.size(); ++i) {
    const ConnectionIndex next = result.sequence[i];
    expectation.attempts += 1 / task.problem.connections()[next].success;
    expectation.most_likely.push_back({next, true});
    expectation.policy.push_back({.open = open, .next = next});
    open.erase(next);
  }
  double still = 0;
  for (std::size_t i = result.sequence.size(); i > 0; --i) {
    still += earned[i - 1];
    expectation.policy[i - 1].reward = still;
  }
  return expectation;
}

/// What stands in the way and is seen at once.
std::optional<std::string> reason_at_sight(const Planner& planner, const Request& request) {
  if (auto reason = wrong_kind(planner, request)) return reason;
  return planner.misfit == nullptr ? std::nullopt : planner.misfit(request);
}

/// Everything that stands in the way.
std::optional<std::string> reason_against(const Planner& planner, const Request& request) {
  if (auto reason = reason_at_sight(planner, request)) return reason;
  return planner.obstacle == nullptr ? std::nullopt : planner.obstacle(request);
}

/// The refusal of `planner` with the methods that take the task, those with a proof first.
std::string refusal(const Planner& planner, const std::string& reason, const Request& request) {
  std::vector<std::string_view> others;
  for (const bool with_proof : {true, false}) {
    if (!with_proof && others.size() > 1) break;
    for (const Planner& other : planners()) {
      const bool serves = other.role == Role::Chooser || other.role == Role::Search;
      const bool proves = other.role == Role::Chooser || other.exact;
      if (others.size() == kMostRecommended || !serves || proves != with_proof ||
          &other == &planner || reason_against(other, request))
        continue;
      others.push_back(other.name);
    }
  }
  const std::string use = others.empty() ? "" : "; use " + detail::listed(others, "or");
  return std::string(planner.name) + " " + reason + use;
}

[[noreturn]] void dishonest(const Result& result, const std::string& what) {
  throw std::logic_error(result.method + " returned a plan that " + what);
}

/// @returns what the check found.
PlanCheck checked_plan(const Task& task, const Result& result) {
  PlanCheck check = result.steps.empty() ? check_plan(task.problem, task.situation, result.sequence)
                                         : check_plan(task.problem, task.situation, result.steps);
  if (!check.legal) dishonest(result, "breaks a rule: " + check.fault);
  // Where failures may change something the reward is an expectation, which no replay of one
  // sequence gives.
  if (result.expectation || same_reward(result.reward, check)) return check;
  dishonest(result, "earns " + std::to_string(check.reward) + " and not the " +
                        std::to_string(result.reward) + " that it claims");
}

void require_honest_fleet_plan(const Task& task, const Result& result) {
  const FleetProblem fleet(task.problem);
  const FleetEvaluation evaluation = evaluate(fleet, result.fleet_plan);
  if (!evaluation.valid) {
    const FleetViolation& first = evaluation.violations.front();
    dishonest(result, "breaks a rule: step " + std::to_string(first.step) + ": " + first.message);
  }
  if (task.steps && evaluation.makespan > *task.steps)
    dishonest(result, "takes more steps than allowed");
  const bool travels = task.problem.objective().type == "fleet_travel";
  const double earned =
      0.0 - (travels ? evaluation.travel : static_cast<double>(evaluation.makespan));
  constexpr double kTolerance = 1e-9;
  if (!(std::abs(earned - result.reward) <= kTolerance * std::max(1.0, std::abs(earned))))
    dishonest(result, "earns " + std::to_string(earned) + " and not the " +
                          std::to_string(result.reward) + " that it claims");
}

/// The check of solve(). @returns what was found of a plan of one robot, else nothing.
PlanCheck checked(const Task& task, const Result& result) {
  if (!result.has_plan()) return {};
  if (!task.problem.objective().of_fleet()) return checked_plan(task, result);
  require_honest_fleet_plan(task, result);
  return {};
}

/// A method's answer, and what the check found of its plan.
struct Answer {
  Result result;
  PlanCheck check;
};

Answer answered(const Planner& planner, const Request& request) {
  if (const auto reason = reason_at_sight(planner, request))
    throw InputError(refusal(planner, *reason, request));
  Result result;
  // A method's other obstacles are not asked first: to find one may cost as much as to begin the
  // work, and a method that meets one throws the same reason as a Refusal.
  try {
    result = planner.run(request);
  } catch (const Refusal& refused) {
    throw InputError(refusal(planner, refused.reason(), request));
  }
  result.seed = request.options.seed;
  // A plan that earns all that is proved possible is optimal, however the method came to its end.
  if (result.status == Status::Feasible && !result.expectation)
    detail::judge_by(result.bound, result);
  PlanCheck check = checked(request.task, result);
  return {std::move(result), std::move(check)};
}

}  // namespace

std::vector<const Planner*> one_robot_planners() {
  std::vector<const Planner*> found;
  for (const Planner& planner : planners()) {
    if (planner.one_robot) found.push_back(&planner);
  }
  return found;
}

const Planner& find_planner(std::string_view name) {
  std::vector<std::string_view> names;
  for (const Planner& planner : planners()) {
    if (planner.name == name) return planner;
    names.push_back(planner.name);
  }
  throw InputError("unknown method " + detail::in_quotes(name) + "; the methods are " +
                   detail::listed(names) + detail::suggestion(name, names));
}

std::optional<std::string> obstacle(const Task& task, std::string_view method,
                                    const Options& options, const Budget& budget) {
  const Planner& planner = find_planner(method);
  const Derived derived(task);
  const Request request = derived.request(task, options, budget);
  if (const auto certain = without_failures(planner, request))
    return obstacle(same_task(*certain, task), method, options, budget);
  const auto reason = reason_against(planner, request);
  return reason ? std::optional(refusal(planner, *reason, request)) : std::nullopt;
}

Result solve(const Task& task, std::string_view method, const Options& options,
             const Budget& budget) {
  const Planner& planner = find_planner(method);
  const Derived derived(task);
  const Request request = derived.request(task, options, budget);
  if (const auto certain = without_failures(planner, request)) {
    const Task sure = same_task(*certain, task);
    const Derived of_sure(sure);
    auto [result, check] = answered(planner, of_sure.request(sure, options, budget));
    if (result.has_plan()) result.expectation = expectation_of(task, result, check.rewards);
    return std::move(result);
  }
  return answered(planner, request).result;
}

std::optional<std::string> obstacle(const Problem& problem, std::string_view method,
                                    const Options& options, const Budget& budget) {
  return obstacle(Task(problem), method, options, budget);
}

Result solve(const Problem& problem, std::string_view method, const Options& options,
             const Budget& budget) {
  return solve(Task(problem), method, options, budget);
}

void require_honest(const Task& task, const Result& result) {
  static_cast<void>(checked(task, result));
}

}  // namespace orasp
