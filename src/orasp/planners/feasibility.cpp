#include "orasp/planners/feasibility.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "orasp/model/tolerance.h"
#include "orasp/planners/depth_first_plan.h"

namespace orasp {

namespace {

constexpr std::string_view kMethod = "feasibility";

// What prepared() makes a step earn tells what it cuts: nothing 0, two larger pieces -2, at least
// one single part -5 or -8.
constexpr double kSingle = 4;
constexpr double kLarger = 1;
constexpr double kCuts = -1.5;
constexpr double kCutsSingle = -4.5;

/// The greatest reward of a step that can do no harm: see find_order().
double harmless(const Problem& problem) {
  // A connection that another one needs must not go early.
  if (std::ranges::any_of(problem.precedence(), [](const PrecedenceClause& clause) {
        return !clause.made_after_any.empty();
      }))
    return -kInfinity;
  const Limits& limits = problem.limits();
  const bool blocking =
      std::ranges::any_of(problem.blockers(), [](const auto& list) { return !list.empty(); });
  const bool judges_cuts =
      blocking || limits.max_subassemblies || limits.max_moved_parts || limits.max_moved_mass;
  if (!judges_cuts) return 0;
  const bool equal_masses = std::ranges::all_of(
      problem.parts(), [&](const Part& part) { return part.mass == problem.parts().front().mass; });
  if (limits.max_moved_mass && !equal_masses) return -kInfinity;
  const bool counts =
      limits.max_subassemblies && *limits.max_subassemblies < problem.num_parts() / 2;
  return counts ? kCutsSingle : kCuts;
}

/// `system` takes the problem apart.
Feasibility search(const TransitionSystem& system, const Budget& budget) {
  const double threshold = harmless(system.problem());
  const ConnectionSet none(system.num_connections());
  Result result = detail::depth_first_search(
      system, system.start(), none, budget, kMethod,
      [&](SetView, std::span<Action> actions) -> std::size_t {
        const auto safe = std::ranges::find_if(
            actions, [&](const Action& action) { return action.reward <= threshold; });
        if (safe != actions.end()) {
          std::swap(actions.front(), *safe);
          return 1;
        }
        std::ranges::stable_sort(actions, {}, &Action::reward);  // cuts first
        return actions.size();
      });
  Feasibility found;
  found.status = result.has_plan() ? Status::Feasible : result.status;
  found.stop = result.stop;
  found.order = std::move(result.sequence);
  found.expanded = result.statistics.expanded;
  return found;
}

/// An objective whose rewards tell what a step cuts.
Problem prepared(ProblemSpec spec) {
  PieceCost cost;
  cost.pieces[1] = kSingle;
  for (std::size_t parts = 2; parts <= std::max<std::size_t>(2, spec.parts.size()); ++parts)
    cost.pieces[parts] = kLarger;
  // The step that completes is the last one of a disassembly, which can do no harm, and the first
  // one of an assembly backwards, of which nothing is said.
  cost.completion = spec.direction == Direction::Disassembly ? 2 * -kSingle : 0;
  spec.objective = Objective("piece_cost", cost);
  return Problem(std::move(spec));
}

}  // namespace

Feasibility find_order(const Problem& problem, const ConnectionSet& from, const ConnectionSet& to,
                       const Budget& budget) {
  const Problem plain = prepared(problem.spec());
  const std::size_t connections = problem.num_connections();
  Situation now = Situation::whole(connections);
  if (problem.direction() == Direction::Disassembly) {
    now.open = from;
    now.inaccessible = to;
    return search(TransitionSystem(plain, now), budget);
  }
  for (ConnectionIndex c = 0; c < connections; ++c) {
    if (to.contains(c)) now.open.erase(c);
    if (!from.contains(c)) now.inaccessible.insert(c);
  }
  return search(TransitionSystem(plain, now).backwards(), budget);
}

Feasibility find_order(ProblemSpec spec, const Budget& budget) {
  spec.direction = Direction::Disassembly;
  const Problem plain = prepared(std::move(spec));
  const TransitionSystem system(plain);
  Feasibility found;
  if (system.infeasibility()) {
    found.status = Status::Infeasible;
    return found;
  }
  return search(system, budget);
}

}  // namespace orasp
