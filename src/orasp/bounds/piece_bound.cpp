#include "orasp/bounds/piece_bound.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>

#include "orasp/model/detail/connectivity.h"
#include "orasp/model/tolerance.h"

namespace orasp {

struct PieceBound::Scratch {
  Scratch(const TransitionSystem& system, bool lists)
      : graph(system.problem()),
        connectivity(graph, lists),
        kept(system.kept()),
        keeps(!kept.empty()),
        words(system.words()) {}
  CutTrees trees;
  detail::AssemblyGraph graph;
  detail::Connectivity connectivity;
  std::vector<PartIndex> piece;
  ConnectionSet kept;
  bool keeps;
  std::vector<std::uint64_t> words;
  /// The three below are filled where a piece may end as units of several parts. What the cuts of
  /// each piece of a state gain at most:
  std::vector<double> gains;
  /// How much more each piece gains if the last step of all is its last cut:
  std::vector<double> surpluses;
  /// The piece that each part belongs to, a place in the two above:
  std::vector<std::size_t> piece_of;

  /// The connections that are there in the state `open` of a disassembly.
  [[nodiscard]] SetView present(SetView open) {
    if (!keeps) return open;
    std::ranges::transform(open, kept.view(), words.begin(), std::bit_or());
    return words;
  }
};

PieceBound::PieceBound(const TransitionSystem& system, Kind kind, const PieceBound* like)
    : PieceBound(system, kind,
                 like != nullptr ? like->gains_ : std::make_shared<const PieceGains>(system)) {}

PieceBound::PieceBound(const TransitionSystem& system, Kind kind,
                       std::shared_ptr<const PieceGains> gains)
    : gains_(std::move(gains)) {
  sizes_ = kind != Kind::Parts && gains_->known() && gains_->sizes_known();
  parts_ = kind != Kind::Sizes && gains_->known() && gains_->parts_known();
  known_ = sizes_ || parts_;
  if (!known_) return;
  scratch_ = std::make_unique<Scratch>(system, parts_ || gains_->has_units());
  scratch_->trees = gains_->trees();
  completes_first_ = system.completes_first();
  num_steps_ = system.num_steps();
  if (completes_first_ && num_steps_ > 0) look_at_first_step(system);
}

void PieceBound::look_at_first_step(const TransitionSystem& system) {
  const ConnectionSet& start = system.start();
  try {
    Expander expander(system);
    const auto legal = expander.legal_actions(start.view());
    const double pieces = (*this)(start.view());
    changes_.resize(legal.size());
    of_successors(start.view(), pieces, legal, changes_);
    double most = -kInfinity;
    for (std::size_t i = 0; i < legal.size(); ++i)
      most = std::max(most, legal[i].reward + changes_[i]);
    if (!legal.empty()) first_extra_ = most - pieces;
  } catch (const InputError&) {
    known_ = false;  // a formula without a value for a step that no plan may ever take
  }
}

PieceBound::~PieceBound() = default;

double PieceBound::of_piece(std::span<const PartIndex> piece) const {
  double bound = kInfinity;
  if (sizes_) bound = gains_->by_size(piece.size(), gains_->excess(piece));
  if (parts_) bound = std::min(bound, gains_->by_parts(piece));
  return bound;
}

// The bound of a piece whose last cut is the last step of all.
double PieceBound::of_last_piece(std::span<const PartIndex> piece) const {
  const std::size_t excess = gains_->excess(piece);
  if (excess + 1 == piece.size()) return -kInfinity;
  double bound = kInfinity;
  if (sizes_) bound = gains_->last_by_size(piece.size(), excess);
  if (parts_) bound = std::min(bound, gains_->by_parts(piece) + gains_->surplus_of_cut());
  return bound;
}

// Fills Scratch::gains, surpluses and piece_of for the state `open`, and returns the sum of the
// gains.
double PieceBound::measure_units(SetView open) {
  Scratch& s = *scratch_;
  double sum = 0;
  s.gains.clear();
  s.surpluses.clear();
  s.piece_of.resize(s.graph.num_parts());
  s.graph.for_each_piece(s.present(open), [&](std::span<const PartIndex> piece) {
    for (const PartIndex part : piece) s.piece_of[part] = s.gains.size();
    s.gains.push_back(of_piece(piece));
    s.surpluses.push_back(of_last_piece(piece) - s.gains.back());
    sum += s.gains.back();
  });
  return sum;
}

void PieceBound::of_successors_with_units(SetView open, double here,
                                          std::span<const Action> actions,
                                          std::span<double> bounds) {
  Scratch& s = *scratch_;
  measure_units(open);
  s.connectivity.analyse(s.present(open), false);
  // Returns the greatest surplus of all pieces but `piece`.
  const auto greatest_but = [&](std::size_t piece) {
    double greatest = gains_->surplus_without_cut();
    for (std::size_t p = 0; p < s.surpluses.size(); ++p) {
      if (p != piece) greatest = std::max(greatest, s.surpluses[p]);
    }
    return greatest;
  };
  const auto best =
      static_cast<std::size_t>(std::ranges::max_element(s.surpluses) - s.surpluses.begin());
  const double others = greatest_but(best);
  const double greatest = std::max(others, s.surpluses[best]);
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const ConnectionIndex c = actions[i].connection;
    bounds[i] = here - gains_->own(c);
    const std::uint32_t a = s.connectivity.below(c);
    if (a == 0) continue;
    s.piece.clear();
    s.connectivity.lower_side(c).for_each([&](PartIndex part) { s.piece.push_back(part); });
    s.connectivity.upper_side(c).for_each([&](PartIndex part) { s.piece.push_back(part); });
    const std::span<const PartIndex> all(s.piece);
    const std::size_t cut_piece = s.piece_of[all.front()];
    const double first = of_piece(all.first(a));
    const double second = of_piece(all.subspan(a));
    bounds[i] += first + second - s.gains[cut_piece];
    if (completes_first_) continue;
    const double now =
        std::max({cut_piece == best ? others : greatest, of_last_piece(all.first(a)) - first,
                  of_last_piece(all.subspan(a)) - second});
    bounds[i] += now - greatest;
  }
}

double PieceBound::operator()(SetView open) {
  if (!known_) return kInfinity;
  double sum = 0;
  std::size_t left = 0;
  for_each_connection(open, [&](ConnectionIndex c) {
    sum += gains_->own(c);
    ++left;
  });
  if (left == 0) return 0;
  if (completes_first_ && left == num_steps_) sum += first_extra_;
  sum -= scratch_->trees.of(scratch_->present(open));
  if (gains_->has_units()) {
    sum += measure_units(open);
    if (completes_first_) return sum;
    return sum +
           std::max(gains_->surplus_without_cut(), *std::ranges::max_element(scratch_->surpluses));
  }
  scratch_->graph.for_each_piece(open,
                                 [&](std::span<const PartIndex> piece) { sum += of_piece(piece); });
  return sum + gains_->surplus_of_last_pair();
}

// By prices alone a cut of S into A and B changes the bound by
//
//     min(S) - min(A) - min(B)  =  -max(min(A), min(B)),
//
// where min() is the least price of a side. In preorder one side is a run and the other what stands
// around it, so all cuts together take O(parts log parts), not O(parts) each.
void PieceBound::of_successors_by_runs(double here, std::span<const Action> actions,
                                       std::span<double> bounds) {
  const detail::Connectivity& connectivity = scratch_->connectivity;
  const std::size_t parts = scratch_->graph.num_parts();
  std::vector<std::size_t> place(parts, parts);  // by part: where it stands in its piece's run
  std::vector<std::size_t> piece(parts, 0);      // by part: its piece's number
  /// The least prices of a piece: of 2^k parts from each place on, up to a place, and from one on.
  struct LeastPrices {
    std::vector<std::vector<double>> of_run;
    std::vector<double> up_to;
    std::vector<double> from;
  };
  std::vector<LeastPrices> pieces;
  const auto add_piece = [&](std::span<const PartIndex> run) {
    LeastPrices& least = pieces.emplace_back();
    const std::size_t n = run.size();
    least.of_run.emplace_back(n);
    least.up_to.assign(n + 1, kInfinity);
    least.from.assign(n + 1, kInfinity);
    for (std::size_t i = 0; i < n; ++i) {
      place[run[i]] = i;
      piece[run[i]] = pieces.size() - 1;
      least.of_run[0][i] = gains_->prices().price(run[i]);
      least.up_to[i + 1] = std::min(least.up_to[i], least.of_run[0][i]);
    }
    for (std::size_t i = n; i-- > 0;)
      least.from[i] = std::min(least.from[i + 1], least.of_run[0][i]);
    for (std::size_t size = 1; 2 * size <= n; size *= 2) {
      const std::vector<double>& half = least.of_run.back();
      std::vector<double> whole(n - 2 * size + 1);
      for (std::size_t i = 0; i < whole.size(); ++i) whole[i] = std::min(half[i], half[i + size]);
      least.of_run.push_back(std::move(whole));
    }
  };
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const ConnectionIndex c = actions[i].connection;
    bounds[i] = here - gains_->own(c);
    const std::size_t below = connectivity.below(c);
    if (below == 0) continue;
    const PartIndex first = connectivity.lower_side(c).runs[0].front();
    if (place[first] == parts) add_piece(connectivity.piece_of(first).runs[0]);
    const LeastPrices& least = pieces[piece[first]];
    const std::size_t begin = place[first];
    const std::size_t end = begin + below;
    const auto level = static_cast<std::size_t>(std::bit_width(below) - 1);
    const std::vector<double>& runs = least.of_run[level];
    const double lower = std::min(runs[begin], runs[end - (std::size_t{1} << level)]);
    const double upper = std::min(least.up_to[begin], least.from[end]);
    bounds[i] -= std::max(lower, upper);
  }
}

void PieceBound::of_successors(SetView open, double here, std::span<const Action> actions,
                               std::span<double> bounds) {
  const std::size_t left = count(open);
  if (left == 1) {
    std::ranges::fill(bounds, 0.0);
    return;
  }
  if (completes_first_ && left == num_steps_) here -= first_extra_;
  if (gains_->has_units()) {
    of_successors_with_units(open, here, actions, bounds);
  } else {
    of_successors_by_pieces(open, here, actions, bounds);
  }
  CutTrees& trees = scratch_->trees;
  if (!trees.any()) return;
  trees.measure_changes(scratch_->present(open));
  for (std::size_t i = 0; i < actions.size(); ++i) bounds[i] -= trees.change(actions[i].connection);
}

// Of pieces that end as single parts.
void PieceBound::of_successors_by_pieces(SetView open, double here, std::span<const Action> actions,
                                         std::span<double> bounds) {
  detail::Connectivity& connectivity = scratch_->connectivity;
  connectivity.analyse(open, false);
  if (parts_ && !sizes_ && gains_->prices().plain() &&
      scratch_->graph.num_parts() > PieceGains::kMostPartsInTable) {
    of_successors_by_runs(here, actions, bounds);
    return;
  }
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const ConnectionIndex c = actions[i].connection;
    bounds[i] = here - gains_->own(c);
    const std::uint32_t a = connectivity.below(c);
    if (a == 0) continue;
    const std::uint32_t n = connectivity.piece(c);
    if (!parts_) {
      bounds[i] += gains_->by_size(a) + gains_->by_size(n - a) - gains_->by_size(n);
      continue;
    }
    std::vector<PartIndex>& piece = scratch_->piece;
    piece.clear();
    connectivity.lower_side(c).for_each([&](PartIndex part) { piece.push_back(part); });
    connectivity.upper_side(c).for_each([&](PartIndex part) { piece.push_back(part); });
    const std::span<const PartIndex> all(piece);
    bounds[i] += of_piece(all.first(a)) + of_piece(all.subspan(a)) - of_piece(all);
  }
}

bool PieceBound::single_part_is_best(std::size_t parts) const {
  if (!sizes_ || parts < 2) return true;
  const double best = gains_->by_size(parts);
  return gains_->gain(1, parts - 1) + gains_->by_size(parts - 1) >=
         best - kRewardTolerance * std::max(1.0, std::abs(gains_->gain(1, parts - 1)));
}

void PieceBound::add_change(SetView open, std::span<Action> actions) {
  if (actions.empty()) return;
  if (count(open) == 1) {
    actions.front().reward -= (*this)(open);
    return;
  }
  changes_.resize(actions.size());
  of_successors(open, 0, actions, changes_);
  for (std::size_t i = 0; i < actions.size(); ++i) actions[i].reward += changes_[i];
}

}  // namespace orasp
