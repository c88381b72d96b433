#include "orasp/geometry/detail/grounded_order.h"

#include <algorithm>
#include <unordered_map>

namespace orasp::detail {

namespace {

constexpr std::uint32_t kNoPart = ~std::uint32_t{0};

/// The parts of a group by numbers of their own, and what is left of them.
class Rest {
 public:
  Rest(std::span<const std::uint32_t> group, std::size_t directions,
       std::span<const BlockedAlong> blocked,
       std::span<const std::pair<std::uint32_t, std::uint32_t>> joined)
      : directions_(directions),
        left_(group.size()),
        present_(group.size(), true),
        neighbours_(group.size()),
        blocked_by_(directions * group.size()),
        count_(directions * group.size(), 0) {
    std::unordered_map<std::uint32_t, std::uint32_t> number;
    for (std::uint32_t i = 0; i < group.size(); ++i) number.emplace(group[i], i);
    for (const auto& [a, b] : joined) {
      if (!number.contains(a) || !number.contains(b)) continue;
      neighbours_[number[a]].push_back(number[b]);
      neighbours_[number[b]].push_back(number[a]);
    }
    for (const BlockedAlong& fact : blocked) {
      if (!number.contains(fact.part) || !number.contains(fact.by)) continue;
      add(fact.direction, number[fact.part], number[fact.by]);
      add(fact.direction ^ 1U, number[fact.by], number[fact.part]);
    }
  }

  [[nodiscard]] std::size_t left() const { return left_; }

  /// The first part but `base` that nothing blocks and that no other needs to hang on the base.
  [[nodiscard]] std::uint32_t removable(std::uint32_t base) {
    const std::vector<bool> needed = cut_parts(base);
    for (std::uint32_t part = 0; part < present_.size(); ++part) {
      if (part != base && present_[part] && !needed[part] && is_free(part)) return part;
    }
    return kNoPart;
  }

  void remove(std::uint32_t part) {
    present_[part] = false;
    --left_;
    for (std::size_t d = 0; d < directions_; ++d) {
      for (const std::uint32_t freed : blocked_by_[d * present_.size() + part])
        --count_[d * present_.size() + freed];
    }
  }

 private:
  void add(std::size_t direction, std::uint32_t part, std::uint32_t by) {
    ++count_[direction * present_.size() + part];
    blocked_by_[direction * present_.size() + by].push_back(part);
  }

  [[nodiscard]] bool is_free(std::uint32_t part) const {
    for (std::size_t d = 0; d < directions_; ++d) {
      if (count_[d * present_.size() + part] == 0) return true;
    }
    return false;
  }

  /// The parts without which something no longer hangs on `base`. Hopcroft and Tarjan (1973),
  /// Efficient algorithms for graph manipulation, without recursion.
  [[nodiscard]] std::vector<bool> cut_parts(std::uint32_t base) const {
    struct Visit {
      std::uint32_t part;
      std::uint32_t from;
      std::size_t next;
    };
    std::vector<bool> cut(present_.size(), false);
    std::vector<std::uint32_t> order(present_.size(), kNoPart);
    std::vector<std::uint32_t> low(present_.size(), kNoPart);
    std::uint32_t number = 0;
    std::vector<Visit> visits{{base, kNoPart, 0}};
    order[base] = low[base] = number++;
    while (!visits.empty()) {
      Visit& visit = visits.back();
      const std::uint32_t part = visit.part;
      if (visit.next < neighbours_[part].size()) {
        const std::uint32_t other = neighbours_[part][visit.next++];
        if (!present_[other] || other == visit.from) continue;
        if (order[other] != kNoPart) {
          low[part] = std::min(low[part], order[other]);
        } else {
          order[other] = low[other] = number++;
          visits.push_back({other, part, 0});
        }
        continue;
      }
      visits.pop_back();
      if (visits.empty()) break;
      const std::uint32_t above = visits.back().part;
      low[above] = std::min(low[above], low[part]);
      if (low[part] >= order[above]) cut[above] = true;
    }
    return cut;
  }

  std::size_t directions_;
  std::size_t left_;
  std::vector<bool> present_;
  std::vector<std::vector<std::uint32_t>> neighbours_;
  std::vector<std::vector<std::uint32_t>> blocked_by_;  ///< by direction, then by blocker
  std::vector<std::uint32_t> count_;                    ///< blockers left, by direction, then part
};

}  // namespace

bool has_grounded_order(std::span<const std::uint32_t> group, std::uint32_t base,
                        std::size_t directions, std::span<const BlockedAlong> blocked,
                        std::span<const std::pair<std::uint32_t, std::uint32_t>> joined) {
  const auto place = static_cast<std::uint32_t>(std::ranges::find(group, base) - group.begin());
  Rest rest(group, directions, blocked, joined);
  while (rest.left() > 1) {
    const std::uint32_t part = rest.removable(place);
    if (part == kNoPart) return false;
    rest.remove(part);
  }
  return true;
}

}  // namespace orasp::detail
