#include "orasp/planners/detail/and_or_search.h"

#include "orasp/task/memory_limit.h"

namespace orasp::detail {

template <std::size_t kWords>
AndOrSearch<kWords>::AndOrSearch(const PieceProblem& pieces, std::uint64_t forest_seed,
                                 const Budget& budget, Result& result)
    : shared_(pieces),
      problem_(pieces.system.problem()),
      gains_(pieces.gains),
      lister_(pieces, forest_seed),
      links_(lister_.links()),
      first_(pieces.first ? &*pieces.first : nullptr),
      last_(pieces.last ? &*pieces.last : nullptr),
      graph_(pieces.graph),
      budget_(budget),
      allowed_bytes_(allowed_bytes(budget)),
      result_(result),
      bounded_(lister_.bounded()),
      limited_(problem_.limits().max_subassemblies.has_value()),
      stores_(!limited_ && bounded_ && last_ == nullptr && !pieces.system.gain_by_sizes()),
      raised_(pieces.raised ? &*pieces.raised : nullptr),
      memo_(kWords + 1),
      sweeps_(stores_ && forest_seed == 0),
      listed_core_parts_(pieces.most_core_parts) {}

/// The pieces of the problem, and how many subassemblies there may be.
template <std::size_t kWords>
void AndOrSearch<kWords>::find_pieces() {
  pieces_.clear();
  graph_.for_each_piece(ConnectionSet::all(problem_.num_connections()).view(),
                        [&](std::span<const PartIndex> piece) {
                          if (piece.size() < 2) return;
                          Set set;
                          for (const PartIndex part : piece) set.insert(part);
                          pieces_.push_back(set);
                        });
  // Pieces that are taken apart later count as subassemblies while an earlier one is taken apart,
  // so the order of the pieces matters under max_subassemblies. The bound must hold for every
  // order: it allows each piece as many subassemblies as if it were alone.
  allowed_ = std::min(problem_.limits().max_subassemblies.value_or(kMostAllowed), kMostAllowed);
  if (last_ != nullptr && pieces_.size() == 1 && graph_.loops().empty()) allowed_ |= kCompletes;
}

template <std::size_t kWords>
bool AndOrSearch<kWords>::run(std::uint64_t most_expansions, std::uint64_t most_looks) {
  run_is_over_ = false;
  peeled_.clear();
  path_of_pieces_.clear();  // a formula without a value may have ended the run before this one
  find_pieces();
  find_cores();
  run_ends_at_ = result_.statistics.expanded + most_expansions;
  looks_end_at_ = looks_ + most_looks;
  double most = 0;
  for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) most += gains_.own(c);
  if (problem_.num_connections() > 0) most += first_ ? first_->most : gains_.last_surplus();
  const auto form = [&](const Set& piece) { return form_of(piece, piece.size()); };
  for (const Set& piece : pieces_) most += upper(form(piece), piece.size());
  result_.bound = most;
  most_loss_ = std::max(0.0, most - known_reward_) + slack(most);
  std::vector<double> losses;
  for (const Set& piece : pieces_) {
    const double before = most;
    // What loses more than the known plan is of no use.
    const double useful_loss = before - known_reward_ - slack(before) / 2;
    const double loss = solve(form(piece), allowed_, useful_loss,
                              [&](double lower) { result_.bound = before - lower; });
    most -= loss;
    losses.push_back(loss);
    result_.bound = most;
    if (most == -kInfinity || result_.stop != Stop::None || run_is_over_) break;
  }
  const bool other_piece_completes = last_ != nullptr && (allowed_ & kCompletes) == 0;
  if ((first_ || other_piece_completes) && most > -kInfinity && result_.stop == Stop::None &&
      !run_is_over_)
    result_.bound = most - loss_of_completing(losses, most - known_reward_ - slack(most) / 2);
  result_.statistics.states = std::max<std::uint64_t>(result_.statistics.states, memo_.size());
  result_.statistics.peak_bytes = std::max(result_.statistics.peak_bytes, bytes());
  return result_.stop == Stop::None && !run_is_over_;
}

/// The loss of a piece, or the best lower bound on it that the run allows; or one above
/// `useful_loss`. The limit on the loss grows from the least that is possible (iterative
/// deepening), by steps that make each limit take about as long as all before it together; a run
/// goes on with the limit at which the one before it had to end. `report` is told each lower bound.
/// Reference: Sarkar, Chakrabarti, Ghose and De Sarkar (1991), Reducing reexpansions in iterative-
/// deepening search by controlling cutoff bounds, Artificial Intelligence 50(2), 207-221.
template <std::size_t kWords>
template <class Report>
double AndOrSearch<kWords>::solve(const Set& piece, std::size_t allowed, double useful_loss,
                                  Report&& report) {
  const std::size_t parts = piece.size();
  const double scale = upper(piece, parts);
  scale_ = scale;
  if (!(deepening_.piece == piece)) {
    deepening_ = {.piece = piece,
                  .limit = bounded_ ? known_loss(piece, parts, allowed) + slack(scale) : kInfinity,
                  // Where cuts are kept, losses are as many different numbers as there are cuts.
                  .step = stores_ ? std::max(slack(scale), 1e-5 * std::abs(scale)) : slack(scale),
                  .patience = 64 * parts};
  }
  // The search goes into depth first. One wrong choice high up makes it try every way to fail
  // further down. So each try ends after a while, and the next one takes equal cuts in another
  // order; what was proved stays.
  Deepening& now = deepening_;
  while (true) {
    now.limit = std::min(now.limit, useful_loss);
    salt_ = now.salt;
    try_is_over_ = false;
    try_ends_at_ = result_.statistics.expanded + now.patience;
    const bool swept = sweeps();
    const double loss =
        swept ? sweep(node_of(piece, parts), now.limit) : search(piece, parts, allowed, now.limit);
    if (swept && !sweeps_) continue;  // a piece has too many cuts to keep: one by one again
    if (try_is_over_ && result_.stop == Stop::None && !run_is_over_) {
      now.patience *= 2;
      ++now.salt;
      continue;
    }
    if (result_.stop != Stop::None || run_is_over_) {
      report(loss);
      return loss;
    }
    if (loss <= now.limit || loss == kInfinity || loss > useful_loss) return loss;
    report(loss);
    const std::uint64_t before = now.expanded;
    now.expanded = result_.statistics.expanded;
    const std::uint64_t taken = now.expanded - before;
    if (taken <= before) {
      now.step *= 2;
    } else if (taken > 4 * before) {
      now.step /= 2;
    }
    now.limit = std::max(loss, now.limit + now.step) + slack(scale);
    if (sweeps() && useful_loss - now.limit < now.step) now.limit = useful_loss;
  }
}

/// The least loss of a piece where it is within `limit`; otherwise a lower bound on it, above
/// `limit`.
template <std::size_t kWords>
double AndOrSearch<kWords>::search(const Set& piece, std::size_t parts, std::size_t allowed,
                                   double limit) {
  if (parts == 1) return 0;
  if ((allowed & kMostAllowed) == 0) return kInfinity;
  if (limited_) allowed = useful(allowed, parts);
  if (stores_) return search_stored(node_of(piece, parts), limit);
  const auto [number, is_new] = memo_.insert(key(piece, allowed).data());
  if (is_new) {
    loss_.push_back(first_loss(number, parts, upper(piece, parts), kInfinity));
    exact_.push_back(0);
  }
  if (exact_[number] != 0 || loss_[number] > limit || must_stop()) return loss_[number];
  ++result_.statistics.expanded;
  if (result_.statistics.expanded % 256 == 0) poll();
  if (result_.statistics.expanded >= run_ends_at_) run_is_over_ = true;
  if (result_.statistics.expanded >= try_ends_at_) {
    try_is_over_ = true;
    return loss_[number];
  }

  const auto [best, next] = least_listed_loss(piece, parts, allowed, limit);
  return settled_loss(number, limit, best, next);
}

/// Lists the cuts of a piece and follows them: as least_loss().
template <std::size_t kWords>
std::pair<double, double> AndOrSearch<kWords>::least_listed_loss(const Set& piece,
                                                                 std::size_t parts,
                                                                 std::size_t allowed,
                                                                 double limit) {
  const std::size_t begin = cuts_.size();
  const double skipped = list_cuts(piece, parts, allowed, limit);
  sort_cuts(begin);
  const auto found = least_loss(piece, parts, allowed, limit, begin, skipped);
  cuts_.resize(begin);
  return found;
}

/// What is known of the loss of a piece of memo_ after its cuts were followed within `limit`, with
/// what least_loss() says; remembers it.
template <std::size_t kWords>
double AndOrSearch<kWords>::settled_loss(std::uint32_t number, double limit, double best,
                                         double next) {
  if (must_stop()) return loss_[number];
  if (best < kInfinity) {
    loss_[number] = best;
    exact_[number] = 1;
  } else {
    // The loss is above the limit, also where rounding has put the sum onto the limit.
    loss_[number] = std::max({loss_[number], next, std::nextafter(limit, kInfinity)});
    if (next == kInfinity) exact_[number] = 1;
  }
  return loss_[number];
}

/// Sorts the cuts from place `begin` on by their estimates. Sums of the same numbers in another
/// order are equal, not a preference.
template <std::size_t kWords>
void AndOrSearch<kWords>::sort_cuts(std::size_t begin) {
  std::sort(cuts_.begin() + static_cast<std::ptrdiff_t>(begin), cuts_.end(),
            [tie = slack(scale_)](const Cut& a, const Cut& b) {
              const double left = std::floor(a.estimate / tie + 0.5);
              const double right = std::floor(b.estimate / tie + 0.5);
              return left != right ? left < right : a.order < b.order;
            });
}

/// Follows the cuts of a piece from place `begin` on. Returns the least loss with a cut that was
/// solved within `limit` (infinite if there is none), and a lower bound on the losses with all
/// others, of which those that were not even listed lose at least `skipped`.
template <std::size_t kWords>
std::pair<double, double> AndOrSearch<kWords>::least_loss(const Set& piece, std::size_t parts,
                                                          std::size_t allowed, double limit,
                                                          std::size_t begin, double skipped) {
  double best = kInfinity;
  double next = skipped;
  const std::size_t end = cuts_.size();
  const double tie = slack(scale_);
  for (std::size_t i = begin; i < end && !must_stop(); ++i) {
    const Cut cut = cuts_[i];
    const double most = std::min(limit, best - tie);
    if (cut.estimate > most) {
      next = std::min(next, cut.estimate);
      continue;
    }
    const auto [total, solved] = loss_with(cut, forms_of(halves(piece, parts, allowed, cut)), most);
    if (must_stop()) break;
    if (solved) {
      best = total;
    } else {
      next = std::min(next, total);
    }
  }
  return {best, next};
}

/// The loss of a piece with a cut, and whether it is exact; if not, it is a lower bound. A loss of
/// a side above the limit that it was asked for is a lower bound only, however the sums are
/// rounded.
template <std::size_t kWords>
std::pair<double, bool> AndOrSearch<kWords>::loss_with(const Cut& cut,
                                                       const std::array<Half, 2>& halves,
                                                       double limit) {
  // The smaller side comes first: it is solved sooner.
  const bool side_first = halves[0].parts <= halves[1].parts;
  const Half& one = halves[side_first ? 0 : 1];
  const Half& other = halves[side_first ? 1 : 0];
  double other_loss = known_loss(other.set, other.parts, other.allowed);
  const double one_limit = limit - cut.own_loss - other_loss;
  const double one_loss = search(one.set, one.parts, one.allowed, one_limit);
  bool solved = one_loss <= one_limit;
  ++result_.statistics.generated;
  if (solved) {
    const double other_limit = limit - cut.own_loss - one_loss;
    other_loss = search(other.set, other.parts, other.allowed, other_limit);
    solved = other_loss <= other_limit;
  }
  return {cut.own_loss + one_loss + other_loss, solved};
}

template <std::size_t kWords>
void AndOrSearch<kWords>::poll() {
  result_.stop = bytes() > allowed_bytes_ ? Stop::MemoryLimit
                                          : budget_.expired(bytes(), result_.statistics.expanded);
  budget_.report({.phase = "search", .done = result_.statistics.expanded, .states = memo_.size()});
}

template class AndOrSearch<1>;
template class AndOrSearch<2>;
template class AndOrSearch<4>;
template class AndOrSearch<8>;
template class AndOrSearch<16>;

}  // namespace orasp::detail
