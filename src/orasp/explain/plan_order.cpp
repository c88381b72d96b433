#include "orasp/explain/plan_order.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <tuple>

namespace orasp {

namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

/// The plan's cut tree, from the last step to the first: what a step cuts is what it joins when the
/// plan is made backwards.
class CutTree {
 public:
  explicit CutTree(std::size_t parts)
      : parent_(parts),
        joined_at_(parts, kNone),
        size_(parts, 1),
        top_(parts, kNone),
        most_(parts, 0) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }

  struct Join {
    bool joins = false;
    /// The separators that cut the two sides first; kNone for a side that is a single part.
    std::size_t top_a = kNone;
    std::size_t top_b = kNone;
    /// By how much the number of subassemblies grows when the step is made forwards.
    int change = 0;
  };

  /// Makes the connection of step `step` between two parts.
  Join join(std::size_t first, std::size_t second, std::size_t step) {
    std::size_t a = root(first);
    std::size_t b = root(second);
    if (a == b) return {};
    const Join result{true, top_[a], top_[b],
                      static_cast<int>(size_[a] >= 2) + static_cast<int>(size_[b] >= 2) - 1};
    if (size_[a] > size_[b]) std::swap(a, b);
    parent_[a] =
        b;  // the smaller below the larger: a path to the root has at most log2(parts) steps
    joined_at_[a] = step;
    size_[b] += size_[a];
    top_[b] = step;
    most_[b] = std::max<std::size_t>(1, most_[a] + most_[b]);
    return result;
  }

  /// The separator that parts two parts which hang together now.
  [[nodiscard]] std::size_t parted_by(std::size_t first, std::size_t second) const {
    // Steps fall on the way up, since later joins are earlier steps: go up from where that is the
    // later step.
    std::size_t step = kNone;
    while (first != second) {
      const bool move_first =
          joined_at_[second] == kNone ||
          (joined_at_[first] != kNone && joined_at_[first] > joined_at_[second]);
      std::size_t& mover = move_first ? first : second;
      step = joined_at_[mover];
      mover = parent_[mover];
    }
    return step;
  }

  /// The most subassemblies that there can be at a time, whatever the order in which the tree is
  /// cut.
  [[nodiscard]] std::size_t most_subassemblies() const {
    std::size_t sum = 0;
    for (std::size_t part = 0; part < parent_.size(); ++part) {
      if (parent_[part] == part) sum += most_[part];
    }
    return sum;
  }

 private:
  [[nodiscard]] std::size_t root(std::size_t part) const {
    while (parent_[part] != part) part = parent_[part];
    return part;
  }

  std::vector<std::size_t> parent_;
  /// The step at which each part was linked to its parent.
  std::vector<std::size_t> joined_at_;
  /// For each root: how many parts its piece has, the separator that cuts the whole piece, and the
  /// most subassemblies that cutting it can give.
  std::vector<std::size_t> size_;
  std::vector<std::size_t> top_;
  std::vector<std::size_t> most_;
};

/// For each step the steps that must come before it, in disassembly order; repeats are possible.
using Before = std::vector<std::vector<std::uint32_t>>;

void add(Before& before, std::size_t early, std::size_t late) {
  if (early < late) before[late].push_back(static_cast<std::uint32_t>(early));
}

void add_precedence(const Problem& problem, const std::vector<std::size_t>& step_of,
                    Before& before) {
  for (const PrecedenceClause& clause : problem.precedence()) {
    const std::size_t step = step_of[clause.connection];
    for (const ConnectionIndex c : clause.after) add(before, step_of[c], step);
    if (!clause.made_after_any.empty()) {
      std::size_t latest = 0;
      for (const ConnectionIndex c : clause.made_after_any) latest = std::max(latest, step_of[c]);
      add(before, step, latest);
    }
    if (clause.after_any.empty()) continue;
    std::size_t earliest = kNone;
    for (const ConnectionIndex c : clause.after_any) earliest = std::min(earliest, step_of[c]);
    add(before, earliest, step);
  }
}

void add_cuts(const Problem& problem, const std::vector<ConnectionIndex>& order, Before& before) {
  CutTree tree(problem.num_parts());
  std::vector<std::size_t>
      changes;  // separators that change the number of subassemblies, last first
  for (std::size_t step = order.size(); step-- > 0;) {
    const auto [first, second] = problem.ends(order[step]);
    if (first == second) continue;
    const CutTree::Join join = tree.join(first, second, step);
    if (!join.joins) {
      add(before, step, tree.parted_by(first, second));
      continue;
    }
    if (join.top_a != kNone) add(before, step, join.top_a);
    if (join.top_b != kNone) add(before, step, join.top_b);
    if (join.change != 0) changes.push_back(step);
  }
  const auto& most = problem.limits().max_subassemblies;
  if (!most || tree.most_subassemblies() <= *most) return;
  for (std::size_t i = 1; i < changes.size(); ++i) add(before, changes[i], changes[i - 1]);
}

bool judges_cuts(const Problem& problem) {
  return problem.limits().any() ||
         std::ranges::any_of(problem.blockers(), [](const auto& list) { return !list.empty(); });
}

/// The pairs that do not follow from others. Steps are already in a topological order, so whatever
/// links `early` and `late` lies between them, and is met before `early` when the later ones come
/// first.
std::vector<OrderedPair> reduced(Before& before) {
  std::vector<std::vector<std::uint64_t>> ancestors(before.size());
  std::vector<OrderedPair> pairs;
  for (std::size_t late = 0; late < before.size(); ++late) {
    std::vector<std::uint64_t>& mine = ancestors[late];
    std::vector<std::uint32_t>& candidates = before[late];
    if (candidates.empty()) continue;
    std::ranges::sort(candidates, std::greater{});
    mine.assign(late / 64 + 1, 0);
    for (const std::uint32_t early : candidates) {
      const std::uint64_t bit = std::uint64_t{1} << (early % 64);
      if ((mine[early / 64] & bit) != 0) continue;
      mine[early / 64] |= bit;
      const std::vector<std::uint64_t>& others = ancestors[early];
      for (std::size_t w = 0; w < others.size(); ++w) mine[w] |= others[w];
      pairs.emplace_back(early, late);
    }
    candidates.clear();
    candidates.shrink_to_fit();
  }
  return pairs;
}

}  // namespace

std::vector<OrderedPair> plan_order(const Problem& problem,
                                    std::span<const ConnectionIndex> sequence) {
  const std::size_t steps = problem.num_connections();
  const bool assembly = problem.direction() == Direction::Assembly;
  std::vector<ConnectionIndex> order(sequence.begin(), sequence.end());
  if (assembly) std::ranges::reverse(order);
  std::vector<std::size_t> step_of(steps, kNone);
  for (std::size_t step = 0; step < order.size(); ++step) {
    if (order[step] >= steps || step_of[order[step]] != kNone) return {};
    step_of[order[step]] = step;
  }
  if (order.size() != steps) return {};

  Before before(steps);
  add_precedence(problem, step_of, before);
  if (judges_cuts(problem)) add_cuts(problem, order, before);
  std::vector<OrderedPair> pairs = reduced(before);
  if (assembly) {
    for (auto& [early, late] : pairs)
      std::tie(early, late) = std::pair(steps - 1 - late, steps - 1 - early);
  }
  std::ranges::sort(pairs);
  return pairs;
}

}  // namespace orasp
