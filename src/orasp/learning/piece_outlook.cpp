#include "orasp/learning/piece_outlook.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include "orasp/model/detail/rules.h"

namespace orasp {

namespace {

constexpr double kSlack = 1e-9;

std::uint32_t lowest(std::uint64_t bits) {
  return static_cast<std::uint32_t>(std::countr_zero(bits));
}
std::uint64_t bit(std::uint32_t number) {
  return std::uint64_t{1} << number;
}
std::size_t size_of(std::uint64_t bits) {
  return static_cast<std::size_t>(std::popcount(bits));
}

}  // namespace

void PieceOutlook::Values::clear() {
  if (size_ > 0) ++round_;
  size_ = 0;
}

std::size_t PieceOutlook::Values::slot_of(Mask parts) const {
  const std::size_t last = slots_.size() - 1;
  std::size_t slot = (parts * 0x9E3779B97F4A7C15U >> 32U) & last;
  while (slots_[slot].round == round_ && slots_[slot].parts != parts) slot = (slot + 1) & last;
  return slot;
}

const double* PieceOutlook::Values::find(Mask parts) const {
  const Slot& slot = slots_[slot_of(parts)];
  return slot.round == round_ ? &slot.value : nullptr;
}

void PieceOutlook::Values::put(Mask parts, double value) {
  if (2 * (size_ + 1) > slots_.size()) {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    for (const Slot& slot : old) {
      if (slot.round == round_) slots_[slot_of(slot.parts)] = slot;
    }
  }
  slots_[slot_of(parts)] = {parts, round_, value};
  ++size_;
}

PieceOutlook::PieceOutlook(const TransitionSystem& system) : system_(system), gains_(system) {
  const Problem& problem = system.problem();
  known_ = !system.wide() && gains_.known() && gains_.sizes_known() && system.gain_by_sizes() &&
           !gains_.has_units() && problem.spec().base.empty() && system.kept().empty() &&
           !problem.limits().max_moved_mass;
  if (!known_) return;
  const std::size_t most_parts = std::min(problem.num_parts(), kMostParts);
  sizes_.resize(most_parts + 1);
  for (std::size_t n = 2; n <= most_parts; ++n) {
    std::vector<std::pair<double, std::uint32_t>> ranked;
    for (std::uint32_t a = 1; a <= n / 2; ++a) {
      const double worth = gain(a, n - a) + gains_.by_size(a) + gains_.by_size(n - a);
      if (std::isfinite(worth)) ranked.emplace_back(-worth, a);
    }
    // Differences that are no more than rounding are none.
    std::ranges::stable_sort(ranked, [](const auto& x, const auto& y) {
      return x.first < y.first - kSlack * std::max(1.0, std::abs(y.first));
    });
    for (const auto& [worth, a] : ranked) sizes_[n].push_back(a);
  }
  double all = 0;
  std::size_t cuts = 0;
  system.rules().graph.for_each_piece(system.present(system.start().view()).view(),
                                      [&](std::span<const PartIndex> piece) {
                                        all += gains_.by_size(piece.size());
                                        cuts += piece.size() - 1;
                                      });
  if (all != 0 && cuts > 0) unit_ = std::abs(all) / static_cast<double>(cuts);
  local_.resize(problem.num_parts());
  blockers_.resize(problem.directions().size());
}

std::span<const PieceOutlook::Step> PieceOutlook::look(SetView open,
                                                       std::span<const Action> actions) {
  steps_.assign(actions.size(), {});
  if (!known_) return steps_;
  present_ = system_.present(open);
  std::vector<std::uint32_t> piece_of(system_.problem().num_parts());
  std::vector<std::vector<PartIndex>> pieces;
  system_.rules().graph.for_each_piece(present_.view(), [&](std::span<const PartIndex> piece) {
    for (const PartIndex p : piece) piece_of[p] = static_cast<std::uint32_t>(pieces.size());
    pieces.emplace_back(piece.begin(), piece.end());
  });
  std::vector<std::vector<std::size_t>> mine(pieces.size());
  for (std::size_t i = 0; i < actions.size(); ++i)
    mine[piece_of[system_.problem().ends(actions[i].connection)[0]]].push_back(i);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (mine[i].empty() || pieces[i].size() > kMostParts) continue;
    std::ranges::sort(pieces[i]);
    enter(pieces[i], present_.view());
    look_at_piece(actions, mine[i]);
  }
  return steps_;
}

void PieceOutlook::enter(std::span<const PartIndex> piece, SetView present) {
  const Problem& problem = system_.problem();
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::ranges::fill(local_, kNone);
  for (std::uint32_t i = 0; i < piece.size(); ++i) local_[piece[i]] = i;
  around_.assign(piece.size(), 0);
  for (auto& along : blockers_) along.assign(piece.size(), 0);
  for (std::uint32_t i = 0; i < piece.size(); ++i) {
    for (const auto& half : system_.rules().graph.around(piece[i])) {
      if (contains(present, half.connection)) around_[i] |= bit(local_[half.other]);
    }
    if (problem.blockers().empty()) continue;
    for (const Blocker& blocker : problem.blockers()[piece[i]]) {
      const std::uint32_t by = local_[blocker.by];
      if (by == kNone) continue;
      for (std::size_t d = 0; d < blockers_.size(); ++d) {
        if (problem.blocks(blocker, static_cast<std::size_t>(problem.directions()[d])))
          blockers_[d][i] |= bit(by);
      }
    }
  }
  values_.clear();
  changed_.clear();
  left_out_ = 0;
}

void PieceOutlook::look_at_piece(std::span<const Action> actions,
                                 std::span<const std::size_t> mine) {
  const std::size_t parts = around_.size();
  const Mask all = parts == kMostParts ? ~Mask{0} : bit(static_cast<std::uint32_t>(parts)) - 1;
  const double bound = gains_.by_size(parts);
  const double slack = kSlack * std::max(1.0, std::abs(bound));
  tried_ = 0;
  most_tried_ = kMostTried;
  double best = value(all, parts);
  most_tried_ = kTriedForStep;
  for (const std::size_t i : mine) {
    Step& step = steps_[i];
    step.known = true;
    const auto& ends = system_.problem().ends(actions[i].connection);
    const std::array<std::uint32_t, 2> bits = {local_[ends[0]], local_[ends[1]]};
    double after = best;
    tried_ = 0;
    if (bits[0] != bits[1]) {
      // Of several connections between two parts another may be left.
      std::size_t joining = 0;
      for (const auto& half : system_.rules().graph.around(ends[0])) {
        if (half.other == ends[1] && contains(present_.view(), half.connection)) ++joining;
      }
      if (joining == 1) {
        around_[bits[0]] &= ~bit(bits[1]);
        around_[bits[1]] &= ~bit(bits[0]);
        const Mask a = reached(bits[0], all);
        if (a == all) {
          left_out_ = bit(bits[0]) | bit(bits[1]);
          changed_.clear();
          after = value(all, parts);
          left_out_ = 0;
        } else {
          const Mask b = all & ~a;
          const std::size_t many = size_of(a);
          const double cut = gain(many, parts - many);
          after = cut + value(a, many) + value(b, parts - many);
        }
        around_[bits[0]] |= bit(bits[1]);
        around_[bits[1]] |= bit(bits[0]);
      }
    }
    step.loss = after;
    step.at_bound = after >= bound - slack;
  }
  for (const std::size_t i : mine) best = std::max(best, steps_[i].loss);
  for (const std::size_t i : mine) {
    double& loss = steps_[i].loss;
    loss = std::isfinite(loss) ? (best - loss <= slack ? 0.0 : best - loss) : kInfinity;
  }
}

PieceOutlook::Mask PieceOutlook::reached(std::uint32_t from, Mask parts) const {
  Mask reached = bit(from);
  Mask edge = reached;
  while (edge != 0) {
    Mask next = 0;
    for (; edge != 0; edge &= edge - 1) next |= around_[lowest(edge)];
    edge = next & parts & ~reached;
    reached |= edge;
  }
  return reached;
}

bool PieceOutlook::connected(Mask parts) const {
  return reached(lowest(parts), parts) == parts;
}

bool PieceOutlook::holds_without(Mask parts, Mask taken) const {
  Mask beside = 0;
  for (Mask left = taken; left != 0; left &= left - 1) beside |= around_[lowest(left)];
  const Mask rest = parts & ~taken;
  beside &= rest;
  if ((beside & (beside - 1)) == 0) return true;
  Mask reached = beside & (~beside + 1);
  Mask edge = reached;
  while (edge != 0) {
    Mask next = 0;
    for (; edge != 0; edge &= edge - 1) next |= around_[lowest(edge)];
    edge = next & rest & ~reached;
    reached |= edge;
    if ((beside & ~reached) == 0) return true;
  }
  return false;
}

// Blocking is antisymmetric: A leaves B along a direction where B leaves A along the opposite one.
bool PieceOutlook::comes_apart(Mask a, Mask b) const {
  if (blockers_.empty()) return true;
  return std::ranges::any_of(blockers_, [&](const std::vector<Mask>& along) {
    for (Mask left = a; left != 0; left &= left - 1) {
      if ((along[lowest(left)] & b) != 0) return false;
    }
    return true;
  });
}

double PieceOutlook::gain(std::size_t a, std::size_t b) const {
  return gains_.gain(std::min(a, b), std::max(a, b));
}

double PieceOutlook::value(Mask parts, std::size_t size) {
  if (size == 1) return 0;
  Values& values = left_out_ != 0 && (parts & left_out_) == left_out_ ? changed_ : values_;
  if (const double* known = values.find(parts)) return *known;
  const double found = size <= kExact ? exact(parts, size) : peeled(parts, size);
  values.put(parts, found);
  return found;
}

double PieceOutlook::exact(Mask parts, std::size_t size) {
  const double bound = most(size);
  const double enough = bound - kSlack * std::max(1.0, std::abs(bound));
  double best = -kInfinity;
  // All subsets that hold the first part, but for `parts`.
  const Mask first = parts & (~parts + 1);
  const Mask others = parts ^ first;
  for (Mask more = (others - 1) & others;; more = (more - 1) & others) {
    const Mask a = first | more;
    const Mask b = parts ^ a;
    const std::size_t many = size_of(a);
    const double cut = gain(many, size - many);
    if (cut + most(many) + most(size - many) > best && connected(a) && connected(b) &&
        comes_apart(a, b)) {
      best = std::max(best, cut + value(a, many) + value(b, size - many));
      if (best >= enough) break;
    }
    if (more == 0) break;
  }
  return best;
}

template <class Visit>
bool PieceOutlook::for_each_single(Mask parts, Visit&& visit) {
  // Those that hang on least first: their connections hold least else together.
  for (int degree = 1; degree <= 3; ++degree) {
    for (Mask left = parts; left != 0; left &= left - 1) {
      const std::uint32_t p = lowest(left);
      const Mask around = around_[p] & parts;
      const Mask second = around & (around - 1);
      const int mine = second == 0 ? 1 : (second & (second - 1)) == 0 ? 2 : 3;
      if (mine != degree) continue;
      const Mask a = bit(p);
      if (comes_apart(a, parts ^ a) && holds_without(parts, a) && !visit(a)) return false;
    }
  }
  return true;
}

template <class Visit>
bool PieceOutlook::for_each_cut(Mask parts, std::size_t total, std::size_t size, Visit&& visit) {
  if (size == 1) return for_each_single(parts, visit);
  const auto offer = [&](Mask a) {
    return !comes_apart(a, parts & ~a) || !holds_without(parts, a) || visit(a);
  };
  for (Mask left = parts; left != 0; left &= left - 1) {
    const std::uint32_t p = lowest(left);
    for (Mask next = around_[p] & parts & ~(bit(p) - 1) & ~bit(p); next != 0; next &= next - 1) {
      const std::uint32_t q = lowest(next);
      const Mask pair = bit(p) | bit(q);
      if (size == 2) {
        if (!offer(pair)) return false;
      } else if (size == 3) {
        for (Mask third = (around_[p] | around_[q]) & parts & ~pair; third != 0;
             third &= third - 1) {
          if (!offer(pair | bit(lowest(third)))) return false;
        }
      } else {
        around_[p] &= ~bit(q);
        around_[q] &= ~bit(p);
        Mask side = reached(p, parts);
        around_[p] |= bit(q);
        around_[q] |= bit(p);
        if ((side >> q & 1U) != 0) continue;
        const std::size_t many = size_of(side);
        if (many != size && total - many != size) continue;
        if (many != size) side = parts & ~side;
        if (comes_apart(side, parts & ~side) && !visit(side)) return false;
      }
    }
  }
  return true;
}

double PieceOutlook::peeled(Mask parts, std::size_t total) {
  const double bound = most(total);
  const double enough = bound - kSlack * std::max(1.0, std::abs(bound));
  double best = -kInfinity;
  ++tried_;
  const auto goes_on = [&] {
    return best < enough && tried_ < (std::isfinite(best) ? most_tried_ : 2 * kMostTried);
  };
  for (const std::uint32_t size : sizes_[total]) {
    const double cut = gain(size, total - size);
    if (cut + most(size) + most(total - size) <= best) break;
    for_each_cut(parts, total, size, [&](Mask a) {
      best = std::max(best, cut + value(a, size) + value(parts & ~a, total - size));
      return goes_on();
    });
    if (!goes_on()) break;
  }
  return best;
}

}  // namespace orasp
