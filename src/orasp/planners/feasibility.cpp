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

Feasibility search(const Problem& problem, const TransitionSystem& system,
                   const ConnectionSet& from, const ConnectionSet& to, const Budget& budget) {
  const double threshold = harmless(problem);
  Result result = detail::depth_first_search(
      system, from, to, budget, kMethod, [&](SetView, std::span<Action> actions) -> std::size_t {
        const auto kept_back = std::ranges::stable_partition(
            actions, [&](const Action& action) { return !to.contains(action.connection); });
        const auto mine = actions.first(actions.size() - kept_back.size());
        const auto safe = std::ranges::find_if(
            mine, [&](const Action& action) { return action.reward <= threshold; });
        if (safe != mine.end()) {
          std::swap(mine.front(), *safe);
          return 1;
        }
        std::ranges::stable_sort(mine, {}, &Action::reward);  // cuts first
        return mine.size();
      });
  Feasibility found;
  found.status = result.has_plan() ? Status::Feasible : result.status;
  found.stop = result.stop;
  found.order = std::move(result.sequence);
  found.expanded = result.statistics.expanded;
  return found;
}

/// Disassembly, and an objective whose rewards tell what a step cuts.
Problem prepared(ProblemSpec spec) {
  spec.direction = Direction::Disassembly;
  PieceCost cost;
  cost.pieces[1] = kSingle;
  for (std::size_t parts = 2; parts <= std::max<std::size_t>(2, spec.parts.size()); ++parts)
    cost.pieces[parts] = kLarger;
  cost.completion = 2 * -kSingle;
  spec.objective = Objective("piece_cost", cost);
  return Problem(std::move(spec));
}

}  // namespace

Feasibility find_order(const Problem& problem, const ConnectionSet& from, const ConnectionSet& to,
                       const Budget& budget) {
  const Problem plain = prepared(problem.spec());
  return search(plain, TransitionSystem(plain), from, to, budget);
}

Feasibility find_order(ProblemSpec spec, const Budget& budget) {
  const Problem plain = prepared(std::move(spec));
  const TransitionSystem system(plain);
  Feasibility found;
  if (system.infeasibility()) {
    found.status = Status::Infeasible;
    return found;
  }
  return search(plain, system, system.start(), ConnectionSet(system.num_connections()), budget);
}

}  // namespace orasp
