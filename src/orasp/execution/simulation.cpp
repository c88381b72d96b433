#include "orasp/execution/simulation.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <unordered_map>

#include "orasp/model/random.h"

namespace orasp {

namespace {

/// So many attempts are made between two looks at the clock.
constexpr std::uint64_t kPollEvery = 256;

}  // namespace

UncertainGraph::Guide guide_by_plan(std::span<const ConnectionIndex> sequence) {
  return [plan = std::vector(sequence.begin(), sequence.end())](
             SetView open) -> std::optional<ConnectionIndex> {
    const auto next =
        std::ranges::find_if(plan, [open](ConnectionIndex c) { return contains(open, c); });
    if (next == plan.end()) return std::nullopt;
    return *next;
  };
}

UncertainGraph::Guide guide_by_policy(const TransitionSystem& system,
                                      std::span<const PolicyState> policy) {
  struct Entries {
    explicit Entries(const TransitionSystem& rules) : system(rules), expander(rules) {}
    const TransitionSystem& system;
    Expander expander;
    std::unordered_map<ConnectionSet, ConnectionIndex> next;
  };
  auto entries = std::make_shared<Entries>(system);
  for (const PolicyState& state : policy) entries->next.emplace(state.open, state.next);
  return [entries](SetView open) -> std::optional<ConnectionIndex> {
    const Problem& problem = entries->system.problem();
    const auto found = entries->next.find(ConnectionSet(entries->system.num_connections(), open));
    if (found == entries->next.end()) {
      throw InputError("the policy says nothing for a state that it leads to, with " +
                       std::to_string(count(open)) + " connections still open");
    }
    if (!entries->expander.legal(open, found->second)) {
      throw InputError("the policy attempts connection \"" + problem.connection_id(found->second) +
                       "\" where that is not legal, with " + std::to_string(count(open)) +
                       " connections still open");
    }
    return found->second;
  };
}

Simulation simulate(const UncertainGraph& graph, std::span<const std::uint32_t> choice,
                    std::span<const ConnectionIndex> plan, const SimulationOptions& options,
                    const Budget& budget) {
  const Problem& problem = graph.system().problem();
  const std::size_t connections = graph.system().num_connections();
  Simulation simulation;
  SplitMix64 seeds(options.seed);
  std::uint64_t polled = 0;
  for (std::uint64_t run = 0; run < options.runs; ++run) {
    SplitMix64 random(seeds.next());
    double reward = 0;
    std::uint64_t attempts = 0;
    std::uint64_t replanned = 0;
    bool aborted = false;
    // All connections of the plan before this place are handled or have come off.
    std::size_t place = 0;
    ConnectionSet came_off(connections);
    UncertainGraph::State s = 0;
    // Whether the last attempt led to another state.
    bool arrived = true;
    while (choice[s] != UncertainSolution::kNone) {
      if (polled++ % kPollEvery == 0) {
        budget.report({.phase = "runs", .done = run, .total = options.runs});
        simulation.stop = budget.expired();
        if (simulation.stop != Stop::None) return simulation;
      }
      if (arrived && !plan.empty()) {
        bool interrupted = !graph.guided(s);
        for (; place < plan.size() && !contains(graph.state(s), plan[place]); ++place)
          interrupted = interrupted || came_off.contains(plan[place]);
        if (interrupted) ++replanned;
      }
      const UncertainGraph::Attempt& attempt = graph.attempts(s)[choice[s]];
      const Connection& tried = problem.connections()[attempt.connection];
      ++attempts;
      const bool succeeds = tried.success == 1 || random.uniform() < tried.success;
      if (!succeeds && attempt.failed == UncertainGraph::kJobEnded) {
        reward += *tried.on_failure.abort;
        aborted = true;
        break;
      }
      reward += attempt.reward;
      const UncertainGraph::State next = succeeds ? attempt.done : attempt.failed;
      arrived = next != s;
      if (!succeeds && arrived) {
        for (const ConnectionIndex c : problem.breaks(attempt.connection)) {
          if (contains(graph.state(s), c)) came_off.insert(c);
        }
      }
      s = next;
    }
    simulation.rewards.push_back(reward);
    simulation.attempts.push_back(attempts);
    simulation.replanned += replanned;
    if (aborted) ++simulation.aborted;
  }
  return simulation;
}

std::optional<std::string> simulation_obstacle(const TransitionSystem& system) {
  if (!system.wide() || !system.problem().uncertain()) return std::nullopt;
  return "simulate plays attempts that may fail where every connection is handled and steps earn "
         "what they earn whatever came before; here a goal or costs between steps say otherwise";
}

namespace {

/// @throws InputError for a plan that is not legal where nothing fails.
void require_legal(const Evaluation& plan) {
  if (plan.valid) return;
  const StepViolation& first = plan.violations.front();
  throw InputError("the plan cannot be followed: step " + std::to_string(first.step) + ", " +
                   in_quotes(first.connection) + ": " + first.violation.message);
}

/// Half of the time that is left.
Budget half_of(const Budget& budget) {
  Budget half = budget;
  if (half.deadline) *half.deadline -= (*half.deadline - Budget::Clock::now()) / 2;
  return half;
}

/// Where every attempt succeeds, a plan goes as it stands.
Followed certainly_followed(const Evaluation* plan,
                            const std::function<Result(const Budget&)>& find,
                            const SimulationOptions& options, const Budget& budget) {
  Followed found;
  std::size_t attempts = 0;
  if (plan != nullptr) {
    found.expected = plan->reward;
    attempts = plan->steps.size();
  } else {
    const Result result = find(budget);
    found.simulation.stop = result.stop;
    if (!result.has_plan()) {
      found.status = result.status;
      found.notes = result.notes;
      return found;
    }
    found.proved_best = result.status == Status::Optimal;
    found.expected = result.reward;
    attempts = result.steps.empty() ? result.sequence.size() : result.steps.size();
  }
  found.status = Status::Feasible;
  found.expected_attempts = static_cast<double>(attempts);
  found.simulation.rewards.assign(options.runs, found.expected);
  found.simulation.attempts.assign(options.runs, attempts);
  return found;
}

}  // namespace

Followed follow(const TransitionSystem& system, const Evaluation* plan,
                const std::vector<PolicyState>* policy,
                const std::function<Result(const Budget&)>& find, const SimulationOptions& options,
                const Budget& budget) {
  if (plan != nullptr) require_legal(*plan);
  if (system.wide()) return certainly_followed(plan, find, options, budget);
  Followed found;
  if (const std::optional<Violation> reason = system.infeasibility()) {
    found.status = Status::Infeasible;
    found.notes = {reason->message};
    return found;
  }
  UncertainGraph::Guide guide;
  if (plan != nullptr) {
    for (const Step& step : plan->steps) found.plan.push_back(step.connection);
    guide = guide_by_plan(found.plan);
  } else if (policy != nullptr) {
    guide = guide_by_policy(system, *policy);
  } else {
    const Result result = find(half_of(budget));
    if (!result.has_plan()) {
      found.status = result.status;
      found.simulation.stop = result.stop;
      found.notes = result.notes;
      return found;
    }
    found.proved_best = result.status == Status::Optimal;
    guide = result.expectation ? guide_by_policy(system, result.expectation->policy)
                               : guide_by_plan(result.sequence);
  }
  const UncertainGraph graph = UncertainGraph::build(system, budget, guide);
  if (graph.stop() != Stop::None) {
    found.simulation.stop = graph.stop();
    found.notes = {"stopped before all states were known that attempts lead to"};
    return found;
  }
  const UncertainSolution solution = solve_uncertain(graph);
  if (!std::isfinite(solution.values[0])) {
    found.status = Status::Infeasible;
    found.notes = {plan == nullptr
                       ? "whatever is attempted, a state may be met that has no legal step"
                       : "the plan may end in a state that has no legal step, and its expected "
                         "reward is minus infinity; `orasp solve` finds a policy that cannot, if "
                         "there is one"};
    return found;
  }
  found.status = Status::Feasible;
  found.expected = solution.values[0];
  found.expected_attempts = solution.attempts[0];
  found.simulation = simulate(graph, solution.choice, found.plan, options, budget);
  return found;
}

}  // namespace orasp
