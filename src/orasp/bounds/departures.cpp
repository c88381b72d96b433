#include "orasp/bounds/departures.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "orasp/model/detail/rules.h"

namespace orasp {
namespace {

using Word = std::uint64_t;

bool holds(std::span<const Word> set, std::size_t part) {
  return (set[part / 64] >> (part % 64) & 1U) != 0;
}

void put(std::span<Word> set, std::size_t part) {
  set[part / 64] |= Word{1} << (part % 64);
}

/// Calls visit(part) for each part of a set, ascending.
template <class Visit>
void for_each_part(std::span<const Word> set, Visit&& visit) {
  for (std::size_t w = 0; w < set.size(); ++w) {
    for (Word left = set[w]; left != 0; left &= left - 1)
      visit(static_cast<PartIndex>(w * 64 + static_cast<std::size_t>(std::countr_zero(left))));
  }
}

/// Adds `more` to `set`; whether that is new.
bool add(std::span<Word> set, std::span<const Word> more) {
  Word added = 0;
  for (std::size_t w = 0; w < set.size(); ++w) {
    added |= more[w] & ~set[w];
    set[w] |= more[w];
  }
  return added != 0;
}

}  // namespace

Departures::World::World(const TransitionSystem& system)
    : words_((system.problem().num_parts() + 63) / 64),
      ways_(std::max<std::size_t>(1, system.problem().directions().size())),
      num_parts_(system.problem().num_parts()) {
  const Problem& problem = system.problem();
  around_.assign(num_parts_ * words_, 0);
  blockers_.assign(num_parts_ * ways_ * words_, 0);
  for_each_connection(system.start().view(), [&](ConnectionIndex c) {
    const auto [a, b] = problem.ends(c);
    if (a == b) return;
    put(std::span(around_).subspan(a * words_, words_), b);
    put(std::span(around_).subspan(b * words_, words_), a);
  });
  for (PartIndex part = 0; part < num_parts_; ++part) {
    for (const Blocker& blocker : problem.blockers()[part]) {
      for (std::size_t way = 0; way < problem.directions().size(); ++way) {
        if (!problem.blocks(blocker, problem.directions()[way])) continue;
        put(std::span(blockers_).subspan((part * ways_ + way) * words_, words_), blocker.by);
      }
    }
  }
}

Departures::Departures(std::shared_ptr<const World> world, std::span<const PartIndex> piece,
                       PartIndex stays)
    : world_(std::move(world)), stays_(stays), parts_(piece.begin(), piece.end()) {
  std::ranges::sort(parts_);
  const std::size_t words = world_->words();
  there_.assign(words, 0);
  for (const PartIndex part : parts_) put(there_, part);
  sets_.assign(world_->num_parts() * world_->ways() * words, 0);
  left_.assign(world_->num_parts() * words, 0);
  for (const PartIndex part : parts_) {
    if (part == stays_) continue;
    put(std::span(left_).subspan(part * words, words), part);
    for (std::size_t way = 0; way < world_->ways(); ++way) {
      const std::span<Word> set = set_of(part, way);
      put(set, part);
      const std::span<const Word> blockers = world_->blockers(part, way);
      for (std::size_t w = 0; w < words; ++w) set[w] |= blockers[w] & there_[w];
    }
  }
  settle();
}

std::span<Departures::Word> Departures::set_of(PartIndex part, std::size_t way) {
  const std::size_t words = world_->words();
  return std::span(sets_).subspan((part * world_->ways() + way) * words, words);
}
std::span<const Departures::Word> Departures::set_of(PartIndex part, std::size_t way) const {
  const std::size_t words = world_->words();
  return std::span(sets_).subspan((part * world_->ways() + way) * words, words);
}

Departures Departures::without(std::span<const PartIndex> group) const {
  // What was forced before still is; with fewer parts left to hang on, more may be.
  Departures rest = *this;
  const std::size_t words = world_->words();
  std::vector<Word> gone(words, 0);
  for (const PartIndex part : group) put(gone, part);
  std::erase_if(rest.parts_, [&](PartIndex part) { return holds(gone, part); });
  for (std::size_t i = 0; i < rest.sets_.size(); ++i) rest.sets_[i] &= ~gone[i % words];
  for (std::size_t i = 0; i < rest.left_.size(); ++i) rest.left_[i] &= ~gone[i % words];
  for (std::size_t w = 0; w < words; ++w) rest.there_[w] &= ~gone[w];
  rest.settle();
  return rest;
}

// Adds to a set what it forces. Returns whether the part that stays is among that.
bool Departures::grow(std::span<Word> set) {
  const std::size_t words = world_->words();
  for (bool growing = true; growing;) {
    for (bool more = true; more;) {
      more = false;
      for_each_part(set, [&](PartIndex part) {
        if (part != stays_) more |= add(set, std::span(left_).subspan(part * words, words));
      });
    }
    if (holds(set, stays_)) return true;
    // What still hangs on the part that stays.
    std::vector<Word> hangs(words, 0);
    std::vector<Word> newest(words, 0);
    put(newest, stays_);
    for (bool some = true; some;) {
      std::vector<Word> next(words, 0);
      for_each_part(newest, [&](PartIndex part) { add(next, world_->around(part)); });
      some = false;
      for (std::size_t w = 0; w < words; ++w) {
        hangs[w] |= newest[w];
        newest[w] = next[w] & there_[w] & ~set[w] & ~hangs[w];
        some = some || newest[w] != 0;
      }
    }
    Word added = 0;
    for (std::size_t w = 0; w < words; ++w) {
      const Word lost = there_[w] & ~hangs[w] & ~set[w];
      added |= lost;
      set[w] |= lost;
    }
    growing = added != 0;
  }
  return false;
}

void Departures::settle() {
  const std::size_t words = world_->words();
  std::vector<Word> always(words);
  for (bool growing = true; growing;) {
    growing = false;
    for (const PartIndex part : parts_) {
      if (part == stays_) continue;
      bool open = false;
      std::ranges::fill(always, ~Word{0});
      for (std::size_t way = 0; way < world_->ways(); ++way) {
        const std::span<Word> set = set_of(part, way);
        if (!holds(set, part)) continue;  // closed
        if (grow(set)) {
          std::ranges::fill(set, Word{0});
          continue;
        }
        open = true;
        for (std::size_t w = 0; w < words; ++w) always[w] &= set[w];
      }
      if (!open) {
        possible_ = false;
        groups_.clear();
        return;
      }
      growing |= add(std::span(left_).subspan(part * words, words), always);
    }
  }
  find_groups();
}

void Departures::find_groups() {
  const std::size_t words = world_->words();
  holds_up_.assign(left_.size(), 0);
  for (const PartIndex part : parts_) {
    if (part == stays_) continue;
    for_each_part(std::span(left_).subspan(part * words, words), [&](PartIndex earlier) {
      put(std::span(holds_up_).subspan(earlier * words, words), part);
    });
  }
  groups_.clear();
  std::vector<Word> seen(words, 0);
  for (const PartIndex part : parts_) {
    if (part == stays_ || holds(seen, part)) continue;
    std::vector<PartIndex>& group = groups_.emplace_back();
    for_each_part(std::span(left_).subspan(part * words, words), [&](PartIndex other) {
      if (!holds(std::span(left_).subspan(other * words, words), part)) return;
      group.push_back(other);
      put(seen, other);
    });
  }
}

bool Departures::may_leave(std::span<const PartIndex> group) const {
  std::vector<Word> own(world_->words(), 0);
  for (const PartIndex part : group) put(own, part);
  for (std::size_t way = 0; way < world_->ways(); ++way) {
    if (std::ranges::all_of(group, [&](PartIndex part) {
          const auto set = set_of(part, way);
          return holds(set, part) &&
                 std::ranges::equal(set, own, [](Word a, Word b) { return (a & ~b) == 0; });
        }))
      return true;
  }
  return false;
}

bool Departures::may_leave_more(std::span<const PartIndex> group, std::size_t than) const {
  const std::size_t words = world_->words();
  std::vector<Word> sets(3 * words, 0);
  const std::span<Word> own = std::span(sets).first(words);
  const std::span<Word> held = std::span(sets).subspan(words, words);
  const std::span<Word> before = std::span(sets).last(words);
  for (const PartIndex part : group) {
    put(own, part);
    add(held, std::span(holds_up_).subspan(part * words, words));
  }
  for (std::size_t w = 0; w < words; ++w) held[w] &= ~own[w];
  for (std::size_t way = 0; way < world_->ways(); ++way) {
    std::ranges::fill(before, Word{0});
    // Who has left by then without the group has left before it, and so must not wait for it.
    const bool open = std::ranges::all_of(group, [&](PartIndex part) {
      const std::span<const Word> set = set_of(part, way);
      Word waits = 0;
      for (std::size_t w = 0; w < words; ++w) {
        before[w] |= set[w];
        waits |= set[w] & held[w];
      }
      return waits == 0 && holds(set, part);
    });
    if (!open) continue;
    std::size_t gone = 0;
    for (std::size_t w = 0; w < words; ++w)
      gone += static_cast<std::size_t>(std::popcount(before[w] & ~own[w]));
    if (parts_.size() - gone > than) return true;
  }
  return false;
}

}  // namespace orasp
