#include "orasp/planners/and_or.h"

#include <algorithm>
#include <cmath>
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
  AndOrRounds(const detail::PieceProblem& pieces, const AndOrOptions& options, const Budget& budget)
      : pieces_(pieces), options_(options), budget_(budget), search_(pieces, 0, budget, all_cuts_) {
    best_.method = "and-or";
  }

  Result run() {
    // The first round takes some tenths of a second at any size.
    const std::uint64_t parts = std::max<std::uint64_t>(pieces_.system.problem().num_parts(), 1);
    const std::uint64_t first_expansions =
        std::clamp<std::uint64_t>(2'500'000 / parts, 2'000, 20'000);
    const std::uint64_t first_looks = std::max<std::uint64_t>(12'800'000 / (parts * kWords), 500);
    constexpr std::size_t kFirstWidth = 4;
    for (std::uint64_t round = options_.first_round;; ++round) {
      const std::uint64_t longer = std::uint64_t{1} << std::min<std::uint64_t>(round, 40);
      const bool done = search_.run(first_expansions * longer, first_looks * longer);
      most_ = all_cuts_.bound.value_or(kInfinity);
      if (done && most_ == -kInfinity) return detail::exhausted("and-or", all_cuts_.statistics);
      if (done) take_plan(search_, false, all_cuts_);
      if (all_cuts_.has_plan() && all_cuts_.reward > best_.reward) keep_plan(all_cuts_);
      if (!proved() && !done && all_cuts_.stop == Stop::None && peeling_pays_)
        peel(kFirstWidth * longer);
      Stop stop = all_cuts_.stop;
      if (!proved() && !done && stop == Stop::None && !pieces_.graph.is_forest())
        stop = search_forests(round, longer);
      if (!done && !proved() && stop == Stop::None) {
        const bool last = round - options_.first_round + 1 >= options_.rounds;
        if (!last) continue;
        stop = Stop::ExpansionLimit;
      }
      return concluded(stop);
    }
  }

 private:
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
    best_.sequence = result.sequence;
    best_.reward = result.reward;
  }

  /// Peels as long as that gives plans that are at least as good as those of the forests.
  void peel(std::size_t width) {
    search_.peel(width);
    Result peeled;
    if (all_cuts_.stop == Stop::None) take_plan(search_, false, peeled);
    peeling_pays_ = peeled.has_plan() && peeled.reward >= best_.reward;
    if (peeling_pays_) keep_plan(peeled);
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

  Result concluded(Stop stop) {
    add_effort(best_.statistics, all_cuts_.statistics);
    if (std::isfinite(most_)) best_.bound = most_;
    if (!best_.sequence.empty() || pieces_.system.num_connections() == 0)
      best_.status = Status::Feasible;
    if (proved()) {
      best_.status = Status::Optimal;
      best_.bound = best_.reward;
    } else {
      best_.stop = stop;
    }
    return std::move(best_);
  }

  const detail::PieceProblem& pieces_;
  const AndOrOptions& options_;
  const Budget& budget_;
  /// What the search over all cuts gives.
  Result all_cuts_;
  detail::AndOrSearch<kWords> search_;
  /// The best plan of all searches.
  Result best_;
  /// The bound that the search over all cuts has proved.
  double most_ = kInfinity;
  bool peeling_pays_ = true;
};

template <std::size_t kWords>
Result run_rounds(const TransitionSystem& system, const AndOrOptions& options,
                  const Budget& budget) {
  const detail::PieceProblem pieces(system);
  if (!pieces.gains.known()) return {};
  return AndOrRounds<kWords>(pieces, options, budget).run();
}

}  // namespace

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
  if (system.wide()) return detail::part_trees(system, budget);
  const std::size_t words = (system.problem().num_parts() + 63) / 64;
  Result result;
  try {
    result = words <= 1   ? run_rounds<1>(system, options, budget)
             : words <= 2 ? run_rounds<2>(system, options, budget)
             : words <= 4 ? run_rounds<4>(system, options, budget)
             : words <= 8 ? run_rounds<8>(system, options, budget)
                          : run_rounds<16>(system, options, budget);
  } catch (const InputError&) {
    // A formula without a value for a cut that no plan may ever make: what follows meets it if one
    // does.
  }
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
