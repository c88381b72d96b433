#include "orasp/planners/detail/peeled_plan.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "orasp/model/detail/rules.h"
#include "orasp/planners/greedy.h"
#include "orasp/planners/planner_support.h"

namespace orasp::detail {
namespace {

/// The most parts of the pieces that are left to the search.
constexpr std::size_t kMostLeft = 64;
/// The most pieces of the start; each of them leaves some parts to the search.
constexpr std::size_t kMostPieces = 8;
/// The most states that the search may look at.
constexpr std::uint64_t kMostStates = 200;

bool applies(const TransitionSystem& system) {
  return system.takes_apart() && !system.wide() && !system.ordered() &&
         system.problem().precedence().empty() && system.num_steps() > 0;
}

/// The parts that hang together by what is never handled are one node; others are nodes of their
/// own. A node is called after one of its parts.
class Nodes {
 public:
  /// `open`: what is still to be handled.
  Nodes(const TransitionSystem& system, const ConnectionSet& open)
      : problem_(system.problem()), name_(problem_.num_parts()), around_(problem_.num_parts()) {
    std::iota(name_.begin(), name_.end(), PartIndex{0});
    if (!system.kept().empty()) {
      system.rules().graph.for_each_piece(system.kept().view(),
                                          [&](std::span<const PartIndex> unit) {
                                            for (const PartIndex part : unit)
                                              name_[part] = unit.front();
                                          });
    }
    for_each_connection(open.view(), [&](ConnectionIndex c) {
      const PartIndex a = name_[problem_.ends(c)[0]];
      const PartIndex b = name_[problem_.ends(c)[1]];
      around_[a].push_back(c);
      if (a != b) around_[b].push_back(c);
    });
  }

  [[nodiscard]] std::size_t size() const { return name_.size(); }
  [[nodiscard]] PartIndex of(PartIndex part) const { return name_[part]; }
  [[nodiscard]] bool is_node(PartIndex part) const { return name_[part] == part; }
  [[nodiscard]] std::span<const ConnectionIndex> around(PartIndex node) const {
    return around_[node];
  }
  /// The node at the other end, or the same one.
  [[nodiscard]] PartIndex beyond(PartIndex node, ConnectionIndex c) const {
    const PartIndex a = name_[problem_.ends(c)[0]];
    return a == node ? name_[problem_.ends(c)[1]] : a;
  }

 private:
  const Problem& problem_;
  std::vector<PartIndex> name_;
  std::vector<std::vector<ConnectionIndex>> around_;
};

/// The nodes of each piece, in preorder of a spanning tree.
class Trees {
 public:
  explicit Trees(const Nodes& nodes)
      : nodes_(nodes), above_(nodes.size(), 0), round_(nodes.size(), 0) {}

  /// The nodes that hang together with `root`, nearer ones first.
  std::vector<PartIndex> by_distance(PartIndex root) {
    ++rounds_;
    std::vector<PartIndex> reached{root};
    round_[root] = rounds_;
    above_[root] = root;
    for (std::size_t i = 0; i < reached.size(); ++i) {
      for (const ConnectionIndex c : nodes_.around(reached[i])) {
        const PartIndex other = nodes_.beyond(reached[i], c);
        if (round_[other] == rounds_) continue;
        round_[other] = rounds_;
        above_[other] = reached[i];
        reached.push_back(other);
      }
    }
    return reached;
  }

  /// The preorder of the tree of the last by_distance(), the deepest branch of each node first.
  [[nodiscard]] std::vector<PartIndex> preorder(const std::vector<PartIndex>& reached) const {
    // How many nodes stand above the lowest one of a branch, counted from below.
    std::vector<std::size_t> height(nodes_.size(), 0);
    std::vector<PartIndex> deepest(nodes_.size());
    std::vector<std::vector<PartIndex>> below(nodes_.size());
    for (std::size_t i = reached.size(); i-- > 1;) {
      const PartIndex node = reached[i];
      const PartIndex up = above_[node];
      below[up].push_back(node);
      if (height[node] + 1 <= height[up]) continue;
      height[up] = height[node] + 1;
      deepest[up] = node;
    }
    std::vector<PartIndex> order;
    order.reserve(reached.size());
    std::vector<PartIndex> waiting{reached.front()};
    while (!waiting.empty()) {
      const PartIndex node = waiting.back();
      waiting.pop_back();
      order.push_back(node);
      for (const PartIndex next : below[node]) {
        if (next != deepest[node]) waiting.push_back(next);
      }
      if (!below[node].empty()) waiting.push_back(deepest[node]);
    }
    return order;
  }

 private:
  const Nodes& nodes_;
  std::vector<PartIndex> above_;    ///< by node: the one above it in the tree
  std::vector<std::size_t> round_;  ///< by node: the last walk that reached it
  std::size_t rounds_ = 0;
};

/// What is taken off, in this order, and what is then still there.
struct Peeled {
  explicit Peeled(const ConnectionSet& start) : left(start) {}
  void take(ConnectionIndex c) {
    left.erase(c);
    order.push_back(c);
  }

  std::vector<ConnectionIndex> order;
  ConnectionSet left;
};

/// Takes off all nodes of `preorder` but the first `keep`, the last one first.
void peel(const Nodes& nodes, std::span<const PartIndex> preorder, std::size_t keep,
          Peeled& peeled) {
  for (std::size_t i = preorder.size(); i-- > std::min(keep, preorder.size());) {
    for (const ConnectionIndex c : nodes.around(preorder[i])) {
      if (peeled.left.contains(c)) peeled.take(c);
    }
  }
}

/// The size of the largest piece off which a single part is not the best to cut, by sizes.
std::size_t least_peeled(const PieceBound& bound, std::size_t parts) {
  for (std::size_t n = parts; n > 2; --n) {
    if (!bound.single_part_is_best(n)) return n;
  }
  return 0;
}

/// By part, the most that moving it alone gains.
std::vector<double> gains_of_moving(const TransitionSystem& system) {
  Expander expander(system);
  std::vector<double> gains(system.problem().num_parts());
  for (PartIndex part = 0; part < gains.size(); ++part)
    gains[part] = expander.greatest_gain_of_moving({&part, 1});
  return gains;
}

/// Takes the step by which the bound falls least, where the first step completes and so is worth
/// more than others.
void take_best_first_step(const TransitionSystem& system, PieceBound& bound, Peeled& peeled) {
  Expander expander(system);
  const auto legal = expander.legal_actions(system.start().view());
  if (legal.empty()) return;
  std::vector<Action> scored(legal.begin(), legal.end());
  bound.add_change(system.start().view(), scored);
  peeled.take(std::ranges::max_element(scored, {}, &Action::reward)->connection);
}

/// What both plans begin with, and the pieces that are then to be peeled.
struct Beginning {
  /// `bound`: null where the first step is like any other.
  Beginning(const TransitionSystem& system, PieceBound* bound)
      : peeled(begun(system, bound)), nodes(system, peeled.left), trees(nodes) {
    std::vector<unsigned char> seen(nodes.size(), 0);
    for (PartIndex part = 0; part < nodes.size(); ++part) {
      if (!nodes.is_node(part) || seen[part] != 0) continue;
      std::vector<PartIndex> piece = trees.by_distance(part);
      for (const PartIndex node : piece) {
        seen[node] = 1;
        for (const ConnectionIndex c : nodes.around(node)) {
          if (nodes.beyond(node, c) == node && peeled.left.contains(c)) peeled.take(c);
        }
      }
      if (piece.size() > 1) pieces.push_back(std::move(piece));
    }
  }

  static Peeled begun(const TransitionSystem& system, PieceBound* bound) {
    Peeled peeled(system.start());
    if (bound != nullptr && system.completes_first()) take_best_first_step(system, *bound, peeled);
    return peeled;
  }

  Peeled peeled;  ///< what holds nothing goes first
  Nodes nodes;
  Trees trees;
  std::vector<std::vector<PartIndex>> pieces;  ///< those of several nodes
};

/// The plan that ends with what costs most to move.
std::optional<Result> plan_to_costliest(const TransitionSystem& system, Beginning& beginning) {
  const std::vector<double> gains = gains_of_moving(system);
  Peeled peeled = beginning.peeled;
  for (const std::vector<PartIndex>& piece : beginning.pieces) {
    const PartIndex root =
        *std::ranges::min_element(piece, {}, [&](PartIndex node) { return gains[node]; });
    Trees& trees = beginning.trees;
    peel(beginning.nodes, trees.preorder(trees.by_distance(root)), 1, peeled);
  }
  return checked_plan(system, std::move(peeled.order));
}

/// The plan that leaves small pieces to the search; empty where that finds none.
std::optional<Result> plan_to_small_pieces(const TransitionSystem& system, PieceBound& bound,
                                           Beginning& beginning, const Budget& budget,
                                           Statistics& statistics) {
  const std::size_t keep =
      std::max<std::size_t>(1, least_peeled(bound, system.problem().num_parts()));
  if (keep > kMostLeft || beginning.pieces.size() > kMostPieces) return std::nullopt;
  Peeled peeled = beginning.peeled;
  for (const std::vector<PartIndex>& piece : beginning.pieces) {
    Trees& trees = beginning.trees;
    const PartIndex end = trees.by_distance(piece.front()).back();
    peel(beginning.nodes, trees.preorder(trees.by_distance(end)), keep, peeled);
  }
  if (!peeled.left.empty()) {
    Budget some = budget;
    some.max_expansions = std::min(budget.max_expansions, kMostStates);
    const Result rest = rest_at_bound(system, bound, peeled.left, some);
    statistics.expanded += rest.statistics.expanded;
    if (!rest.has_plan()) return std::nullopt;
    peeled.order.insert(peeled.order.end(), rest.sequence.begin(), rest.sequence.end());
  }
  return checked_plan(system, std::move(peeled.order));
}

}  // namespace

Result peeled_plan(const TransitionSystem& system, PieceBound& bound, const Budget& budget) {
  Result best;
  if (!applies(system)) return best;
  Beginning beginning(system, &bound);
  const double most = bound(system.start().view());
  const auto offer = [&](std::optional<Result> plan) {
    best.statistics.expanded += system.num_steps();
    if (!plan || plan->reward <= best.reward) return;
    plan->statistics = best.statistics;
    best = std::move(*plan);
  };
  offer(plan_to_small_pieces(system, bound, beginning, budget, best.statistics));
  if (!meets(best.reward, most)) offer(plan_to_costliest(system, beginning));
  return best;
}

Result peeled_plan(const TransitionSystem& system) {
  Result result;
  if (!applies(system) || system.calls_out()) return result;
  Beginning beginning(system, nullptr);
  if (auto plan = plan_to_costliest(system, beginning)) result = std::move(*plan);
  result.statistics.expanded = system.num_steps();
  return result;
}

}  // namespace orasp::detail
