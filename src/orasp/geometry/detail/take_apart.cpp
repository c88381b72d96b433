#include "orasp/geometry/detail/take_apart.h"

#include <algorithm>
#include <iterator>
#include <optional>

namespace orasp::detail {

namespace {

using Group = std::vector<std::uint32_t>;

constexpr std::uint32_t kNowhere = ~std::uint32_t{0};

/// A set that can leave the rest of its group.
struct Leaving {
  Group set;
  std::size_t moved = 0;  ///< parts of the side that moves
};

class Product {
 public:
  Product(std::size_t parts, std::size_t directions, std::span<const BlockedAlong> blocked,
          std::span<const std::pair<std::uint32_t, std::uint32_t>> joined,
          const std::vector<bool>& fixed)
      : directions_(directions),
        fixed_(fixed),
        blockers_(directions * parts),
        neighbours_(parts),
        member_(parts, kNowhere),
        count_(directions * parts, 0) {
    for (const BlockedAlong& fact : blocked) {
      blockers(fact.direction, fact.part).push_back(fact.by);
      blockers(fact.direction ^ 1U, fact.by).push_back(fact.part);
    }
    for (const auto& [a, b] : joined) {
      neighbours_[a].push_back(b);
      neighbours_[b].push_back(a);
    }
  }

  TakenApart take_apart() {
    Group all(neighbours_.size());
    for (std::uint32_t part = 0; part < all.size(); ++part) all[part] = part;
    open_.push_back(std::move(all));
    while (!open_.empty()) {
      Group group = std::move(open_.back());
      open_.pop_back();
      enter(group);
      std::vector<Group> pieces = pieces_of(group);
      if (pieces.size() == 1) {
        work_on(pieces[0]);
      } else {
        for (Group& piece : pieces) {
          if (piece.size() > 1) open_.push_back(std::move(piece));
        }
      }
    }
    std::ranges::sort(answer_.stuck);
    return std::move(answer_);
  }

 private:
  std::vector<std::uint32_t>& blockers(std::size_t direction, std::uint32_t part) {
    return blockers_[direction * neighbours_.size() + part];
  }
  bool is_fixed(std::uint32_t part) const { return !fixed_.empty() && fixed_[part]; }
  bool inside(std::uint32_t part) const { return member_[part] == group_; }

  /// Makes `group` the one that inside() asks for.
  void enter(const Group& group) {
    ++group_;
    for (const std::uint32_t part : group) member_[part] = group_;
  }

  std::vector<Group> pieces_of(const Group& group) {
    std::vector<Group> pieces;
    std::vector<bool> seen(neighbours_.size(), false);
    for (const std::uint32_t first : group) {
      if (seen[first]) continue;
      Group piece{first};
      seen[first] = true;
      for (std::size_t i = 0; i < piece.size(); ++i) {
        for (const std::uint32_t next : neighbours_[piece[i]]) {
          if (!inside(next) || seen[next]) continue;
          seen[next] = true;
          piece.push_back(next);
        }
      }
      std::ranges::sort(piece);
      pieces.push_back(std::move(piece));
    }
    return pieces;
  }

  /// Takes parts off one piece, or splits it, or finds it stuck.
  void work_on(const Group& piece) {
    if (piece.size() < 2) return;
    const Group left = after_free_parts(piece);
    if (left.size() < piece.size()) {
      if (left.size() > 1) open_.push_back(left);
      return;
    }
    const std::optional<Leaving> leaving = smallest_leaving(piece);
    if (!leaving) {
      // Two fixed parts come apart without moving.
      const auto held =
          std::ranges::count_if(piece, [this](std::uint32_t part) { return is_fixed(part); });
      if (held < 2) answer_.stuck.push_back(piece);
      return;
    }
    answer_.moved = std::max(answer_.moved, leaving->moved);
    Group rest;
    std::ranges::set_difference(piece, leaving->set, std::back_inserter(rest));
    const bool set_moves =
        leaving->moved == leaving->set.size() &&
        std::ranges::none_of(leaving->set, [this](std::uint32_t part) { return is_fixed(part); });
    const Group& moving = set_moves ? leaving->set : rest;
    enter(moving);
    if (pieces_of(moving).size() > 1) answer_.hangs_together = false;
    open_.push_back(leaving->set);
    open_.push_back(std::move(rest));
  }

  /// What is left once all parts that nothing blocks are gone, and those that are free then.
  Group after_free_parts(const Group& piece) {
    std::vector<std::uint32_t> queue;
    std::vector<bool> queued(neighbours_.size(), false);
    const std::size_t parts = neighbours_.size();
    for (const std::uint32_t part : piece) {
      for (std::size_t d = 0; d < directions_; ++d) {
        const auto& list = blockers(d, part);
        count_[d * parts + part] = static_cast<std::uint32_t>(
            std::ranges::count_if(list, [this](std::uint32_t other) { return inside(other); }));
        if (count_[d * parts + part] > 0 || queued[part] || is_fixed(part)) continue;
        queued[part] = true;
        queue.push_back(part);
      }
    }
    std::size_t left = piece.size();
    for (std::size_t i = 0; i < queue.size() && left > 1; ++i, --left) {
      const std::uint32_t gone = queue[i];
      member_[gone] = kNowhere;
      // Whom it blocks along a direction are those that block it along the opposite.
      for (std::size_t d = 0; d < directions_; ++d) {
        for (const std::uint32_t freed : blockers(d ^ 1U, gone)) {
          if (!inside(freed) || --count_[d * parts + freed] > 0) continue;
          if (queued[freed] || is_fixed(freed)) continue;
          queued[freed] = true;
          queue.push_back(freed);
        }
      }
    }
    Group rest;
    for (const std::uint32_t part : piece) {
      if (inside(part)) rest.push_back(part);
    }
    return rest;
  }

  std::optional<Leaving> smallest_leaving(const Group& piece) {
    std::optional<Leaving> best;
    for (std::size_t d = 0; d < directions_; ++d) {
      for (Group& sink : sinks(piece, d)) {
        if (sink.size() == piece.size()) continue;
        const auto held = static_cast<std::size_t>(
            std::ranges::count_if(sink, [this](std::uint32_t part) { return is_fixed(part); }));
        const auto held_in_all = static_cast<std::size_t>(
            std::ranges::count_if(piece, [this](std::uint32_t part) { return is_fixed(part); }));
        if (held > 0 && held < held_in_all) continue;
        std::size_t moved = std::min(sink.size(), piece.size() - sink.size());
        if (held > 0) moved = piece.size() - sink.size();
        if (held == 0 && held_in_all > 0) moved = sink.size();
        if (!best || moved < best->moved) best = Leaving{std::move(sink), moved};
      }
    }
    return best;
  }

  /// The strong components along a direction that nothing outside of them blocks. Tarjan (1972),
  /// Depth-first search and linear graph algorithms, without recursion.
  std::vector<Group> sinks(const Group& piece, std::size_t direction) {
    struct Visit {
      std::uint32_t part;
      std::size_t next;
    };
    std::vector<std::uint32_t> order(neighbours_.size(), kNowhere);
    std::vector<std::uint32_t> low(neighbours_.size(), kNowhere);
    std::vector<bool> closed(neighbours_.size(), false);
    std::vector<std::uint32_t> stack;
    std::vector<Visit> visits;
    std::uint32_t number = 0;
    std::vector<Group> found;
    for (const std::uint32_t root : piece) {
      if (order[root] != kNowhere) continue;
      visits.push_back({root, 0});
      while (!visits.empty()) {
        Visit& visit = visits.back();
        const std::uint32_t part = visit.part;
        if (visit.next == 0) {
          order[part] = low[part] = number++;
          stack.push_back(part);
        }
        const auto& list = blockers(direction, part);
        std::uint32_t deeper = kNowhere;
        while (visit.next < list.size() && deeper == kNowhere) {
          const std::uint32_t other = list[visit.next++];
          if (!inside(other) || closed[other]) continue;
          if (order[other] == kNowhere) {
            deeper = other;
          } else {
            low[part] = std::min(low[part], order[other]);
          }
        }
        if (deeper != kNowhere) {
          visits.push_back({deeper, 0});
          continue;
        }
        visits.pop_back();
        if (!visits.empty()) low[visits.back().part] = std::min(low[visits.back().part], low[part]);
        if (low[part] == order[part]) close(part, stack, closed, direction, found);
      }
    }
    return found;
  }

  /// Takes the component of `root` off the stack, and keeps it if nothing else blocks it.
  void close(std::uint32_t root, std::vector<std::uint32_t>& stack, std::vector<bool>& closed,
             std::size_t direction, std::vector<Group>& found) {
    Group component;
    while (component.empty() || component.back() != root) {
      component.push_back(stack.back());
      stack.pop_back();
      closed[component.back()] = true;
    }
    std::ranges::sort(component);
    for (const std::uint32_t part : component) {
      for (const std::uint32_t other : blockers(direction, part)) {
        if (inside(other) && !std::ranges::binary_search(component, other)) return;
      }
    }
    found.push_back(std::move(component));
  }

  std::size_t directions_;
  const std::vector<bool>& fixed_;
  std::vector<std::vector<std::uint32_t>> blockers_;  ///< by direction, then by part
  std::vector<std::vector<std::uint32_t>> neighbours_;
  std::vector<std::uint32_t> member_;  ///< number of the group that a part was last in
  std::uint32_t group_ = 0;
  std::vector<std::uint32_t> count_;
  std::vector<Group> open_;
  TakenApart answer_;
};

}  // namespace

TakenApart take_apart(std::size_t parts, std::size_t directions,
                      std::span<const BlockedAlong> blocked,
                      std::span<const std::pair<std::uint32_t, std::uint32_t>> joined,
                      const std::vector<bool>& fixed) {
  return Product(parts, directions, blocked, joined, fixed).take_apart();
}

}  // namespace orasp::detail
