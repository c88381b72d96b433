#include "orasp/execution/simulation.h"

#include <algorithm>
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

Simulation certain_runs(double reward, std::size_t attempts, Stop stop,
                        const SimulationOptions& options) {
  Simulation simulation;
  simulation.rewards.assign(options.runs, reward);
  simulation.attempts.assign(options.runs, attempts);
  simulation.stop = stop;
  return simulation;
}

std::optional<std::string> simulation_obstacle(const TransitionSystem& system) {
  if (!system.wide() || !system.problem().uncertain()) return std::nullopt;
  return "simulate plays attempts that may fail where every connection is handled and steps earn "
         "what they earn whatever came before; here a goal or costs between steps say otherwise";
}

}  // namespace orasp
