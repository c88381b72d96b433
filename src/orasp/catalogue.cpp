#include "orasp/catalogue.h"

#include <array>
#include <string>

#include "orasp/learning/network.h"
#include "orasp/planners/automatic.h"

namespace orasp {

namespace {

bool always() {
  return true;
}

constexpr std::array kPlanners = {
    Planner{"auto", "chooses a method by the size of the problem and says which", false, false, 0,
            always,
            [](const TransitionSystem& system, const Options& options, const Budget& budget) {
              return automatic(system, options.seed, budget);
            }},
    Planner{"value-iteration", "the paper's graph-based value iteration on H", true, true, 0,
            always,
            [](const TransitionSystem& system, const Options& options, const Budget& budget) {
              return value_iteration(system, options.value_iteration, budget);
            }},
    Planner{"dijkstra", "shortest path on H", true, true, 0, always,
            [](const TransitionSystem& system, const Options&, const Budget& budget) {
              return dijkstra(system, budget);
            }},
    Planner{"bellman-ford", "best reward from the start to every state of H", true, true, 0, always,
            [](const TransitionSystem& system, const Options& options, const Budget& budget) {
              return bellman_ford(system, options.bellman_ford, budget);
            }},
    Planner{"orasp-search",
            "the paper's ORASP Search: depth-first branch and bound that generates H as it goes",
            true, false, 0, always,
            [](const TransitionSystem& system, const Options& options, const Budget& budget) {
              return orasp_search(system, {.seed = options.seed, .bound = options.bound}, budget);
            }},
    Planner{"a-star", "best first on H, guided by an upper bound on what is left", true, false, 0,
            always,
            [](const TransitionSystem& system, const Options& options, const Budget& budget) {
              return a_star(system, {.bound = options.bound}, budget);
            }},
    Planner{"beam", "complete anytime beam search: a plan at once, better ones as it goes", true, false, 0,
            always,
            [](const TransitionSystem& system, const Options& options, const Budget& budget) {
              return beam(system, {.bound = options.bound}, budget);
            }},
    Planner{"and-or", "piece by piece: AND/OR search over connected sets of parts", false, false, 0,
            always,
            [](const TransitionSystem& system, const Options&, const Budget& budget) {
              return and_or(system, {}, budget);
            }},
    Planner{"exhaustive", "every sequence, for checking (at most 12 connections)", true, false,
            kExhaustiveMaxConnections, always,
            [](const TransitionSystem& system, const Options&, const Budget& budget) {
              return exhaustive(system, budget);
            }},
    Planner{"greedy", "the best reward at every step; any size, no proof", false, false, 0, always,
            [](const TransitionSystem& system, const Options&, const Budget& budget) {
              return greedy(system, budget);
            }},
    Planner{"random", "a uniformly random legal sequence", false, false, 0, always,
            [](const TransitionSystem& system, const Options& options, const Budget& budget) {
              return random_sequence(system, {.seed = options.seed}, budget);
            }},
    Planner{"q-learning", "tabular Q-learning from optimistic values; for small problems", true, false, 0, always,
            [](const TransitionSystem& system, const Options& options, const Budget& budget) {
              return q_learning(system, {.seed = options.seed, .bound = options.bound}, budget);
            }},
    Planner{"dqn", "a deep Q-network, trained first unless a policy is given", false, false, 0,
            network_available,
            [](const TransitionSystem& system, const Options& options, const Budget& budget) {
              if (options.policy) return follow_policy(system, *options.policy, budget);
              DqnOptions chosen = options.dqn;
              chosen.seed = options.seed;
              return dqn(system, chosen, budget);
            }},
};

}  // namespace

std::span<const Planner> planners() {
  return kPlanners;
}

const Planner& find_planner(std::string_view name) {
  std::string known;
  for (const Planner& planner : kPlanners) {
    if (planner.name == name) return planner;
    known += (known.empty() ? "" : ", ") + std::string(planner.name);
  }
  throw InputError("unknown method '" + std::string(name) + "'; known: " + known);
}

Result solve(const Problem& problem, std::string_view method, const Options& options,
             const Budget& budget) {
  const Planner& planner = find_planner(method);
  const TransitionSystem system(problem);
  Result result = planner.run(system, options, budget);
  result.seed = options.seed;
  return result;
}

}  // namespace orasp
