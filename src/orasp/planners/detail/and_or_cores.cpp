#include "orasp/planners/detail/and_or_search.h"

namespace orasp::detail {

/// Lists the cores of the problem with what they gain, once: connected sets of few parts, of which
/// every tree of cuts of a larger piece comes to one.
///
/// Idea.       Sizes let every cut have the connection that costs least for what it separates; the
///             least spanning tree of a piece (CutTrees) counts what connections cost at a cut that
///             takes a single part off. The last few cuts of a piece cost more, since both sides
///             are small, and so their connections weigh more: where these are dear, more is lost
///             than any of the two tells. Follow the larger side of each cut from a piece S of n
///             parts on, to the first with at most K: a core P, of k parts. All cuts but those of P
///             are at connections that are a spanning tree of S with P made one part, whose least
///             cost is T(S/P). So
///
///                 V(S)  <=  max over cores P within S of  g(n) - g(k) - l(k) - T(S/P) + V(P),
///
///             g the bound by sizes and l(k) the least that the cut before P loses by it. V(P) is
///             found by the search itself, for each core.
/// Completing. Where it matters which step is the last, that one is a cut of P, or of a smaller
///             side, which then has two parts or more. What that loses by sizes alone stands in
///             loss_off_core_.
/// Cost.       Some microseconds a core once, and for each piece the ways from the parts of a core
///             up a tree (PieceTree) for each core that promises more than what was found.
template <std::size_t kWords>
void AndOrSearch<kWords>::find_cores() {
  if (cores_known_) return;
  cores_known_ = true;
  const bool all_cuts = !links_.along_forest || graph_.is_forest();
  if (!all_cuts || !gains_.sizes_known() || !gains_.trees().any()) return;
  const std::vector<std::vector<Set>> by_size = list_small_sets();
  const std::size_t most_parts = by_size.size() - 1;
  if (most_parts < kLeastCoreParts) return;
  lift_limits();
  for (std::size_t size = 1; size <= most_parts; ++size) {
    const double loss_before = loss_of_cut_to_core(size, most_parts);
    if (loss_before == kInfinity) continue;
    for (const Set& set : by_size[size]) {
      for (const bool completes : {false, true}) {
        if (!completes || last_ != nullptr) add_core(set, size, loss_before, completes);
        if (!must_stop()) continue;
        for (auto& cores : cores_) cores.clear();
        return;
      }
    }
  }
  for (auto& cores : cores_) std::ranges::stable_sort(cores, {}, &Core::least);
  most_core_parts_ = most_parts;
  measure_loss_off_core();
}

/// The connected sets of parts, by size from 1 on, up to the size of which there are too many.
template <std::size_t kWords>
auto AndOrSearch<kWords>::list_small_sets() const -> std::vector<std::vector<Set>> {
  const std::size_t most_sets = std::min(kMostCores, kMostCoresPerPart * problem_.num_parts());
  std::vector<std::vector<Set>> by_size(2);
  for (const Set& piece : pieces_) {
    piece.for_each([&](std::size_t part) {
      Set single;
      single.insert(part);
      by_size[1].push_back(single);
    });
  }
  while (by_size.size() <= listed_core_parts_) {
    std::vector<Set> larger;
    for (const Set& set : by_size.back()) {
      Set around;
      set.for_each([&](std::size_t part) { around = around | links_.neighbours[part]; });
      (around - set).for_each([&](std::size_t part) {
        larger.push_back(set);
        larger.back().insert(part);
      });
    }
    std::ranges::sort(larger, {}, &Set::words);
    const auto same = std::ranges::unique(larger);
    larger.erase(same.begin(), same.end());
    if (larger.empty() || larger.size() > most_sets) break;
    by_size.push_back(std::move(larger));
  }
  return by_size;
}

/// The least that a cut loses by sizes that leaves a core with so many parts; infinite where there
/// is none. Pieces larger than `most_parts` are cut so, and a core is the larger side.
template <std::size_t kWords>
double AndOrSearch<kWords>::loss_of_cut_to_core(std::size_t parts, std::size_t most_parts) const {
  double least = kInfinity;
  const std::size_t largest = std::min(2 * parts, problem_.num_parts());
  for (std::size_t n = most_parts + 1; n <= largest && n - parts <= gains_.most_moved(); ++n)
    least = std::min(least, loss_by_sizes(n - parts, parts));
  return least;
}

/// Adds a core unless it cannot be cut down to its parts.
template <std::size_t kWords>
void AndOrSearch<kWords>::add_core(const Set& set, std::size_t parts, double loss_before,
                                   bool completes) {
  const Set form = form_of(set, parts);
  const double most = upper(form, parts);
  scale_ = most;
  const std::size_t allowed = (allowed_ & kMostAllowed) | (completes ? kCompletes : 0);
  const double loss = search(form, parts, allowed, kInfinity);
  if (loss == kInfinity) return;
  Core core{.set = set, .cost = gains_.by_size(parts) - (most - loss) + loss_before, .least = 0};
  core.least = core.cost - tree(set);
  cores_[completes ? 1 : 0].push_back(core);
}

/// Fills loss_off_core_: the least that a cut with two parts or more on its smaller side loses by
/// sizes, of pieces with more parts than cores have, up to each number of parts.
template <std::size_t kWords>
void AndOrSearch<kWords>::measure_loss_off_core() {
  loss_off_core_.assign(problem_.num_parts() + 1, kInfinity);
  for (std::size_t n = most_core_parts_ + 1; n < loss_off_core_.size(); ++n) {
    double least = loss_off_core_[n - 1];
    for (std::size_t a = 2; a <= std::min(n / 2, gains_.most_moved()); ++a)
      least = std::min(least, loss_by_sizes(a, n - a));
    loss_off_core_[n] = least;
  }
}

/// A lower bound on the loss of a piece, whose bound is `bound`, by its cores; 0 where none are
/// known.
template <std::size_t kWords>
double AndOrSearch<kWords>::loss_by_cores(const Set& piece, std::size_t parts, double bound,
                                          bool completes) {
  if (most_core_parts_ == 0 || parts <= most_core_parts_) return unknown_loss();
  const double tree_here = build_tree(piece);
  const auto look_at_cores = [&](const std::vector<Core>& cores) {
    double found = kInfinity;
    for (const Core& core : cores) {
      if (core.least >= found) break;
      if (!(core.set - piece).empty()) continue;
      list_parts(core.set, core_parts_);
      found = std::min(found, core.cost - piece_tree_.saved(core_parts_));
    }
    return found;
  };
  double least = look_at_cores(cores_[0]);
  if (completes) least = std::min(least + loss_off_core_[parts], look_at_cores(cores_[1]));
  // By how much sizes and the tree alone are above the bound. What is found is often the loss
  // itself: it is not rounded down, so that the limit above it has room for what sums are off.
  const double above = gains_.by_size(parts) - tree_here - bound;
  return std::max(unknown_loss(), least - above);
}

template void AndOrSearch<1>::find_cores();
template double AndOrSearch<1>::loss_by_cores(const Set&, std::size_t, double, bool);
template void AndOrSearch<2>::find_cores();
template double AndOrSearch<2>::loss_by_cores(const Set&, std::size_t, double, bool);
template void AndOrSearch<4>::find_cores();
template double AndOrSearch<4>::loss_by_cores(const Set&, std::size_t, double, bool);
template void AndOrSearch<8>::find_cores();
template double AndOrSearch<8>::loss_by_cores(const Set&, std::size_t, double, bool);
template void AndOrSearch<16>::find_cores();
template double AndOrSearch<16>::loss_by_cores(const Set&, std::size_t, double, bool);

}  // namespace orasp::detail
