#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/model/connection_set.h"
#include "orasp/model/tolerance.h"
#include "orasp/model/transition_system.h"
#include "orasp/model/validate.h"
#include "orasp/task/fleet_plan.h"

namespace orasp {

enum class Status {
  Optimal,     ///< a plan, proved best
  Feasible,    ///< a plan, no proof
  Infeasible,  ///< proved that no plan exists
  Unknown,     ///< stopped with neither
};

[[nodiscard]] constexpr std::string_view status_name(Status status) {
  switch (status) {
    case Status::Optimal: return "optimal";
    case Status::Feasible: return "feasible";
    case Status::Infeasible: return "infeasible";
    case Status::Unknown: break;
  }
  return "unknown";
}

/// What ended a planner before it was done.
enum class Stop { None, TimeLimit, MemoryLimit, ExpansionLimit, Cancelled };

[[nodiscard]] constexpr std::string_view stop_name(Stop stop) {
  switch (stop) {
    case Stop::TimeLimit: return "time limit";
    case Stop::MemoryLimit: return "memory limit";
    case Stop::ExpansionLimit: return "expansion limit";
    case Stop::Cancelled: return "interrupted";
    case Stop::None: break;
  }
  return "none";
}

/// Counted the same way by every planner.
struct Statistics {
  std::uint64_t states = 0;    ///< distinct states held at the end (0 for methods that hold none)
  std::uint64_t actions = 0;   ///< actions of H held at the end (0 for methods that do not build H)
  std::uint64_t expanded = 0;  ///< states whose legal actions were worked out, repeats counted
  std::uint64_t generated = 0;  ///< legal actions followed to a successor
  std::uint64_t reopened = 0;   ///< states met again by a better path
  std::uint64_t pruned =
      0;  ///< successors abandoned by a bound, or met again no better than before
  /// Passes over all states (value iteration, Bellman-Ford); episodes of a learner.
  std::uint64_t sweeps = 0;
  double seconds = 0;            ///< wall time of the planner
  std::uint64_t peak_bytes = 0;  ///< greatest size of the planner's own tables
};

/// What a policy does in one state.
struct PolicyState {
  ConnectionSet open;
  ConnectionIndex next = 0;  ///< to be attempted
  double reward = 0;         ///< expected from here on
};

/// An attempt and what came of it.
struct AttemptOutcome {
  ConnectionIndex connection = 0;
  bool succeeds = true;  ///< false: a failure that changes the state or ends the job

  [[nodiscard]] bool operator==(const AttemptOutcome&) const = default;
};

/// What is known of a policy where attempts may fail (planners/uncertain_value_iteration.h).
struct Expectation {
  double attempts = 0;  ///< expected number
  double residual = 0;  ///< the most by which Bellman's operator changes a value
  double error = 0;     ///< proved: the value of the start is within this of the optimum
  /// The likeliest course of the job: what is attempted, each until it succeeds or fails for good.
  std::vector<AttemptOutcome> most_likely;
  double probability = 1;  ///< of that course
  /// Every state that the policy can meet, but the goal: the start first, then most open first.
  std::vector<PolicyState> policy;
};

/// What a method answers, for one robot or for several. A value; the caller owns it.
struct Result {
  std::string method;
  Status status = Status::Unknown;
  Stop stop = Stop::None;
  /// A plan of one robot: all connections in the order of the problem's direction. Empty without a
  /// plan, and where the objective is one of several robots.
  std::vector<ConnectionIndex> sequence;
  /// The same plan step by step, where there is more to steps (TransitionSystem::wide); else empty.
  std::vector<PlanStep> steps;
  /// A plan of several robots; without steps where there is none.
  FleetPlan fleet_plan;
  /// The most steps that the least travel was sought within; empty for every other objective.
  std::optional<std::size_t> steps_allowed;
  double reward = -kInfinity;   ///< of the plan
  std::optional<double> bound;  ///< proved upper bound on any plan's reward
  Statistics statistics;
  std::uint64_t seed = 1;
  /// What the user should know beyond the figures, a sentence each: why there is no plan, what else
  /// the result holds.
  std::vector<std::string> notes;
  /// value-iteration: best reward still to come from each state of H; bellman-ford: best reward
  /// from the start to each state of H (indexed by StateId, -infinity where there is none). Empty
  /// for other planners, and where value-iteration did without H.
  std::vector<double> values;
  /// Where attempts may fail: `reward` and `bound` are expectations, and this is the policy.
  std::optional<Expectation> expectation;

  [[nodiscard]] bool has_plan() const {
    return status == Status::Optimal || status == Status::Feasible;
  }
  /// The proved bound as people should see it; empty where none is known. A bound and a reward are
  /// sums of the same numbers in another order: what rounding did to them is no gap.
  [[nodiscard]] std::optional<double> shown_bound() const {
    if (status == Status::Optimal) return reward;
    if (!bound || !std::isfinite(*bound)) return std::nullopt;
    return has_plan() && *bound < reward ? reward : *bound;
  }
};

/// The plan of a result of one robot, replayed (model/validate.h).
[[nodiscard]] inline Evaluation evaluate(const TransitionSystem& system, const Result& result) {
  return result.steps.empty() ? evaluate(system, std::span<const ConnectionIndex>(result.sequence))
                              : evaluate(system, std::span<const PlanStep>(result.steps));
}

}  // namespace orasp
