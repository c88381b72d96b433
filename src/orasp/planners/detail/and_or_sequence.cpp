#include "orasp/planners/detail/and_or_search.h"

namespace orasp::detail {

/// The cut that a plan makes to a piece: the one that peel() found, or else the best one. Empty
/// where none is known.
template <std::size_t kWords>
auto AndOrSearch<kWords>::next_cut(const Set& piece, std::size_t parts, std::size_t allowed,
                                   bool dive) -> std::optional<Cut> {
  const auto peeled = std::ranges::find(peeled_, piece, &std::pair<Set, Set>::first);
  if (peeled != peeled_.end())
    return Cut{
        .side = peeled->second, .own_loss = 0, .estimate = 0, .order = 0, .side_waits = false};
  if (stores_) {
    const std::uint32_t number = node_of(piece, parts);
    if (exact_[number] == 0 && !dive) return std::nullopt;
    const StoredCuts& list = lists_[number];
    if (list.kept || (!list.too_many && store_cuts(number, most_loss_)))
      return next_stored_cut(number);
    if (exact_[number] == 0) return std::nullopt;  // too many to look at them all for a guess
  }
  const Set form = form_of(piece, parts);
  const bool known = is_exact(form, allowed);
  if (!known && !dive) return std::nullopt;
  const double loss = known_loss(form, parts, allowed) - bound_of_form_above(piece, parts);
  cuts_.clear();
  static_cast<void>(
      list_cuts(piece, parts, allowed,
                known ? loss + slack(scale_) * static_cast<double>(parts) : kInfinity));
  // Where the loss of the piece is exact, it is the sum of exact losses of both sides of a best
  // cut: a cut with a side that is not solved cannot be that one.
  const auto promise = [&](const Cut& cut) {
    if (!known) return cut.estimate;
    const std::array<Half, 2> sides = forms_of(halves(piece, parts, allowed, cut));
    const bool solved =
        is_exact(sides[0].set, sides[0].allowed) && is_exact(sides[1].set, sides[1].allowed);
    return solved ? cut.estimate : kInfinity;
  };
  const auto chosen = std::ranges::min_element(cuts_, {}, promise);
  if (chosen == cuts_.end() || promise(*chosen) == kInfinity) return std::nullopt;
  return *chosen;
}

/// Takes a step unless the connection is gone already. False where it is not legal.
template <std::size_t kWords>
bool AndOrSearch<kWords>::take(ConnectionIndex connection, Steps& steps) {
  if (!steps.open.contains(connection)) return true;
  if (!lister_.expander().legal(steps.open.view(), connection)) return false;
  steps.open.erase(connection);
  steps.taken.push_back(connection);
  return true;
}

/// Takes connections of a part to itself. Those that earn most as the last step of all are left to
/// the end, unless a connection between two parts earns more there or is chosen for it, which
/// `completes`.
template <std::size_t kWords>
void AndOrSearch<kWords>::take_loops(Steps& steps, bool completes) {
  if (first_ || completes) {
    for (const ConnectionIndex c : graph_.loops()) static_cast<void>(take(c, steps));
    return;
  }
  const double best_last = last_ != nullptr ? last_->most_of_loops : gains_.last_surplus();
  for (const ConnectionIndex c : graph_.loops()) {
    if (lister_.expander().completion_surplus(c) < best_last) static_cast<void>(take(c, steps));
  }
}

/// Of the connections between the two sides of a cut the one that gains most when it goes last, or,
/// where the cut `completes`, as the last step of all; kNone where that makes no difference.
template <std::size_t kWords>
ConnectionIndex AndOrSearch<kWords>::last_of_cut(const Cut& cut, const Set& rest,
                                                 const Steps& steps,
                                                 const std::vector<ConnectionIndex>& crossing,
                                                 bool completes) {
  ConnectionIndex last = kNone;
  if (!lister_.by_connection() && !completes) return last;
  double best = -kInfinity;
  std::vector<ConnectionIndex> open;
  for (const ConnectionIndex c : crossing)
    if (steps.open.contains(c)) open.push_back(c);
  lister_.gains_as_last(cut.side, rest, open,
                        [&](ConnectionIndex c, const std::optional<double>& gain) {
                          if (!gain) return;
                          const double all = *gain + (completes ? last_->surplus[c] : 0);
                          if (all <= best) return;
                          best = all;
                          last = c;
                        });
  return last;
}

/// Takes all of `needed` by repeated passes, `last` at the end. False where some step never becomes
/// legal.
template <std::size_t kWords>
bool AndOrSearch<kWords>::take_all(std::vector<ConnectionIndex>& needed, ConnectionIndex last,
                                   Steps& steps) {
  std::size_t left = needed.size();
  bool moving = true;
  while (left > 0 && moving) {
    moving = false;
    for (ConnectionIndex& c : needed) {
      if (c == kNone || (c == last && left > 1)) continue;
      if (!take(c, steps)) continue;
      c = kNone;
      --left;
      moving = true;
    }
  }
  return left == 0;
}

/// Takes the steps of a cut: every connection between the sides, and what must precede them. All
/// but the last separate nothing. `completes`: whether that is the last step of all.
template <std::size_t kWords>
bool AndOrSearch<kWords>::take_cut(const Cut& cut, const Set& rest, Steps& steps, bool completes) {
  std::vector<ConnectionIndex> needed;
  gone_.assign(problem_.num_connections(), 0);
  for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
    const auto [u, v] = problem_.ends(c);
    if ((cut.side.contains(u) && rest.contains(v)) || (cut.side.contains(v) && rest.contains(u))) {
      gone_[c] = 1;
      needed.push_back(c);
    }
  }
  const ConnectionIndex last = last_of_cut(cut, rest, steps, needed, completes);
  if (!links_.precedence.empty()) {
    const std::size_t crossing = needed.size();
    for (std::size_t i = 0; i < crossing; ++i) {
      for (const ConnectionIndex c : links_.precedence[needed[i]]) {
        if (gone_[c] == 0) needed.push_back(c);
        gone_[c] = 1;
      }
    }
  }
  return take_all(needed, last, steps);
}

template <std::size_t kWords>
std::vector<ConnectionIndex> AndOrSearch<kWords>::sequence(bool dive) {
  const std::size_t connections = problem_.num_connections();
  lift_limits();
  Steps steps{ConnectionSet::all(connections), {}};
  std::optional<First> first;
  if (first_) {
    first = choose_first(dive);
    if (!first || !take(first->connection, steps)) return {};
  }
  const std::optional<std::size_t> last_piece = piece_that_completes();
  take_loops(steps, last_piece.has_value());
  // The pieces that are still to be taken apart, one after the other; the last one is at hand.
  std::vector<Half> waiting;
  const auto wait_for = [&](const std::array<Half, 2>& sides, const Cut& cut) {
    waiting.push_back(sides[cut.side_waits ? 0 : 1]);
    waiting.push_back(sides[cut.side_waits ? 1 : 0]);
  };
  if (last_piece)
    waiting.push_back({pieces_[*last_piece], pieces_[*last_piece].size(), allowed_ | kCompletes});
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    if ((first && first->cut && i == first->piece) || i == last_piece) continue;
    waiting.push_back({pieces_[i], pieces_[i].size(), allowed_});
  }
  if (first && first->cut) {
    const Set& piece = pieces_[first->piece];
    const std::size_t allowed = limited_ ? useful(allowed_, piece.size()) : allowed_;
    wait_for(halves(piece, piece.size(), allowed, *first->cut), *first->cut);
  }
  while (!waiting.empty()) {
    const Half piece = waiting.back();
    waiting.pop_back();
    if (piece.parts == 1) continue;
    const std::size_t allowed = limited_ ? useful(piece.allowed, piece.parts) : piece.allowed;
    const std::optional<Cut> cut = next_cut(piece.set, piece.parts, allowed, dive);
    if (!cut) return {};
    const std::array<Half, 2> sides = halves(piece.set, piece.parts, allowed, *cut);
    const bool completes = (allowed & kCompletes) != 0 && piece.parts == 2;
    if (!take_cut(*cut, sides[1].set, steps, completes)) return {};
    wait_for(sides, *cut);
  }
  // What is left are connections of a part to itself, and those that only precedence held back.
  bool moving = true;
  while (moving) {
    moving = false;
    for (ConnectionIndex c = 0; c < connections; ++c) {
      if (steps.open.contains(c) && take(c, steps)) moving = true;
    }
  }
  return steps.taken.size() == connections ? steps.taken : std::vector<ConnectionIndex>{};
}

template std::vector<ConnectionIndex> AndOrSearch<1>::sequence(bool);
template std::vector<ConnectionIndex> AndOrSearch<2>::sequence(bool);
template std::vector<ConnectionIndex> AndOrSearch<4>::sequence(bool);
template std::vector<ConnectionIndex> AndOrSearch<8>::sequence(bool);
template std::vector<ConnectionIndex> AndOrSearch<16>::sequence(bool);

}  // namespace orasp::detail
