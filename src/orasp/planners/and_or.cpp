#include "orasp/planners/and_or.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "orasp/containers/parallel.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/detail/and_or_search.h"
#include "orasp/planners/detail/part_trees.h"
#include "orasp/planners/greedy.h"
#include "orasp/planners/planner_support.h"

namespace orasp {

namespace {

void add_effort(Statistics& sum, const Statistics& part) {
  sum.states = std::max(sum.states, part.states);
  sum.expanded += part.expanded;
  sum.generated += part.generated;
  sum.peak_bytes = std::max(sum.peak_bytes, part.peak_bytes);
}

/// The rounds of and_or(): a look at all cuts, which often is enough; where they are too many,
/// plans that peel small sides off, and plans along random spanning forests; and so on in turn,
/// each round twice as long as the one before.
template <std::size_t kWords>
class AndOrRounds {
 public:
  AndOrRounds(const detail::PieceProblem& pieces, SymmetryUse symmetry, const Budget& budget)
      : pieces_(pieces),
        budget_(budget),
        search_(pieces, 0, budget, all_cuts_),
        recut_looks_(search_.recuts_quickly() ? kQuickRecutLooks : kRecutLooks),
        symmetry_use_(symmetry) {
    best_.method = "and-or";
  }

  /// The next `rounds` rounds.
  Result run(std::uint64_t rounds) {
    look_for_symmetry(round_ > 0);
    // The first round takes some tenths of a second at any size.
    const std::uint64_t parts = std::max<std::uint64_t>(pieces_.system.problem().num_parts(), 1);
    const std::uint64_t first_expansions =
        std::clamp<std::uint64_t>(2'500'000 / parts, 2'000, 20'000);
    const std::uint64_t first_looks = std::max<std::uint64_t>(12'800'000 / (parts * kWords), 500);
    constexpr std::size_t kFirstWidth = 4;
    for (const std::uint64_t last_round = round_ + rounds - 1;; ++round_) {
      const std::uint64_t round = round_;
      const std::uint64_t longer = std::uint64_t{1} << std::min<std::uint64_t>(round, 40);
      const bool done = search(first_expansions * longer, first_looks * longer);
      most_ = all_cuts_.bound.value_or(kInfinity);
      if (done && most_ == -kInfinity) return detail::exhausted("and-or", all_cuts_.statistics);
      if (done) take_plan(search_, false, all_cuts_);
      if (all_cuts_.has_plan() && all_cuts_.reward > best_.reward) keep_plan(all_cuts_);
      if (!done && all_cuts_.stop == Stop::None) dive();
      const bool all_kept = search_.keeps_all_cuts();
      const bool may_peel = parts <= kMostPeeledParts || !search_.knows_cores();
      if (!proved() && !done && all_cuts_.stop == Stop::None && peeling_pays_ && may_peel)
        peel(kFirstWidth * longer);
      Stop stop = all_cuts_.stop;
      if (!proved() && !done && stop == Stop::None && !all_kept && may_peel &&
          !pieces_.graph.is_forest())
        stop = search_forests(round, longer);
      if (!proved() && !done && stop == Stop::None && recuts_.empty()) recut(recut_looks_);
      if (!done && !proved() && stop == Stop::None) {
        look_for_symmetry(true);
        if (round < last_round) continue;
        ++round_;
        stop = Stop::ExpansionLimit;
      }
      return concluded(stop);
    }
  }

  /// A plan of another method: what loses more need not be looked at.
  void know_plan(const Result& plan) {
    if (plan.has_plan() && plan.reward > best_.reward) keep_plan(plan);
  }

 private:
  /// Where cores are known, larger problems are not peeled nor searched along forests: each cut
  /// takes a spanning tree to look at, and the search goes straight to a plan by itself.
  static constexpr std::uint64_t kMostPeeledParts = 128;
  /// Looks at cuts while a plan is made better, at first; a tenth of a second or two.
  static constexpr std::uint64_t kRecutLooks = 200'000;
  static constexpr std::uint64_t kQuickRecutLooks = 1'000'000;
  /// The same where the search waits meanwhile: a tenth of its time at most.
  static constexpr std::uint64_t kRecutLooksPerExpansion = 1;

  /// Looks for symmetry, once: where it was asked for at once, and by itself where the search is
  /// `is_long`.
  void look_for_symmetry(bool is_long) {
    const bool automatic = symmetry_use_ == SymmetryUse::Auto;
    if (symmetry_use_ == SymmetryUse::Off || (automatic && !is_long)) return;
    const std::optional<Symmetry> symmetry = symmetry_for(pieces_.system, symmetry_use_, "and-or");
    symmetry_use_ = SymmetryUse::Off;  // known once and for all
    if (!symmetry) return;
    const OrbitForm form = symmetry->form_of_parts();
    if (form.trivial() || (automatic && form.saving() < least_saving())) return;
    search_.use_symmetry(form);
    best_.notes.push_back(symmetry->text());
  }

  /// How much symmetry has to save where it is used by itself: the cuts of pieces cannot be kept
  /// with it.
  [[nodiscard]] double least_saving() const {
    return search_.keeps_cuts() ? kAndOrLeastSavingOfKept : kAndOrLeastSaving;
  }

  /// Whether the best plan earns all that the bound allows.
  [[nodiscard]] bool proved() const {
    return std::isfinite(best_.reward) && detail::meets(best_.reward, most_);
  }

  /// Writes the plan that a search has found to `result`, if it can be carried out.
  void take_plan(detail::AndOrSearch<kWords>& search, bool dive, Result& result) const {
    std::vector<ConnectionIndex> sequence = search.sequence(dive);
    if (sequence.size() != pieces_.system.num_connections()) return;
    result.reward = detail::reward_of(pieces_.system, sequence);
    result.sequence = std::move(sequence);
    result.status = Status::Feasible;
  }

  void keep_plan(const Result& result) {
    best_.status = Status::Feasible;
    best_.sequence = result.sequence;
    best_.reward = result.reward;
    search_.know_plan(best_.reward);
  }

  /// A plan by the cuts that promise most after what was proved so far.
  void dive() {
    if (!search_.keeps_cuts()) return;
    Result dived;
    take_plan(search_, true, dived);
    if (dived.has_plan() && dived.reward > best_.reward) keep_plan(dived);
  }

  /// Peels as long as that gives plans that are at least as good as those of the forests.
  void peel(std::size_t width) {
    search_.peel(width);
    Result peeled;
    if (all_cuts_.stop == Stop::None) take_plan(search_, false, peeled);
    peeling_pays_ = peeled.has_plan() && peeled.reward >= best_.reward;
    if (peeling_pays_) keep_plan(peeled);
  }

  /// The next part of the search over all cuts, and beside it, where there is a second thread, a
  /// look for what makes the best plan better. Neither sees what the other one finds, so that the
  /// answer is the same with one thread. A search that takes all threads itself goes second: it
  /// then need not look at what loses more than the better plan. @returns whether the search is
  /// done.
  bool search(std::uint64_t expansions, std::uint64_t looks) {
    const bool recuts = best_.has_plan();
    if (search_.sweeps()) {
      recut(kRecutLooksPerExpansion * expansions);
      return search_.run(expansions, looks);
    }
    if (!recuts || budget_.threads < 2) {
      const bool done = search_.run(expansions, looks);
      if (recuts && !done && all_cuts_.stop == Stop::None) {
        find_recut(recut_number(0), recut_looks_, draws_);
        take_recuts(1);
      }
      return done;
    }
    bool done = false;
    std::stop_source enough;
    Recut& beside = recut_number(0);
    beside.budget.stop = enough.get_token();
    const std::stop_callback stopped(budget_.stop, [&] { enough.request_stop(); });
    detail::run_parallel(2, [&](std::size_t thread) {
      if (thread == 1) {
        find_recut(beside, recut_looks_, draws_);
        return;
      }
      done = search_.run(expansions, looks);
      if (done) enough.request_stop();
    });
    beside.budget.stop = budget_.stop;
    if (!done) take_recuts(1);
    return done;
  }

  /// What makes plans better has a search of its own: it may work at the same time as others.
  struct Recut {
    Recut(const detail::PieceProblem& pieces, const Budget& the_budget)
        : budget(the_budget), search(pieces, 0, budget, spent) {
      budget.progress = nullptr;
    }
    Budget budget;
    Result spent;
    detail::AndOrSearch<kWords> search;
    bool better = false;
  };
  Recut& recut_number(std::size_t number) {
    while (recuts_.size() <= number) recuts_.push_back(std::make_unique<Recut>(pieces_, budget_));
    return *recuts_[number];
  }

  /// Cuts the best plan anew, window by window, in two ways at the same time, with so many looks
  /// each.
  void recut(std::uint64_t looks) {
    if (!best_.has_plan()) return;
    constexpr std::size_t kWays = 2;
    static_cast<void>(recut_number(kWays - 1));
    const std::size_t threads = std::min<std::size_t>(std::max(1U, budget_.threads), kWays);
    detail::run_parallel(threads, [&](std::size_t thread) {
      for (std::size_t i = thread; i < kWays; i += threads)
        find_recut(*recuts_[i], looks, draws_ + i);
    });
    take_recuts(kWays);
  }

  /// Finds whether the best plan can be cut anew to be better; another `draw` looks elsewhere. A
  /// formula without a value for some cut ends the look: no plan need ever make that cut.
  void find_recut(Recut& recut, std::uint64_t looks, std::uint64_t draw) const {
    try {
      recut.better = recut.search.recut(best_.sequence, looks, draw);
    } catch (const InputError&) {
      recut.better = false;
    }
  }

  /// Follows the first `ways` of what was cut anew where that is better. The next look is longer,
  /// as all of a round is.
  void take_recuts(std::size_t ways) {
    for (std::size_t i = 0; i < ways; ++i) {
      Result found;
      if (recuts_[i]->better) take_plan(recuts_[i]->search, false, found);
      if (found.has_plan() && found.reward > best_.reward) keep_plan(found);
    }
    draws_ += ways;
    recut_looks_ = std::min(2 * recut_looks_, std::numeric_limits<std::uint64_t>::max() / 4);
  }

  /// Searches random spanning forests, in parallel; their number does not depend on the number of
  /// threads. Returns what stopped one of them, if anything did.
  Stop search_forests(std::uint64_t round, std::uint64_t longer) {
    constexpr std::uint64_t kForestsInRound = 8;
    constexpr std::uint64_t kForestExpansions = 2'000;
    std::vector<Result> results(kForestsInRound);
    const std::size_t threads =
        std::min<std::size_t>(std::max(1U, budget_.threads), kForestsInRound);
    detail::run_parallel(threads, [&](std::size_t t) {
      Budget quiet = budget_;
      quiet.progress = nullptr;
      for (std::size_t i = t; i < kForestsInRound; i += threads) {
        detail::AndOrSearch<kWords> along(pieces_, round * kForestsInRound + i + 1, quiet,
                                          results[i]);
        const std::uint64_t expansions = kForestExpansions * longer;
        static_cast<void>(along.run(expansions, expansions));
        if (results[i].stop == Stop::None) take_plan(along, true, results[i]);
      }
    });
    Stop stop = Stop::None;
    for (const Result& result : results) {
      add_effort(best_.statistics, result.statistics);
      if (stop == Stop::None) stop = result.stop;
      if (!result.has_plan() || result.reward <= best_.reward) continue;
      peeling_pays_ = false;
      keep_plan(result);
    }
    return stop;
  }

  [[nodiscard]] Result concluded(Stop stop) const {
    Result result = best_;
    add_effort(result.statistics, all_cuts_.statistics);
    if (std::isfinite(most_)) result.bound = most_;
    if (!result.sequence.empty() || pieces_.system.num_connections() == 0)
      result.status = Status::Feasible;
    if (proved()) {
      result.status = Status::Optimal;
      result.bound = result.reward;
    } else {
      result.stop = stop;
    }
    return result;
  }

  const detail::PieceProblem& pieces_;
  const Budget& budget_;
  /// What the search over all cuts gives.
  Result all_cuts_;
  detail::AndOrSearch<kWords> search_;
  std::vector<std::unique_ptr<Recut>> recuts_;
  std::uint64_t recut_looks_;
  std::uint64_t draws_ = 0;  ///< of plans that were cut anew
  /// The best plan of all searches.
  Result best_;
  /// The bound that the search over all cuts has proved.
  double most_ = kInfinity;
  bool peeling_pays_ = true;
  std::uint64_t round_ = 0;
  /// What is still to be done about symmetry.
  SymmetryUse symmetry_use_;
};

}  // namespace

namespace detail {

/// AndOrRounds whatever the number of words.
class AnyRounds {
 public:
  AnyRounds() = default;
  AnyRounds(const AnyRounds&) = delete;
  AnyRounds& operator=(const AnyRounds&) = delete;
  virtual ~AnyRounds() = default;
  [[nodiscard]] virtual Result next(std::uint64_t rounds, const Result& known) = 0;
};

}  // namespace detail

namespace {

template <std::size_t kWords>
class RoundsOfWords final : public detail::AnyRounds {
 public:
  RoundsOfWords(const detail::PieceProblem& pieces, SymmetryUse symmetry, const Budget& budget)
      : rounds_(pieces, symmetry, budget) {}
  [[nodiscard]] Result next(std::uint64_t rounds, const Result& known) override {
    rounds_.know_plan(known);
    return rounds_.run(rounds);
  }

 private:
  AndOrRounds<kWords> rounds_;
};

std::unique_ptr<detail::AnyRounds> make_rounds(const detail::PieceProblem& pieces,
                                               SymmetryUse symmetry, const Budget& budget) {
  const std::size_t words = (pieces.system.problem().num_parts() + 63) / 64;
  if (words <= 1) return std::make_unique<RoundsOfWords<1>>(pieces, symmetry, budget);
  if (words <= 2) return std::make_unique<RoundsOfWords<2>>(pieces, symmetry, budget);
  if (words <= 4) return std::make_unique<RoundsOfWords<4>>(pieces, symmetry, budget);
  if (words <= 8) return std::make_unique<RoundsOfWords<8>>(pieces, symmetry, budget);
  return std::make_unique<RoundsOfWords<16>>(pieces, symmetry, budget);
}

}  // namespace

struct AndOrTurns::Work {
  Work(const TransitionSystem& system, const Budget& budget,
       std::shared_ptr<const PieceGains> gains, SymmetryUse symmetry)
      : pieces(system, std::move(gains)),
        rounds(pieces.gains.known() ? make_rounds(pieces, symmetry, budget) : nullptr) {}
  detail::PieceProblem pieces;
  std::unique_ptr<detail::AnyRounds> rounds;
  Statistics told;
};

AndOrTurns::AndOrTurns(const TransitionSystem& system, const Budget& budget,
                       std::shared_ptr<const PieceGains> gains, SymmetryUse symmetry)
    : system_(system), budget_(budget), gains_(std::move(gains)), symmetry_(symmetry) {}
AndOrTurns::~AndOrTurns() = default;

Result AndOrTurns::next(std::uint64_t rounds, const Result& known) {
  Result result;
  try {
    if (!work_) work_ = std::make_unique<Work>(system_, budget_, gains_, symmetry_);
    if (!work_->rounds) return {};
    result = work_->rounds->next(rounds, known);
  } catch (const InputError&) {
    // A formula without a value for a cut that no plan may ever make: what follows meets it if one
    // does.
    return {};
  }
  Statistics& sum = result.statistics;
  Statistics& told = work_->told;
  const Statistics now = sum;
  sum.expanded -= told.expanded;
  sum.generated -= told.generated;
  told = now;
  return result;
}

std::optional<std::string> and_or_obstacle(const TransitionSystem& system) {
  const bool plain = !system.wide() || detail::takes_part_trees(system);
  if (system.whole() && plain && system.sees_piece_only() &&
      system.problem().num_parts() <= kAndOrMostParts)
    return std::nullopt;
  return "takes whole problems of at most " + std::to_string(kAndOrMostParts) +
         " parts, whose objective sees nothing but the piece that is cut or put together";
}

namespace {

Result searched(const TransitionSystem& system, const AndOrOptions& options, const Budget& budget) {
  if (auto result = detail::infeasible_at_once(system, "and-or")) return *result;
  if (system.num_connections() == 0) {
    Result empty = greedy(system, budget);
    empty.method = "and-or";
    return empty;
  }
  if (const auto reason = and_or_obstacle(system)) throw Refusal("and-or", *reason);
  if (const auto reason = symmetry_obstacle(system, options.symmetry))
    throw Refusal("and-or", *reason);
  if (system.wide()) return detail::part_trees(system, budget);
  AndOrTurns turns(system, budget, nullptr, options.symmetry);
  Result result = turns.next(options.rounds, {});
  if (!result.has_plan() && result.status != Status::Infeasible) {
    // The cut tree could not be carried out, or there was no time for one.
    Result other =
        result.stop == Stop::None
            ? greedy(system, budget)
            : detail::stopped_with_quick_plan(system, "and-or", result.stop, result.statistics);
    other.method = "and-or";
    if (other.status == Status::Infeasible || !result.bound) return other;
    other.bound = result.bound;
    if (other.has_plan() && other.reward >= *other.bound - kRewardTolerance) {
      other.status = Status::Optimal;
      other.bound = other.reward;
      other.stop = Stop::None;
    }
    result = std::move(other);
  }
  return result;
}

}  // namespace

Result and_or(const TransitionSystem& system, const AndOrOptions& options, const Budget& budget) {
  return detail::from_the_end(
      system, [&](const TransitionSystem& from) { return searched(from, options, budget); });
}

}  // namespace orasp
