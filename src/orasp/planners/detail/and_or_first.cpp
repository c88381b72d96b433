#include "orasp/planners/detail/and_or_search.h"

namespace orasp::detail {

namespace {

/// Empty where all connections between two parts earn as much more as the last one.
std::optional<LastSteps> last_steps(const TransitionSystem& system, Expander& expander) {
  LastSteps steps;
  double least_of_pairs = kInfinity;
  double most_of_pairs = -kInfinity;
  for (ConnectionIndex c = 0; c < system.num_connections(); ++c) {
    const double surplus = expander.completion_surplus(c);
    if (!std::isfinite(surplus)) return std::nullopt;
    steps.surplus.push_back(surplus);
    const auto [u, v] = system.problem().ends(c);
    if (u == v) {
      steps.most_of_loops = std::max(steps.most_of_loops, surplus);
    } else {
      least_of_pairs = std::min(least_of_pairs, surplus);
      most_of_pairs = std::max(most_of_pairs, surplus);
    }
  }
  if (!(most_of_pairs > least_of_pairs + kRewardTolerance)) return std::nullopt;
  return steps;
}

}  // namespace

PieceProblem::PieceProblem(const TransitionSystem& the_system,
                           std::shared_ptr<const PieceGains> the_gains)
    : system(the_system),
      shared_gains(the_gains ? std::move(the_gains)
                             : std::make_shared<const PieceGains>(the_system)),
      gains(*shared_gains),
      graph(the_system.problem()) {
  const SmallPieces& small = gains.prices().small_pieces();
  if (!small.near_rows().empty()) raised.emplace(small, system.problem().num_parts());
  if (!gains.known()) return;
  Expander expander(system);
  if (!system.completes_first()) {
    last = last_steps(system, expander);
    return;
  }
  FirstSteps& steps = first.emplace();
  const SetView start = system.start().view();
  const auto span = expander.legal_actions(start);
  const std::vector<Action> legal(span.begin(), span.end());
  for (const Action& action : legal) {
    const ConnectionIndex connection = action.connection;
    const double reward = action.reward;
    Step step = expander.step(start, connection);
    double surplus = reward - gains.own(connection);
    if (step.separates) {
      const double gain = expander.cut_gain(step.a, step.b, connection).value_or(-kInfinity);
      surplus -= gain;
      steps.cuts.push_back({connection, surplus, gain, std::move(step.a)});
    } else {
      if (surplus > steps.most_without_cut + kRewardTolerance) steps.without_cut.clear();
      steps.most_without_cut = std::max(steps.most_without_cut, surplus);
      if (surplus > steps.most_without_cut - kRewardTolerance)
        steps.without_cut.push_back(connection);
    }
    steps.most = std::max(steps.most, surplus);
  }
}

/// What a plan loses by the step that completes beside the `losses` of the pieces: this step earns
/// less than the greatest surplus, or is not of the best cuts of its piece. A lower bound where the
/// search has to stop, and where it is more than `useful_loss`.
template <std::size_t kWords>
double AndOrSearch<kWords>::loss_of_completing(const std::vector<double>& losses,
                                               double useful_loss) {
  double least = first_ ? first_->most - first_->most_without_cut
                        : gains_.last_surplus() - last_->most_of_loops;
  least = std::min(least, useful_loss);
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const std::size_t parts = pieces_[i].size();
    const Set piece = form_of(pieces_[i], parts);
    scale_ = upper(piece, parts);
    double limit = losses[i] + slack(scale_);
    double step = slack(scale_);
    while (true) {
      try_is_over_ = false;
      try_ends_at_ = std::numeric_limits<std::uint64_t>::max();
      const double loss = first_ ? search_first(pieces_[i], parts, allowed_, limit)
                                 : search(piece, parts, allowed_ | kCompletes, limit);
      if (result_.stop != Stop::None || run_is_over_) return 0;
      if (loss <= limit) least = std::min(least, loss - losses[i]);
      if (loss <= limit || loss - losses[i] >= least || loss == kInfinity) break;
      step *= 2;
      limit = std::max(loss, limit + step) + slack(scale_);
    }
  }
  return std::max(0.0, least);
}

/// As search(), for a piece whose cut is the first step of all.
template <std::size_t kWords>
double AndOrSearch<kWords>::search_first(const Set& piece, std::size_t parts, std::size_t allowed,
                                         double limit) {
  if (limited_) allowed = useful(allowed, parts);
  const std::size_t begin = cuts_.size();
  const double skipped = list_first_cuts(piece, parts, allowed, limit);
  sort_cuts(begin);
  const auto [best, next] = least_loss(piece, parts, allowed, limit, begin, skipped);
  cuts_.resize(begin);
  return best < kInfinity ? best : std::max(next, std::nextafter(limit, kInfinity));
}

/// As list_cuts(), for first steps: those of `piece`, in the order of FirstSteps::cuts.
template <std::size_t kWords>
double AndOrSearch<kWords>::list_first_cuts(const Set& piece, std::size_t parts,
                                            std::size_t allowed, double limit) {
  const double here = upper(form_of(piece, parts), parts) + first_->most;
  static_cast<void>(build_tree(piece));
  double skipped = kInfinity;
  for (const FirstSteps::Cut& cut : first_->cuts) {
    if (!piece.contains(cut.a.front())) continue;
    Set side;
    for (const PartIndex part : cut.a) side.insert(part);
    const Set rest = piece - side;
    const std::size_t rest_parts = parts - cut.a.size();
    const Set side_form = form_of(side, cut.a.size());
    const Set rest_form = form_of(rest, rest_parts);
    const double own =
        here - cut.gain - cut.surplus - uppers(side_form, cut.a.size(), rest_form, rest_parts);
    add_cut(side, side_form, cut.a.size(), rest_form, rest_parts, allowed, own, limit, skipped);
  }
  return skipped;
}

/// The first step of a plan; empty where none is known. With `dive` as in sequence().
template <std::size_t kWords>
auto AndOrSearch<kWords>::choose_first(bool dive) -> std::optional<First> {
  std::optional<First> best;
  if (!first_->without_cut.empty()) {
    best = First{choose_without_cut(dive), pieces_.size(), std::nullopt,
                 first_->most - first_->most_without_cut};
  }
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Set& piece = pieces_[i];
    const std::size_t parts = piece.size();
    const std::size_t allowed = limited_ ? useful(allowed_, parts) : allowed_;
    const double loss = known_loss(form_of(piece, parts), parts, allowed);
    cuts_.clear();
    static_cast<void>(list_first_cuts(piece, parts, allowed, kInfinity));
    for (const Cut& cut : cuts_) {
      const std::array<Half, 2> sides = forms_of(halves(piece, parts, allowed, cut));
      const bool solved =
          is_exact(sides[0].set, sides[0].allowed) && is_exact(sides[1].set, sides[1].allowed);
      if (!solved && !dive) continue;
      if (best && cut.estimate - loss >= best->loss) continue;
      const auto same = std::ranges::find_if(first_->cuts, [&](const FirstSteps::Cut& one) {
        return cut.side.size() == one.a.size() && cut.side.contains(one.a.front()) &&
               std::ranges::all_of(one.a, [&](PartIndex part) { return cut.side.contains(part); });
      });
      best = First{same->connection, i, cut, cut.estimate - loss};
    }
  }
  return best;
}

/// Of the first steps that separate nothing one that takes no piece of the plan apart: it is among
/// several connections between the sides of a cut, which all go for that cut anyway, and another
/// one is the best to go last.
template <std::size_t kWords>
ConnectionIndex AndOrSearch<kWords>::choose_without_cut(bool dive) {
  const Steps untouched{ConnectionSet::all(problem_.num_connections()), {}};
  std::vector<Half> waiting;
  for (const Set& piece : pieces_) waiting.push_back({piece, piece.size(), allowed_});
  while (!waiting.empty()) {
    const Half piece = waiting.back();
    waiting.pop_back();
    if (piece.parts < 2) continue;
    const std::size_t allowed = limited_ ? useful(piece.allowed, piece.parts) : piece.allowed;
    const std::optional<Cut> cut = next_cut(piece.set, piece.parts, allowed, dive);
    if (!cut) continue;
    const std::array<Half, 2> sides = halves(piece.set, piece.parts, allowed, *cut);
    std::vector<ConnectionIndex> crossing;
    for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
      const auto [u, v] = problem_.ends(c);
      if (!piece.set.contains(u) || !piece.set.contains(v) ||
          cut->side.contains(u) == cut->side.contains(v))
        continue;
      crossing.push_back(c);
    }
    const ConnectionIndex last = last_of_cut(*cut, sides[1].set, untouched, crossing, false);
    for (const ConnectionIndex c : crossing) {
      if (crossing.size() > 1 && c != last && std::ranges::binary_search(first_->without_cut, c))
        return c;
    }
    waiting.push_back(sides[0]);
    waiting.push_back(sides[1]);
  }
  return first_->without_cut.front();
}

template double AndOrSearch<1>::loss_of_completing(const std::vector<double>&, double);
template double AndOrSearch<2>::loss_of_completing(const std::vector<double>&, double);
template double AndOrSearch<4>::loss_of_completing(const std::vector<double>&, double);
template double AndOrSearch<8>::loss_of_completing(const std::vector<double>&, double);
template double AndOrSearch<16>::loss_of_completing(const std::vector<double>&, double);
template std::optional<AndOrSearch<1>::First> AndOrSearch<1>::choose_first(bool);
template std::optional<AndOrSearch<2>::First> AndOrSearch<2>::choose_first(bool);
template std::optional<AndOrSearch<4>::First> AndOrSearch<4>::choose_first(bool);
template std::optional<AndOrSearch<8>::First> AndOrSearch<8>::choose_first(bool);
template std::optional<AndOrSearch<16>::First> AndOrSearch<16>::choose_first(bool);

}  // namespace orasp::detail
