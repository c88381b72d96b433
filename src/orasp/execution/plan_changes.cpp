#include "orasp/execution/plan_changes.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

#include "orasp/model/validate.h"
#include "orasp/planners/greedy.h"

namespace orasp {
namespace {

std::vector<ConnectionIndex> all_of(std::span<const PlanStep> steps) {
  std::vector<ConnectionIndex> all;
  for (const PlanStep& step : steps)
    all.insert(all.end(), step.connections.begin(), step.connections.end());
  return all;
}

/// As many steps kept as can be: a longest increasing subsequence of old places. Reference:
/// Schensted (1961), Canadian J. Math. 13, 179-191. O(n log n).
void split_common(std::span<const ConnectionIndex> sequence, std::span<const std::size_t> old_place,
                  PlanChanges& changes) {
  std::vector<std::size_t> ends;  // by length - 1: step of the new plan that ends the best run
  std::vector<std::size_t> before(sequence.size(), sequence.size());
  std::vector<std::size_t> common;  // steps of the new plan that the old one has too
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const std::size_t place = old_place[sequence[i]];
    if (place == old_place.size()) {
      changes.added.push_back(sequence[i]);
      continue;
    }
    common.push_back(i);
    const auto at = std::ranges::lower_bound(
        ends, place, {}, [&](std::size_t step) { return old_place[sequence[step]]; });
    if (at != ends.begin()) before[i] = *(at - 1);
    if (at == ends.end()) {
      ends.push_back(i);
    } else {
      *at = i;
    }
  }
  std::vector<bool> kept(sequence.size(), false);
  for (std::size_t i = ends.empty() ? sequence.size() : ends.back(); i < sequence.size();
       i = before[i])
    kept[i] = true;
  for (const std::size_t i : common)
    (kept[i] ? changes.kept : changes.moved).push_back(sequence[i]);
}

}  // namespace

PlanChanges changes_between(const Problem& problem, const Situation& now,
                            std::span<const PlanStep> old, const Result& result) {
  PlanChanges changes;
  std::vector<PlanStep> left_steps;
  for (const PlanStep& step : old) {
    PlanStep left{{}, step.direction};
    std::ranges::copy_if(step.connections, std::back_inserter(left.connections),
                         [&](ConnectionIndex c) { return now.open.contains(c); });
    if (!left.connections.empty()) left_steps.push_back(std::move(left));
  }
  const std::vector<ConnectionIndex> left = all_of(left_steps);
  std::vector<std::size_t> old_place(problem.num_connections(), problem.num_connections());
  for (std::size_t i = 0; i < left.size(); ++i) old_place[left[i]] = i;
  split_common(result.sequence, old_place, changes);
  ConnectionSet planned(problem.num_connections());
  for (const ConnectionIndex c : result.sequence) planned.insert(c);
  std::ranges::copy_if(left, std::back_inserter(changes.dropped),
                       [&](ConnectionIndex c) { return !planned.contains(c); });
  Situation undisturbed = Situation::whole(problem.num_connections());
  undisturbed.open = now.open;
  undisturbed.in_force = now.in_force;
  undisturbed.last_place = now.last_place;
  const TransitionSystem from_here(problem, undisturbed);
  const Evaluation before = from_here.wide()
                                ? evaluate(from_here, std::span<const PlanStep>(left_steps))
                                : evaluate(from_here, std::span<const ConnectionIndex>(left));
  if (before.valid) {
    changes.before = before.reward;
    if (result.has_plan()) changes.price = before.reward - result.reward;
  }
  return changes;
}

std::vector<ConnectionIndex> still_reachable(const Problem& problem, const Situation& now,
                                             const Budget& budget) {
  std::vector<ConnectionIndex> reachable;
  ProblemSpec spec = problem.spec();
  spec.goal = Goal{};
  for (const ConnectionIndex c : problem.goal()) {
    if (!now.open.contains(c) || now.inaccessible.contains(c)) continue;
    spec.goal->removed.push_back(problem.connection_id(c));
    const Problem part(spec);
    const TransitionSystem system(part, now);
    if (greedy(system, budget).has_plan()) {
      reachable.push_back(c);
    } else {
      spec.goal->removed.pop_back();
    }
  }
  return reachable;
}

}  // namespace orasp
