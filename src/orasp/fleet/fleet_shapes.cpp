#include "orasp/fleet/fleet_shapes.h"

#include <algorithm>
#include <map>

#include "orasp/model/tolerance.h"

namespace orasp {
namespace {

constexpr std::size_t kNever = 6;
/// Shapes of the same kind that a piece is compared to.
constexpr std::size_t kMostTries = 3;
/// Where fewer than one in kRarely of so many subassemblies is like an earlier one, looking for
/// more costs more than it saves.
constexpr std::uint64_t kPatience = 8192;
constexpr std::uint64_t kRarely = 16;
constexpr std::uint32_t kNotMet = 0xffffffffU;

}  // namespace

template <class Parts>
FleetShapes<Parts>::FleetShapes(const FleetExpander<Parts>& expander)
    : expander_(expander),
      names_matter_(expander.has_precedence() ||
                    expander.fleet().objective() == FleetObjective::Travel),
      num_parts_(expander.fleet().num_parts()),
      beside_(num_parts_),
      weight_(num_parts_, 0),
      table_(kWordsOf<Parts>),
      position_(num_parts_, kNotMet),
      colour_(num_parts_),
      next_colour_(num_parts_) {
  for (std::size_t part = 0; part < num_parts_; ++part) {
    for_each_part(expander.neighbours(part), [&](std::size_t other) {
      const auto axis = expander.axis_between(part, other);
      beside_[part][axis.value_or(kNever)] |= only<Parts>(other);
    });
  }
  const Problem& problem = expander.fleet().problem();
  if (problem.limits().max_moved_mass) {
    std::map<double, std::uint32_t> number;
    for (std::size_t part = 0; part < num_parts_; ++part) {
      const double mass = problem.parts()[part].mass;
      weight_[part] =
          number.try_emplace(mass, static_cast<std::uint32_t>(number.size())).first->second;
    }
  }
  list_turns();
}

/// The ways to map the axes that are in use to each other, either way round.
template <class Parts>
void FleetShapes<Parts>::list_turns() {
  std::array<bool, 3> used{};
  for (std::size_t part = 0; part < num_parts_; ++part) {
    for (std::size_t d = 0; d < kNever; ++d) {
      if (beside_[part][d] != 0 || expander_.blockers(part)[d] != 0) used[d / 2] = true;
    }
  }
  std::array<std::size_t, 3> axes = {0, 1, 2};
  do {
    bool keeps = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
      keeps = keeps && (used[axis] ? used[axes[axis]] : axes[axis] == axis);
    if (!keeps) continue;
    for (std::size_t flips = 0; flips < 8; ++flips) {
      Turn turn{};
      bool needed = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t flip = flips >> axis & 1U;
        needed = needed && (flip == 0 || used[axis]);
        turn[2 * axis] = static_cast<std::uint8_t>(2 * axes[axis] + flip);
        turn[2 * axis + 1] = static_cast<std::uint8_t>(2 * axes[axis] + (1 - flip));
      }
      if (needed) turns_.push_back(turn);
    }
  } while (std::next_permutation(axes.begin(), axes.end()));
}

template <class Parts>
typename FleetShapes<Parts>::Shape FleetShapes<Parts>::of(Parts piece) {
  const auto [number, is_new] = table_.insert(words_of(piece));
  if (!is_new) return shape_of_[number];
  shape_of_.push_back(number);
  if (names_matter_ || (++compared_ > kPatience && alike_ * kRarely < compared_)) return number;
  const std::uint64_t kind = kind_of(piece);
  const auto [first, last] = same_kind_.equal_range(kind);
  std::size_t tries = 0;
  std::vector<std::uint32_t> code;
  for (auto entry = first; entry != last && tries < kMostTries; ++entry, ++tries) {
    if (tries == 0) {
      encode(piece);
      code = code_;
    }
    encode(this->piece(entry->second));
    if (code_ != code) continue;
    ++alike_;
    return shape_of_[number] = entry->second;
  }
  same_kind_.emplace(kind, number);
  return number;
}

template <class Parts>
void FleetShapes<Parts>::match(Parts piece, std::span<std::size_t> place) {
  const Parts standing = this->piece(of(piece));
  if (standing == piece) {
    for_each_part(piece, [&](std::size_t part) { place[part] = part; });
    return;
  }
  encode(standing);
  const std::vector<std::size_t> order = order_;
  encode(piece);
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = order_[i];
}

/// A number that pieces of the same shape have in common, and few others; colours the parts by what
/// is beside them and beside those, however the axes are turned.
template <class Parts>
std::uint64_t FleetShapes<Parts>::kind_of(Parts piece) {
  constexpr std::size_t kRounds = 3;
  for_each_part(piece, [&](std::size_t part) { colour_[part] = weight_[part] + 1; });
  for (std::size_t round = 0; round < kRounds; ++round) {
    for_each_part(piece, [&](std::size_t part) {
      std::uint64_t sum = 0;
      for (std::size_t d = 0; d < kNumKinds; ++d) {
        const Parts here = beside_[part][d] & piece;
        if (here == 0) continue;
        const Parts across = d == kNever ? 0 : beside_[part][opposite(d)] & piece;
        const std::uint64_t kind = (d == kNever ? 0x51 : 0x17) + size_of(across) * 0x100;
        for_each_part(here, [&](std::size_t other) { sum += mixed(colour_[other] * 31 + kind); });
      }
      next_colour_[part] = mixed(colour_[part] + 0x9e3779b97f4a7c15ULL) ^ sum;
    });
    colour_.swap(next_colour_);
  }
  std::uint64_t sum = 0;
  for_each_part(piece, [&](std::size_t part) { sum += mixed(colour_[part]); });
  return sum;
}

/// The parts of the colour that is rarest in the piece.
template <class Parts>
Parts FleetShapes<Parts>::rarest(Parts piece) {
  kind_of(piece);
  Parts best = 0;
  std::uint64_t best_colour = 0;
  for (Parts left = piece; left != 0;) {
    const std::uint64_t colour = colour_[first_of(left)];
    Parts same = 0;
    for_each_part(left, [&](std::size_t part) {
      if (colour_[part] == colour) same |= only<Parts>(part);
    });
    left &= ~same;
    if (best == 0 || std::pair(size_of(same), colour) < std::pair(size_of(best), best_colour)) {
      best = same;
      best_colour = colour;
    }
  }
  return best;
}

template <class Parts>
void FleetShapes<Parts>::encode(Parts piece) {
  code_.clear();
  for_each_part(rarest(piece), [&](std::size_t first) {
    for (const Turn& turn : turns_) {
      if (!encode_from(piece, first, turn)) continue;
      code_.swap(trial_);
      order_.swap(trial_order_);
    }
  });
}

/// The code that starts at `first` to trial_. @returns whether it is less than code_.
template <class Parts>
bool FleetShapes<Parts>::encode_from(Parts piece, std::size_t first, const Turn& turn) {
  constexpr std::uint32_t kEnd = 0xfffffffeU;
  trial_.clear();
  trial_order_.assign(1, first);
  for_each_part(piece, [&](std::size_t part) { position_[part] = kNotMet; });
  position_[first] = 0;
  bool less = code_.empty();
  const auto put = [&](std::uint32_t token) {
    if (!less) {
      // All codes of a piece are as long as each other.
      const std::uint32_t other = code_[trial_.size()];
      if (token > other) return false;
      less = token < other;
    }
    trial_.push_back(token);
    return true;
  };
  const auto token_of = [&](std::size_t kind, std::size_t part) {
    return static_cast<std::uint32_t>(kind << 24U) | position_[part];
  };
  for (std::size_t i = 0; i < trial_order_.size(); ++i) {
    const std::size_t part = trial_order_[i];
    if (!put(weight_[part])) return false;
    for (std::size_t kind = 0; kind < kNumKinds; ++kind) {
      const std::size_t d = kind == kNever ? kNever : turn[kind];
      for (Parts left = beside_[part][d] & piece; left != 0; left = without_first(left)) {
        const std::size_t other = first_of(left);
        if (position_[other] == kNotMet) {
          position_[other] = static_cast<std::uint32_t>(trial_order_.size());
          trial_order_.push_back(other);
        }
        if (!put(token_of(kind, other))) return false;
      }
    }
    if (!put(kEnd)) return false;
  }
  if (!expander_.has_blocking()) return less;
  std::vector<std::uint32_t> blockers;
  for (const std::size_t part : trial_order_) {
    for (std::size_t kind = 0; kind < kNever; ++kind) {
      blockers.clear();
      for_each_part(expander_.blockers(part)[turn[kind]] & piece,
                    [&](std::size_t other) { blockers.push_back(token_of(kind, other)); });
      std::ranges::sort(blockers);
      for (const std::uint32_t token : blockers) {
        if (!put(token)) return false;
      }
    }
    if (!put(kEnd)) return false;
  }
  return less;
}

ORASP_FOR_EVERY_PART_SET(FleetShapes);

}  // namespace orasp
