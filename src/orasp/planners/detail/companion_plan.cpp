#include "orasp/planners/detail/companion_plan.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "orasp/model/detail/rules.h"
#include "orasp/planners/planner_support.h"

namespace orasp::detail {
namespace {

/// About how many words all Departures may look at: a second or two.
constexpr double kMostWork = 2e8;
constexpr double kMostLooks = 2'000;

class Search {
 public:
  Search(const TransitionSystem& system, const CompanionBound& bound, const Budget& budget)
      : system_(system),
        bound_(bound),
        budget_(budget),
        left_(system.start()),
        most_looks_(static_cast<std::size_t>(
            std::min(kMostLooks, kMostWork / std::max(1.0, bound.work_of_a_look())))) {}

  /// Takes apart a piece of which all connections are left. Whether that was possible at its bound.
  [[nodiscard]] bool take_apart(std::span<const PartIndex> piece) {
    take_loops(piece);
    if (piece.size() < 2) return true;
    const CompanionBound::Best best = bound_.of_piece(piece);
    if (!best.departures) return false;
    failed_.clear();
    return go_on(*best.departures, bound_.cost_of_companions(*best.departures));
  }
  [[nodiscard]] std::vector<ConnectionIndex> order() && { return std::move(order_); }
  [[nodiscard]] std::size_t looks() const { return looks_; }

 private:
  /// Takes what is left off the part that stays, where groups cost no more than `cost`.
  bool go_on(const Departures& now, double cost) {
    if (now.parts().size() < 2) return true;
    if (failed_.contains(now.parts())) return false;
    for (const std::vector<PartIndex>& group : now.groups()) {
      if (!now.may_leave(group) || !comes_apart(group)) continue;
      if (++looks_ > most_looks_ || budget_.expired() != Stop::None) return false;
      const double rest = cost - bound_.cost_of_moving_together(group);
      const Departures then = now.without(group);
      if (!then.possible()) continue;
      if (bound_.cost_of_companions(then) > rest + kRewardTolerance * std::max(1.0, cost)) continue;
      const std::size_t before = order_.size();
      take_off(group);
      if (go_on(then, rest)) return true;
      put_back(before);
      if (looks_ > most_looks_) return false;
    }
    failed_.insert(now.parts());
    return false;
  }

  /// Whether a group can be taken apart, once it is moved off, part by part. Groups are few and
  /// small, and most of them single parts.
  [[nodiscard]] bool comes_apart(const std::vector<PartIndex>& group) {
    if (group.size() < 2) return true;
    const auto [place, is_new] = groups_.try_emplace(group);
    if (is_new) place->second = order_within(group);
    return place->second.has_value();
  }
  [[nodiscard]] std::optional<std::vector<ConnectionIndex>> order_within(
      std::span<const PartIndex> group) {
    if (!hangs_together(group)) return std::nullopt;
    Search within(system_, bound_, budget_);
    within.looks_ = looks_;
    const CompanionBound::Best best = bound_.of_piece(group);
    const bool alone = best.departures && bound_.cost_of_companions(*best.departures) <= 0;
    const bool apart = alone && within.go_on(*best.departures, 0);
    looks_ = within.looks_;
    if (!apart) return std::nullopt;
    return std::move(within.order_);
  }
  [[nodiscard]] bool hangs_together(std::span<const PartIndex> group) const {
    const AssemblyGraph& graph = system_.rules().graph;
    std::vector<PartIndex> reached{group.front()};
    for (std::size_t i = 0; i < reached.size(); ++i) {
      for (const auto& half : graph.around(reached[i])) {
        if (!left_.contains(half.connection) || !std::ranges::count(group, half.other)) continue;
        if (!std::ranges::count(reached, half.other)) reached.push_back(half.other);
      }
    }
    return reached.size() == group.size();
  }

  /// All joints between a group and the rest, then those within.
  void take_off(const std::vector<PartIndex>& group) {
    const AssemblyGraph& graph = system_.rules().graph;
    for (const PartIndex part : group) {
      for (const auto& half : graph.around(part)) {
        if (!std::ranges::count(group, half.other)) take(half.connection);
      }
    }
    if (group.size() < 2) return;
    for (const ConnectionIndex c : *groups_[group]) take(c);
  }
  void take_loops(std::span<const PartIndex> piece) {
    const Problem& problem = system_.problem();
    for_each_connection(system_.start().view(), [&](ConnectionIndex c) {
      const auto [a, b] = problem.ends(c);
      if (a == b && std::ranges::count(piece, a)) take(c);
    });
  }
  void take(ConnectionIndex c) {
    if (!left_.contains(c)) return;
    left_.erase(c);
    order_.push_back(c);
  }
  void put_back(std::size_t before) {
    while (order_.size() > before) {
      left_.insert(order_.back());
      order_.pop_back();
    }
  }

  const TransitionSystem& system_;
  const CompanionBound& bound_;
  const Budget& budget_;
  ConnectionSet left_;
  std::vector<ConnectionIndex> order_;
  std::set<std::vector<PartIndex>> failed_;
  std::map<std::vector<PartIndex>, std::optional<std::vector<ConnectionIndex>>> groups_;
  std::size_t most_looks_;
  std::size_t looks_ = 0;
};

}  // namespace

Result companion_plan(const TransitionSystem& system, const CompanionBound& bound,
                      const Budget& budget) {
  Result result;
  if (!bound.known() || system.ordered()) return result;
  Search search(system, bound, budget);
  bool apart = true;
  system.rules().graph.for_each_piece(
      system.present(system.start().view()).view(),
      [&](std::span<const PartIndex> piece) { apart = apart && search.take_apart(piece); });
  const std::size_t looks = search.looks();
  if (apart) {
    if (auto plan = checked_plan(system, std::move(search).order())) result = std::move(*plan);
  }
  result.statistics.expanded = looks;
  return result;
}

}  // namespace orasp::detail
