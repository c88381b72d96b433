// The table of methods, in a file of its own: a program that is linked with another `planners()`
// gets that one, which is how a test gives the command line methods that answer wrongly.

#include <array>

#include "orasp/catalogue.h"
#include "orasp/fleet/fleet_heuristics.h"
#include "orasp/fleet/fleet_mip.h"
#include "orasp/fleet/fleet_search.h"
#include "orasp/learning/graph_policy.h"
#include "orasp/learning/network.h"
#include "orasp/learning/policy_advice.h"
#include "orasp/learning/q_learning.h"
#include "orasp/mip/mip.h"
#include "orasp/mip/mip_solver.h"
#include "orasp/planners/and_or.h"
#include "orasp/planners/automatic.h"
#include "orasp/planners/beam.h"
#include "orasp/planners/dense_value_iteration.h"
#include "orasp/planners/detail/wide_search.h"
#include "orasp/planners/dijkstra.h"
#include "orasp/planners/exhaustive.h"
#include "orasp/planners/greedy.h"
#include "orasp/planners/orasp_search.h"
#include "orasp/planners/planner_support.h"
#include "orasp/planners/random_sequence.h"
#include "orasp/planners/symmetric_graph.h"
#include "orasp/planners/uncertain_search.h"
#include "orasp/planners/uncertain_value_iteration.h"

namespace orasp {
namespace {

using Reason = std::optional<std::string>;

/// Whether the problem is answered before a method looks at what it needs: no plan exists at sight.
bool settled_at_sight(const Request& request) {
  return request.system != nullptr && request.system->infeasibility().has_value();
}

Reason graph_needed(const Request& request) {
  if (settled_at_sight(request)) return std::nullopt;
  return symmetric_graph_obstacle(*request.system, request.options.symmetry, kLeastSymmetryForGraph,
                                  request.budget, graph_obstacle(*request.system, request.budget));
}

/// How many times smaller H must be up to symmetry for value iteration to build it so by itself.
double least_symmetry_for_values(const Request& request) {
  const TransitionSystem& system = *request.system;
  const bool by_table = request.options.value_iteration == ValueIterationOptions{} &&
                        dense_values_safe(system) && dense_table_fits(system, request.budget) &&
                        (unconstrained(system) || !graph_fits(system, request.budget));
  return by_table ? kLeastSymmetryForTable : kLeastSymmetryForGraph;
}

/// Whether sweeps go by layers to their end, so that their plan is final: with symmetry alone.
bool sweeps_are_whole(const ValueIterationOptions& options) {
  return options.order == ValueIterationOptions::Order::Layers &&
         options.max_sweeps == ValueIterationOptions{}.max_sweeps;
}
constexpr std::string_view kWholeSweepsNeeded =
    "uses symmetry where it sweeps by layers and to the end alone";

Reason values_needed(const Request& request) {
  const TransitionSystem& system = *request.system;
  const SymmetryUse symmetry = request.options.symmetry;
  if (request.task.problem.uncertain()) return symmetry_obstacle(system, symmetry);
  if (settled_at_sight(request)) return std::nullopt;
  auto without = value_iteration_obstacle(system, request.options.value_iteration, request.budget);
  if (sweeps_are_whole(request.options.value_iteration))
    return symmetric_graph_obstacle(system, symmetry, least_symmetry_for_values(request),
                                    request.budget, std::move(without));
  return symmetry == SymmetryUse::On ? std::string(kWholeSweepsNeeded) : without;
}

Reason bound_needed_by(const TransitionSystem& system, BoundKind kind) {
  return detail::bound_obstacle(*make_bound(system, kind), system, kind);
}

/// Of a method that looks at an assembly from its end.
Reason bound_needed(const Request& request) {
  if (settled_at_sight(request)) return std::nullopt;
  const TransitionSystem& system = *request.system;
  if (system.wide()) return detail::wide_bound_obstacle(system);
  return system.takes_apart() || system.ordered()
             ? bound_needed_by(system, request.options.bound)
             : bound_needed_by(system.backwards(), request.options.bound);
}

Reason bound_and_symmetry_needed(const Request& request) {
  if (auto reason = bound_needed(request)) return reason;
  if (settled_at_sight(request)) return std::nullopt;
  return symmetry_obstacle(*request.system, request.options.symmetry);
}

/// Beam goes on without a bound where it was not asked for a certain one.
Reason bound_asked_for(const Request& request) {
  const bool wide = request.system->wide();
  if (request.options.bound != BoundKind::Best || wide) return bound_and_symmetry_needed(request);
  if (settled_at_sight(request)) return std::nullopt;
  return symmetry_obstacle(*request.system, request.options.symmetry);
}

/// Whether a policy was given and has something to say.
bool asks_policy(const Request& request) {
  const Options& options = request.options;
  return (options.policy || options.graph_policy) && request.system != nullptr &&
         !settled_at_sight(request) && request.system->num_connections() > 0;
}

/// Why the policy that was given is none for this problem.
Reason policy_fits(const Request& request) {
  if (!asks_policy(request)) return std::nullopt;
  return request.options.graph_policy ? graph_policy_obstacle(*request.system)
                                      : policy_obstacle(*request.system, *request.options.policy);
}

/// The same for a method that only begins with the policy's plan, and looks at what it advises.
Reason advice_fits(const Request& request) {
  if (request.system == nullptr && (request.options.policy || request.options.graph_policy))
    return std::string("begins with the plan of a policy only where one robot works");
  if (!asks_policy(request)) return std::nullopt;
  if (request.system->wide()) return std::string(kPlainSteps);
  if (request.system->problem().uncertain())
    return std::string("begins with the plan of a policy only where every attempt succeeds");
  return policy_fits(request);
}

Reason pieces_needed(const Request& request) {
  if (settled_at_sight(request) || request.system->num_connections() == 0) return std::nullopt;
  if (auto reason = and_or_obstacle(*request.system)) return reason;
  return symmetry_obstacle(*request.system, request.options.symmetry);
}

Reason program_needed(const Request& request) {
  if (request.system != nullptr) {
    if (auto reason = mip_obstacle(*request.system)) return reason;
    // Such problems are answered without a solver.
    if (settled_at_sight(request) || request.system->num_steps() == 0) return std::nullopt;
  }
  return mip_solver_obstacle();
}

Reason sequences_needed(const Request& request) {
  return exhaustive_obstacle(*request.system);
}

Reason forest_needed(const Request& request) {
  return request.fleet == nullptr ? std::nullopt : fleet_heuristics_obstacle(*request.fleet);
}

Reason fleet_search_needed(const Request& request) {
  return fleet_search_obstacle(*request.fleet, request.fleet_options());
}

Reason network_needed(const Request& request) {
  const Options& options = request.options;
  if (options.policy || options.graph_policy || settled_at_sight(request) ||
      request.system->num_connections() == 0)
    return std::nullopt;
  return trains_over_pieces(*request.system, options.dqn) ? std::nullopt : network_obstacle();
}

Result run_value_iteration(const Request& request) {
  const TransitionSystem& system = *request.system;
  const ValueIterationOptions& options = request.options.value_iteration;
  const SymmetryUse symmetry = request.options.symmetry;
  if (request.task.problem.uncertain()) {
    if (auto reason = symmetry_obstacle(system, symmetry))
      throw Refusal("value-iteration", *reason);
    return uncertain_value_iteration(system, options, request.budget);
  }
  if (sweeps_are_whole(options)) {
    require_valid(options);
    auto result = on_symmetric_graph(
        system, symmetry, least_symmetry_for_values(request), request.budget, "value-iteration",
        [&](const StateGraph& graph) { return value_iteration(graph, options, request.budget); });
    if (result) return *std::move(result);
  } else if (symmetry == SymmetryUse::On && !settled_at_sight(request)) {
    throw Refusal("value-iteration", std::string(kWholeSweepsNeeded));
  }
  return value_iteration(system, options, request.budget);
}

/// What a policy that was given says: its plan, where it makes one, and advice.
struct PolicyAnswer {
  std::optional<Result> plan;
  MakeAdvice advice;

  [[nodiscard]] const Result* incumbent() const { return plan ? &*plan : nullptr; }
  [[nodiscard]] const MakeAdvice* make_advice() const { return advice ? &advice : nullptr; }
};
PolicyAnswer ask_policy(const Request& request) {
  PolicyAnswer answer;
  if (!asks_policy(request)) return answer;
  const Options& options = request.options;
  answer.plan = options.graph_policy
                    ? follow_graph_policy(*request.system, *options.graph_policy, request.budget)
                    : follow_policy(*request.system, *options.policy, request.budget);
  if (!answer.plan->has_plan()) answer.plan.reset();
  answer.advice =
      options.graph_policy ? advice_of(options.graph_policy) : advice_of(options.policy);
  return answer;
}

Result run_automatic(const Request& request) {
  const PolicyAnswer policy = ask_policy(request);
  if (request.system != nullptr) {
    if (request.task.problem.uncertain())
      return uncertain_automatic(*request.system, request.options.value_iteration, request.budget);
    return automatic(*request.system, request.options.seed, request.budget, policy.incumbent(),
                     policy.make_advice());
  }
  const FleetOptions options = request.fleet_options();
  const Reason too_large = fleet_search_obstacle(*request.fleet, options);
  Result result = too_large ? fleet_fast(*request.fleet, options, request.budget)
                            : fleet_search(*request.fleet, options, request.budget);
  result.method = "auto";
  result.notes.insert(result.notes.begin(),
                      too_large ? "auto: fast, since fleet-search " + *too_large
                                : "auto: fleet-search, since the problem has a fleet of robots");
  return result;
}

Result run_dijkstra(const Request& request) {
  auto result = on_symmetric_graph(
      *request.system, request.options.symmetry, kLeastSymmetryForGraph, request.budget, "dijkstra",
      [&](const StateGraph& graph) { return dijkstra(graph, request.budget); });
  if (result) return *std::move(result);
  return dijkstra(*request.system, request.budget);
}

Result run_bellman_ford(const Request& request) {
  auto result =
      on_symmetric_graph(*request.system, request.options.symmetry, kLeastSymmetryForGraph,
                         request.budget, "bellman-ford", [&](const StateGraph& graph) {
                           return bellman_ford(graph, {.keep_values = false}, request.budget);
                         });
  if (result) return *std::move(result);
  return bellman_ford(*request.system, request.options.bellman_ford, request.budget);
}

Result run_orasp_search(const Request& request) {
  return orasp_search(*request.system,
                      {.seed = request.options.seed,
                       .bound = request.options.bound,
                       .symmetry = request.options.symmetry},
                      request.budget);
}

Result run_a_star(const Request& request) {
  return a_star(*request.system,
                {.bound = request.options.bound, .symmetry = request.options.symmetry},
                request.budget);
}

Result run_beam(const Request& request) {
  const PolicyAnswer policy = ask_policy(request);
  return beam(*request.system,
              {.bound = request.options.bound,
               .incumbent = policy.incumbent(),
               .advice = policy.make_advice(),
               .symmetry = request.options.symmetry},
              request.budget);
}

Result run_and_or(const Request& request) {
  return and_or(*request.system, {.symmetry = request.options.symmetry}, request.budget);
}

Result run_mip(const Request& request) {
  return request.fleet != nullptr
             ? fleet_mip(*request.fleet, request.fleet_options(), request.budget)
             : mip(*request.system, request.budget);
}

Result run_exhaustive(const Request& request) {
  return exhaustive(*request.system, request.budget);
}

Result run_greedy(const Request& request) {
  return request.fleet != nullptr
             ? fleet_greedy(*request.fleet, request.fleet_options(), request.budget)
             : detail::or_quick_plan(*request.system, greedy(*request.system, request.budget));
}

Result run_random(const Request& request) {
  const std::uint64_t seed = request.options.seed;
  Result result = detail::or_quick_plan(
      *request.system, random_sequence(*request.system, {.seed = seed}, request.budget));
  result.seed = seed;
  return result;
}

Result run_q_learning(const Request& request) {
  return q_learning(*request.system, {.seed = request.options.seed, .bound = request.options.bound},
                    request.budget);
}

Result run_dqn(const Request& request) {
  const Options& options = request.options;
  if (options.graph_policy)
    return follow_graph_policy(*request.system, *options.graph_policy, request.budget);
  if (options.policy) return follow_policy(*request.system, *options.policy, request.budget);
  DqnOptions chosen = options.dqn;
  chosen.seed = options.seed;
  return dqn(*request.system, chosen, request.budget);
}

Result search_fleet(const Request& request) {
  return fleet_search(*request.fleet, request.fleet_options(), request.budget);
}

Result run_fast(const Request& request) {
  return fleet_fast(*request.fleet, request.fleet_options(), request.budget);
}

constexpr std::array kPlanners = {
    Planner{.name = "auto",
            .summary = "chooses a method by the size of the problem and says which",
            .role = Role::Chooser,
            .fleets = true,
            .uncertain = true,
            .misfit = advice_fits,
            .run = run_automatic,
            .options = policy_options},
    Planner{.name = "value-iteration",
            .summary = "the paper's graph-based value iteration on H",
            .exact = true,
            .uncertain = true,
            .obstacle = values_needed,
            .run = run_value_iteration,
            .options = sweep_options},
    Planner{.name = "dijkstra",
            .summary = "shortest path on H",
            .exact = true,
            .obstacle = graph_needed,
            .run = run_dijkstra,
            .options = symmetry_options},
    Planner{.name = "bellman-ford",
            .summary = "best reward from the start to every state of H",
            .exact = true,
            .obstacle = graph_needed,
            .run = run_bellman_ford,
            .options = symmetry_options},
    Planner{.name = "orasp-search",
            .summary = "the paper's ORASP Search: depth-first branch and bound that generates H as "
                       "it goes",
            .exact = true,
            .obstacle = bound_and_symmetry_needed,
            .run = run_orasp_search,
            .options = search_options},
    Planner{.name = "a-star",
            .summary = "best first on H, guided by an upper bound on what is left",
            .exact = true,
            .obstacle = bound_and_symmetry_needed,
            .run = run_a_star,
            .options = search_options},
    Planner{.name = "beam",
            .summary = "complete anytime beam search: a plan at once, better ones as it goes",
            .exact = true,
            .obstacle = bound_asked_for,
            .misfit = advice_fits,
            .run = run_beam,
            .options = beam_options},
    Planner{.name = "and-or",
            .summary = "piece by piece: AND/OR search over connected sets of parts",
            .bounds = true,
            .obstacle = pieces_needed,
            .run = run_and_or,
            .options = symmetry_options},
    Planner{.name = "mip",
            .summary = "an integer program, solved by CBC: the baseline (at most 32 connections, "
                       "or a fleet)",
            .role = Role::Baseline,
            .exact = true,
            .fleets = true,
            .obstacle = program_needed,
            .run = run_mip},
    Planner{.name = "exhaustive",
            .summary = "every sequence, for checking (at most 12 connections)",
            .role = Role::Check,
            .exact = true,
            .obstacle = sequences_needed,
            .run = run_exhaustive},
    Planner{.name = "greedy",
            .summary = "the best reward at every step; any size, no proof",
            .fleets = true,
            .obstacle = forest_needed,
            .run = run_greedy},
    Planner{.name = "random", .summary = "a uniformly random legal sequence", .run = run_random},
    Planner{.name = "q-learning",
            .summary = "tabular Q-learning from optimistic values; for small problems",
            .role = Role::Learner,
            .exact = true,
            .run = run_q_learning,
            .options = bound_options},
    Planner{.name = "dqn",
            .summary = "a deep Q-network, trained first unless a policy is given",
            .role = Role::Learner,
            .obstacle = network_needed,
            .misfit = policy_fits,
            .run = run_dqn,
            .options = policy_options},
    Planner{
        .name = "fleet-search",
        .summary = "several robots: the fewest steps, or the least travel, by search with proof",
        .exact = true,
        .one_robot = false,
        .fleets = true,
        .obstacle = fleet_search_needed,
        .run = search_fleet},
    Planner{.name = "fast",
            .summary = "several robots: a published heuristic for trees, subassemblies side by "
                       "side; no proof",
            .one_robot = false,
            .fleets = true,
            .obstacle = forest_needed,
            .run = run_fast},
};

}  // namespace

std::span<const Planner> planners() {
  return kPlanners;
}

}  // namespace orasp
