#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "orasp/model/problem.h"
#include "orasp/planners/detail/part_set.h"

namespace orasp::detail {

/// Lists the ways to part a piece into two connected sides of which one can leave the other.
///
/// Problem.    Products whose parts hold each other have few legal cuts among very many ways to
///             part them. Listing all ways and asking of each whether blocking allows it takes ten
///             times as long.
/// Idea.       One side, A, holds the first part of the piece. A pair of sets of parts says what is
///             in A and what is in B for certain; a part next to A is put into A, then into B. What
///             follows is added at once. Where A leaves along d, whatever blocks a part of A along
///             d is in A, and whatever a part of B blocks is in B. If something is in B, B lies in
///             one component of what is not in A, and the other components are in A.
/// Reference.  Provan and Shier (1996), A paradigm for listing (s,t)-cuts in graphs, Algorithmica
///             15, 351-372.
/// Guarantee.  Every pair of sides comes once: the choices differ, and of several directions the
///             first free one counts. Without blocking, with more than 32 directions, and between
///             two base parts, of which neither moves, directions are not asked for.
/// Cost.       Without blocking, or where what blocks is connected, each pair of sets has a cut,
///             so a cut takes O(parts) steps of a flood fill.
template <std::size_t kWords>
class SideLister {
 public:
  using Set = PartSet<kWords>;

  SideLister(const Problem& problem, const std::vector<Set>& neighbours)
      : neighbours_(neighbours), along_(kMostDirections) {
    for (std::size_t part = 0; part < problem.base().size(); ++part) {
      if (problem.base()[part]) base_.insert(part);
    }
    if (problem.directions().empty() || !problem.has_direction_masks()) return;
    for (const DirectionIndex direction : problem.directions()) {
      directions_.push_back(direction);
      along_[direction].resize(problem.num_parts());
    }
    for (PartIndex part = 0; part < problem.num_parts(); ++part) {
      for (const Blocker& blocker : problem.blockers()[part]) {
        for (const std::size_t direction : directions_) {
          if (problem.blocks(blocker, direction)) along_[direction][part].insert(blocker.by);
        }
      }
    }
  }

  /// Whether list() looks at blocking for this piece: of each two sides one then leaves the other
  /// along some direction.
  [[nodiscard]] bool sees_blocking(const Set& piece) const {
    return !directions_.empty() && (piece & base_).size() <= 1;
  }

  /// Whether one of two sides of a piece leaves the other along some direction; only where
  /// sees_blocking() says so of the piece.
  [[nodiscard]] bool parts_along_some(const Set& a, const Set& b) const {
    return std::ranges::any_of(directions_, [&](std::size_t d) { return leaves(a, b, d); });
  }

  /// Calls offer(a, b) for each way to part `piece`, which is connected, until stop() says so.
  template <class Offer, class Stop>
  void list(const Set& piece, Offer&& offer, Stop&& stop) const {
    Set first;
    first.insert(piece.first());
    if (!sees_blocking(piece)) {
      walk(piece, kAnyDirection, {}, first, {}, offer, stop);
      return;
    }
    for (std::size_t i = 0; i < directions_.size(); ++i) {
      const auto once = [&](const Set& a, const Set& b) {
        for (std::size_t j = 0; j < i; ++j) {
          if (leaves(a, b, directions_[j])) return;
        }
        offer(a, b);
      };
      walk(piece, directions_[i], {}, first, {}, once, stop);
    }
  }

 private:
  static constexpr std::size_t kMostDirections = 32;
  static constexpr std::size_t kAnyDirection = kMostDirections;

  /// Whether no part of `b` blocks one of `a` along `direction`.
  [[nodiscard]] bool leaves(const Set& a, const Set& b, std::size_t direction) const {
    for (std::size_t w = 0; w < kWords; ++w) {
      for (std::uint64_t word = a.words[w]; word != 0; word &= word - 1) {
        const std::size_t part = w * 64 + static_cast<std::size_t>(std::countr_zero(word));
        if (!(along_[direction][part] & b).empty()) return false;
      }
    }
    return true;
  }

  /// The part of `within` that hangs together with `start`; writes what is next to it to `around`.
  [[nodiscard]] Set flood(const Set& within, std::size_t start, Set& around) const {
    Set reached;
    reached.insert(start);
    Set front = reached;
    around = {};
    while (!front.empty()) {
      Set next;
      front.for_each([&](std::size_t part) { next = next | neighbours_[part]; });
      around = around | next;
      front = (next & within) - reached;
      reached = reached | front;
    }
    return reached;
  }

  /// All of `piece` that goes along with `set` where what blocks it along `direction` must; `with`
  /// is all that goes along with itself.
  [[nodiscard]] Set closed(const Set& piece, std::size_t direction, Set set,
                           const Set& with) const {
    if (direction == kAnyDirection) return set | with;
    Set front = set;
    set = set | with;
    while (!front.empty()) {
      Set next;
      front.for_each([&](std::size_t part) { next = next | along_[direction][part]; });
      front = (next & piece) - set;
      set = set | front;
    }
    return set;
  }

  /// Adds to `a` `more` and all that follows from what is then in `a` and in `b`. False if that
  /// cannot be.
  [[nodiscard]] bool settle(const Set& piece, std::size_t direction, Set& a, Set more,
                            const Set& b) const {
    while (true) {
      a = closed(piece, direction, more, a);
      if (!(a & b).empty()) return false;
      if (b.empty()) return true;
      const Set rest = piece - a;
      Set around;
      const Set with_b = flood(rest, b.first(), around);
      if (!(b - with_b).empty()) return false;
      if (with_b == rest) return true;
      more = rest - with_b;
    }
  }

  /// Lists the ways with `a`, `more` and whatever follows on one side and `b` on the other.
  template <class Offer, class Stop>
  void walk(const Set& piece, std::size_t direction, Set a, Set more, Set b, Offer&& offer,
            Stop&& stop) const {
    for (; !stop(); more = {}) {
      if (!settle(piece, direction, a, more, b)) return;
      const Set rest = piece - a;
      if (rest.empty()) return;
      Set around;
      const Set joined = flood(a, piece.first(), around);
      const Set open = (around & rest) - b;
      if (open.empty()) {
        // Nothing more can join A, so it is what it is.
        if (joined == a) offer(a, rest);
        return;
      }
      Set next;
      next.insert(open.first());
      walk(piece, direction, a, next, b, offer, stop);
      const std::size_t back = direction == kAnyDirection ? direction : opposite(direction);
      b = closed(piece, back, next, b);
    }
  }

  const std::vector<Set>& neighbours_;
  Set base_;
  std::vector<std::size_t> directions_;
  /// By direction and part: what blocks the part along it. Empty for other directions.
  std::vector<std::vector<Set>> along_;
};

}  // namespace orasp::detail
