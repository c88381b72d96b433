#include "orasp/planners/detail/and_or_search.h"

namespace orasp::detail {

/// What the cut of two parts gains as the last step of all, less the most that any step earns more
/// because it is the last one.
template <std::size_t kWords>
double AndOrSearch<kWords>::gain_of_last(const Set& side, const Set& rest) {
  const std::size_t part = side.first();
  std::vector<ConnectionIndex> between;
  for (const auto& half : graph_.around(static_cast<PartIndex>(part)))
    if (rest.contains(half.other)) between.push_back(half.connection);
  double best = -kInfinity;
  lister_.gains_as_last(
      side, rest, between, [&](ConnectionIndex c, const std::optional<double>& gain) {
        if (gain) best = std::max(best, *gain + last_->surplus[c] - gains_.last_surplus());
      });
  return best;
}

/// The piece of pieces_ that the last step of a plan is of, by what is known of the losses; empty
/// where it is a connection of a part with itself, and where it makes no difference.
template <std::size_t kWords>
std::optional<std::size_t> AndOrSearch<kWords>::piece_that_completes() {
  if (last_ == nullptr) return std::nullopt;
  if ((allowed_ & kCompletes) != 0) return 0;
  std::optional<std::size_t> best;
  double least = gains_.last_surplus() - last_->most_of_loops;
  bool solved = std::isfinite(least);
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const std::size_t parts = pieces_[i].size();
    const Set form = form_of(pieces_[i], parts);
    const std::size_t completing = allowed_ | kCompletes;
    // The last step only adds to what a piece loses.
    const double more =
        std::max(0.0, known_loss(form, parts, completing) - known_loss(form, parts, allowed_));
    const bool exact = is_exact(form, completing);
    const double tie = slack(more);
    const bool better = more < least - tie || (more <= least + tie && exact && !solved);
    if (!better) continue;
    least = more;
    solved = exact;
    best = i;
  }
  return best;
}

template double AndOrSearch<1>::gain_of_last(const Set&, const Set&);
template std::optional<std::size_t> AndOrSearch<1>::piece_that_completes();
template double AndOrSearch<2>::gain_of_last(const Set&, const Set&);
template std::optional<std::size_t> AndOrSearch<2>::piece_that_completes();
template double AndOrSearch<4>::gain_of_last(const Set&, const Set&);
template std::optional<std::size_t> AndOrSearch<4>::piece_that_completes();
template double AndOrSearch<8>::gain_of_last(const Set&, const Set&);
template std::optional<std::size_t> AndOrSearch<8>::piece_that_completes();
template double AndOrSearch<16>::gain_of_last(const Set&, const Set&);
template std::optional<std::size_t> AndOrSearch<16>::piece_that_completes();

}  // namespace orasp::detail
