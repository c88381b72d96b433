#include "orasp/planners/detail/quick_plan.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <numeric>
#include <queue>
#include <utility>
#include <vector>

#include "orasp/model/detail/rules.h"
#include "orasp/planners/planner_support.h"

namespace orasp::detail {
namespace {

/// A part with so many connections left or fewer is worth looking at again.
constexpr std::size_t kFew = 4;
/// Pieces of so many parts or fewer are peeled, not halved.
constexpr std::size_t kPeeled = 512;

bool applies(const TransitionSystem& system) {
  const Rules& rules = system.rules();
  return system.takes_apart() && !system.wide() && !system.ordered() && !rules.cuts_checked &&
         !system.problem().uncertain() && system.sees_sizes_only() &&
         !system.sees_starting_pieces() &&
         std::ranges::all_of(system.problem().precedence(), [](const PrecedenceClause& clause) {
           return clause.made_after_any.empty();
         });
}

/// The connections in the order in which they go.
class Peeling {
 public:
  explicit Peeling(const TransitionSystem& system)
      : problem_(system.problem()),
        open_(system.start()),
        degree_(problem_.num_parts(), 0),
        of_part_(problem_.num_parts()),
        waits_(problem_.num_connections(), 0),
        waiting_(problem_.num_connections()) {
    const ConnectionSet present = system.present(open_.view());
    for_each_connection(present.view(), [&](ConnectionIndex c) {
      for (const PartIndex part : problem_.ends(c)) {
        ++degree_[part];
        of_part_[part].push_back(c);
      }
    });
    // What is not there any more holds nothing back.
    for (const PrecedenceClause& clause : problem_.precedence()) {
      if (!open_.contains(clause.connection)) continue;
      for (const ConnectionIndex other : clause.after) {
        if (present.contains(other)) hold(clause.connection, {other});
      }
      if (!clause.after_any.empty() &&
          std::ranges::all_of(clause.after_any,
                              [&](ConnectionIndex other) { return present.contains(other); }))
        hold(clause.connection, clause.after_any);
    }
    for_each_connection(open_.view(), [&](ConnectionIndex c) { offer(c); });
  }

  /// Empty where something is left that may never go.
  std::vector<ConnectionIndex> order() {
    std::vector<ConnectionIndex> order;
    const std::size_t steps = open_.size();
    order.reserve(steps);
    while (!offers_.empty()) {
      const ConnectionIndex c = offers_.top().second;
      offers_.pop();
      if (!open_.contains(c)) continue;
      take(c);
      order.push_back(c);
    }
    if (order.size() < steps) order.clear();
    return order;
  }

 private:
  using Offer = std::pair<std::size_t, ConnectionIndex>;

  /// `connection` waits until one of `any` is gone.
  void hold(ConnectionIndex connection, const std::vector<ConnectionIndex>& any) {
    ++waits_[connection];
    for (const ConnectionIndex other : any) waiting_[other].push_back(met_.size());
    met_.push_back(false);
    held_.push_back(connection);
  }
  [[nodiscard]] std::size_t degree_of(ConnectionIndex c) const {
    const auto& [a, b] = problem_.ends(c);
    return std::min(degree_[a], degree_[b]);
  }
  void offer(ConnectionIndex c) {
    if (waits_[c] == 0) offers_.emplace(degree_of(c), c);
  }
  void take(ConnectionIndex c) {
    open_.erase(c);
    for (const PartIndex part : problem_.ends(c)) --degree_[part];
    for (const PartIndex part : problem_.ends(c)) {
      // Those of a part with many left are offered anew when few are left.
      if (degree_[part] > kFew) continue;
      for (const ConnectionIndex other : of_part_[part]) {
        if (open_.contains(other)) offer(other);
      }
    }
    for (const std::size_t list : waiting_[c]) {
      if (met_[list]) continue;
      met_[list] = true;
      if (--waits_[held_[list]] == 0 && open_.contains(held_[list])) offer(held_[list]);
    }
  }

  const Problem& problem_;
  ConnectionSet open_;
  std::vector<std::size_t> degree_;                    ///< by part: connections present
  std::vector<std::vector<ConnectionIndex>> of_part_;  ///< by part: connections at the start
  std::vector<std::size_t> waits_;                     ///< by connection: lists not met
  std::vector<std::vector<std::size_t>> waiting_;      ///< by connection: lists that name it
  std::vector<bool> met_;                              ///< by list
  std::vector<ConnectionIndex> held_;                  ///< by list: the connection that waits
  std::priority_queue<Offer, std::vector<Offer>, std::greater<>> offers_;
};

/// Pieces that grow together.
class Union {
 public:
  explicit Union(std::size_t parts) : parent_(parts), size_(parts, 1) {
    std::iota(parent_.begin(), parent_.end(), PartIndex{0});
  }
  PartIndex find(PartIndex part) {
    while (parent_[part] != part) part = parent_[part] = parent_[parent_[part]];
    return part;
  }
  [[nodiscard]] std::size_t size(PartIndex root) const { return size_[root]; }
  void join(PartIndex a, PartIndex b) {
    if (size_[a] < size_[b]) std::swap(a, b);
    parent_[b] = a;
    size_[a] += size_[b];
  }

 private:
  std::vector<PartIndex> parent_;
  std::vector<std::size_t> size_;
};

/// The order that halves large pieces and peels small ones, where there is no precedence.
class Halving {
 public:
  /// `peeled` is the order of Peeling.
  Halving(const TransitionSystem& system, const std::vector<ConnectionIndex>& peeled)
      : problem_(system.problem()),
        open_(system.start()),
        of_part_(problem_.num_parts()),
        side_(problem_.num_parts(), 0),
        rank_(problem_.num_connections(), 0) {
    for (std::size_t i = 0; i < peeled.size(); ++i) rank_[peeled[i]] = i;
    const ConnectionSet present = system.present(open_.view());
    for_each_connection(present.view(), [&](ConnectionIndex c) {
      for (const PartIndex part : problem_.ends(c)) of_part_[part].push_back(c);
    });
  }

  std::vector<ConnectionIndex> order() {
    const ConnectionSet all_open = open_;
    for_each_connection(all_open.view(), [&](ConnectionIndex c) {
      if (problem_.ends(c)[0] == problem_.ends(c)[1]) take(c);  // holds nothing
    });
    std::vector<PartIndex> all(problem_.num_parts());
    std::iota(all.begin(), all.end(), PartIndex{0});
    sets_.push_back(std::move(all));
    while (!sets_.empty()) {
      const std::vector<PartIndex> set = std::move(sets_.back());
      sets_.pop_back();
      const std::size_t here = ++sides_;
      for (const PartIndex part : set) side_[part] = here;
      for (const PartIndex part : set) {
        if (side_[part] == here) halve(part, here);
      }
    }
    return std::move(order_);
  }

 private:
  void take(ConnectionIndex c) {
    open_.erase(c);
    order_.push_back(c);
  }

  /// Parts of one side that hang together with `first`, the nearer ones first; they get a side of
  /// their own.
  std::vector<PartIndex> level_order(PartIndex first, std::size_t from) {
    const std::size_t own = ++sides_;
    std::vector<PartIndex> reached{first};
    side_[first] = own;
    for (std::size_t i = 0; i < reached.size(); ++i) {
      for (const ConnectionIndex c : of_part_[reached[i]]) {
        const auto& [a, b] = problem_.ends(c);
        const PartIndex other = a == reached[i] ? b : a;
        if (side_[other] != from) continue;
        side_[other] = own;
        reached.push_back(other);
      }
    }
    return reached;
  }

  /// Cuts what hangs together with `first` in two.
  void halve(PartIndex first, std::size_t from) {
    const PartIndex end = level_order(first, from).back();
    std::vector<PartIndex> near = level_order(end, side_[end]);
    if (near.size() <= kPeeled) return peel(near);
    const std::size_t middle = near.size() / 2;
    const std::size_t rest = side_[end];
    const std::size_t own = ++sides_;
    for (std::size_t i = 0; i < middle; ++i) side_[near[i]] = own;
    for (std::size_t i = 0; i < middle; ++i) {
      for (const ConnectionIndex c : of_part_[near[i]]) {
        const auto& [a, b] = problem_.ends(c);
        if (open_.contains(c) && (side_[a] == rest || side_[b] == rest)) take(c);
      }
    }
    const auto cut = near.begin() + static_cast<std::ptrdiff_t>(middle);
    sets_.emplace_back(cut, near.end());
    near.erase(cut, near.end());
    sets_.push_back(std::move(near));
  }

  /// Takes all apart that holds a piece together.
  void peel(const std::vector<PartIndex>& piece) {
    std::vector<ConnectionIndex> inside;
    for (const PartIndex part : piece) {
      for (const ConnectionIndex c : of_part_[part]) {
        if (!open_.contains(c)) continue;
        open_.erase(c);
        inside.push_back(c);
      }
    }
    std::ranges::sort(inside, {}, [&](ConnectionIndex c) { return rank_[c]; });
    order_.insert(order_.end(), inside.begin(), inside.end());
  }

  const Problem& problem_;
  ConnectionSet open_;
  std::vector<std::vector<ConnectionIndex>> of_part_;  ///< by part: connections at the start
  std::vector<std::size_t> side_;                      ///< by part: where it was put last
  std::vector<std::size_t> rank_;                      ///< by connection: in the order of Peeling
  std::size_t sides_ = 0;
  std::vector<std::vector<PartIndex>> sets_;  ///< still to be cut
  std::vector<ConnectionIndex> order_;
};

/// What an order earns, and how many parts its steps list.
struct Worth {
  double reward = 0;
  std::size_t listed = 0;
};

Worth worth_of(const TransitionSystem& system, const std::vector<ConnectionIndex>& order) {
  const Problem& problem = system.problem();
  Union pieces(problem.num_parts());
  const ConnectionSet none(problem.num_connections());
  for_each_connection(system.present(none.view()).view(), [&](ConnectionIndex c) {
    const PartIndex a = pieces.find(problem.ends(c)[0]);
    const PartIndex b = pieces.find(problem.ends(c)[1]);
    if (a != b) pieces.join(a, b);
  });
  Worth worth;
  for (std::size_t i = order.size(); i-- > 0;) {
    const PartIndex a = pieces.find(problem.ends(order[i])[0]);
    const PartIndex b = pieces.find(problem.ends(order[i])[1]);
    const bool completes = system.completes_first() ? i == 0 : i + 1 == order.size();
    const bool separates = a != b;
    const std::size_t of_a = separates ? pieces.size(a) : 0;
    const std::size_t of_b = separates ? pieces.size(b) : 0;
    worth.reward += system.greatest_size_reward(of_a, of_b, completes);
    worth.listed += of_a + of_b;
    if (separates) pieces.join(a, b);
  }
  return worth;
}

}  // namespace

Result quick_plan(const TransitionSystem& system) {
  Result result;
  if (!applies(system) || system.num_steps() == 0) return result;
  std::size_t least_listed = kMostListed + 1;
  const auto offer = [&](std::vector<ConnectionIndex> order) {
    result.statistics.expanded += order.size();
    if (order.size() < system.num_steps()) return;
    const Worth worth = worth_of(system, order);
    if (worth.listed > kMostListed) return;
    const bool as_good = result.has_plan() && meets(worth.reward, result.reward) &&
                         meets(result.reward, worth.reward);
    if (as_good ? worth.listed >= least_listed : worth.reward <= result.reward) return;
    least_listed = worth.listed;
    result.status = Status::Feasible;
    result.reward = worth.reward;
    result.sequence = std::move(order);
  };
  const std::vector<ConnectionIndex> peeled = Peeling(system).order();
  offer(peeled);
  if (system.problem().precedence().empty()) offer(Halving(system, peeled).order());
  return result;
}

}  // namespace orasp::detail
