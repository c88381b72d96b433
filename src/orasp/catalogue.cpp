#include "orasp/catalogue.h"

#include <algorithm>
#include <array>
#include <string>

#include "orasp/fleet/fleet_expander.h"
#include "orasp/learning/network.h"
#include "orasp/mip/mip_solver.h"
#include "orasp/planners/automatic.h"
#include "orasp/planners/uncertain.h"

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
            },
            [](const FleetProblem& fleet, const FleetOptions& options, const Budget& budget) {
              const bool fits = fleet.num_parts() <= kFleetMaxParts;
              FleetResult result =
                  fits ? fleet_search(fleet, options, budget) : fleet_fast(fleet, options, budget);
              result.method = "auto";
              result.notes.insert(
                  result.notes.begin(),
                  fits ? "auto: fleet-search, since the problem has a fleet of robots"
                       : "auto: fast, since fleet-search takes at most " +
                             std::to_string(kFleetMaxParts) + " parts");
              return result;
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
    Planner{"beam", "complete anytime beam search: a plan at once, better ones as it goes", true,
            false, 0, always,
            [](const TransitionSystem& system, const Options& options, const Budget& budget) {
              return beam(system, {.bound = options.bound}, budget);
            }},
    Planner{"and-or", "piece by piece: AND/OR search over connected sets of parts", false, false, 0,
            always,
            [](const TransitionSystem& system, const Options&, const Budget& budget) {
              return and_or(system, {}, budget);
            }},
    Planner{"mip",
            "an integer program, solved by CBC: the baseline (at most 32 connections, or a fleet)",
            true, false, kMipMaxConnections, mip_solver_available,
            [](const TransitionSystem& system, const Options&, const Budget& budget) {
              return mip(system, budget);
            },
            fleet_mip},
    Planner{"exhaustive", "every sequence, for checking (at most 12 connections)", true, false,
            kExhaustiveMaxConnections, always,
            [](const TransitionSystem& system, const Options&, const Budget& budget) {
              return exhaustive(system, budget);
            }},
    Planner{"greedy", "the best reward at every step; any size, no proof", false, false, 0, always,
            [](const TransitionSystem& system, const Options&, const Budget& budget) {
              return greedy(system, budget);
            },
            fleet_greedy},
    Planner{"random", "a uniformly random legal sequence", false, false, 0, always,
            [](const TransitionSystem& system, const Options& options, const Budget& budget) {
              return random_sequence(system, {.seed = options.seed}, budget);
            }},
    Planner{"q-learning", "tabular Q-learning from optimistic values; for small problems", true,
            false, 0, always,
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
    Planner{"fleet-search",
            "several robots: the fewest steps, or the least travel, by search with proof", true,
            false, 0, always, nullptr, fleet_search},
    Planner{"fast",
            "several robots: a published heuristic for trees, subassemblies side by side; no proof",
            false, false, 0, always, nullptr, fleet_fast},
};
static_assert(std::ranges::is_partitioned(kPlanners, [](const Planner& planner) {
  return planner.run != nullptr;
}));

/// Where attempts may fail only the stochastic shortest path answers; the other methods would
/// promise what a plan earns when nothing fails.
Result solve_with_failures(const TransitionSystem& system, const Planner& planner,
                           const Options& options, const Budget& budget) {
  const Problem& problem = system.problem();
  if (planner.name != "auto" && planner.name != "value-iteration") {
    throw InputError(std::string(planner.name) +
                     " plans for attempts that always succeed, and an attempt at connection \"" +
                     problem.connection_id(*problem.first_uncertain()) +
                     "\" may fail (its success is below 1); use value-iteration or auto");
  }
  return uncertain_value_iteration(system, options.value_iteration, budget);
}

}  // namespace

std::span<const Planner> planners() {
  return kPlanners;
}

std::span<const Planner> one_robot_planners() {
  const auto* const end = std::ranges::find(kPlanners, nullptr, &Planner::run);
  return {kPlanners.begin(), end};
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
  if (planner.run == nullptr)
    throw InputError(std::string(method) + " plans for several robots, not for one");
  const TransitionSystem system(problem);
  Result result = problem.uncertain() ? solve_with_failures(system, planner, options, budget)
                                      : planner.run(system, options, budget);
  result.seed = options.seed;
  return result;
}

FleetResult solve_fleet(const FleetProblem& fleet, std::string_view method,
                        const FleetOptions& options, const Budget& budget) {
  const Planner& planner = find_planner(method);
  if (planner.run_fleet == nullptr)
    throw InputError(std::string(method) + " plans for one robot, not for several");
  FleetResult result = planner.run_fleet(fleet, options, budget);
  result.seed = options.seed;
  return result;
}

}  // namespace orasp
