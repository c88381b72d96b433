#include "orasp/planners/greedy.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "orasp/model/tolerance.h"
#include "orasp/planners/depth_first_plan.h"
#include "orasp/planners/detail/wide_search.h"

namespace orasp {

Result greedy(const TransitionSystem& system, const Budget& budget) {
  if (system.wide()) return detail::wide_greedy(system, budget);
  return detail::depth_first_plan(system, budget, "greedy", [](SetView, std::span<Action> actions) {
    std::ranges::stable_sort(actions, std::ranges::greater{}, &Action::reward);
    return actions.size();
  });
}

Result guided_greedy(const TransitionSystem& system, PieceBound& bound, const Budget& budget) {
  std::vector<Action> scored;
  std::vector<std::pair<double, Action>> order;
  return detail::depth_first_plan(
      system, budget, "greedy", [&](SetView open, std::span<Action> actions) {
        scored.assign(actions.begin(), actions.end());
        bound.add_change(open, scored);
        order.clear();
        for (std::size_t i = 0; i < actions.size(); ++i)
          order.emplace_back(scored[i].reward, actions[i]);
        std::ranges::stable_sort(order,
                                 [](const auto& a, const auto& b) { return a.first > b.first; });
        for (std::size_t i = 0; i < actions.size(); ++i) actions[i] = order[i].second;
        return actions.size();
      });
}

namespace {

/// Keeps the actions by which the bound does not fall below what it was.
class KeepBound {
 public:
  explicit KeepBound(PieceBound& bound) : bound_(bound) {}

  std::size_t operator()(SetView open, std::span<Action> actions) {
    scored_.assign(actions.begin(), actions.end());
    bound_.add_change(open, scored_);
    if (count(open) == 1)
      return actions.size();  // paid as completing, which the bound has counted already
    std::size_t kept = 0;
    for (std::size_t i = 0; i < actions.size(); ++i) {
      if (scored_[i].reward >= -kRewardTolerance) actions[kept++] = actions[i];
    }
    return kept;
  }

 private:
  PieceBound& bound_;
  std::vector<Action> scored_;
};

}  // namespace

Result rest_at_bound(const TransitionSystem& system, PieceBound& bound, const ConnectionSet& from,
                     const Budget& budget) {
  const ConnectionSet goal(system.num_connections());
  Result result =
      detail::depth_first_search(system, from, goal, budget, "greedy", KeepBound(bound));
  if (result.status == Status::Infeasible) result.status = Status::Unknown;
  return result;
}

Result plan_at_bound(const TransitionSystem& system, PieceBound& bound, const Budget& budget) {
  Result result = detail::depth_first_plan(system, budget, "greedy", KeepBound(bound));
  if (result.status == Status::Infeasible) {
    result.status = Status::Unknown;  // there may be plans that earn less
    result.notes.clear();
  }
  return result;
}

}  // namespace orasp
