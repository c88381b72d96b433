#include "orasp/planners/automatic.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "orasp/bounds/companion_bound.h"
#include "orasp/bounds/connection_bound.h"
#include "orasp/bounds/piece_bound.h"
#include "orasp/graph/graph_estimate.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/and_or.h"
#include "orasp/planners/beam.h"
#include "orasp/planners/dense_value_iteration.h"
#include "orasp/planners/detail/companion_plan.h"
#include "orasp/planners/detail/peeled_plan.h"
#include "orasp/planners/detail/quick_plan.h"
#include "orasp/planners/detail/wide_search.h"
#include "orasp/planners/greedy.h"
#include "orasp/planners/orasp_search.h"
#include "orasp/planners/planner_support.h"
#include "orasp/planners/value_iteration.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {

/// Expansions for a look at whether a plan meets the bound; a few milliseconds.
constexpr std::uint64_t kFirstLook = 5000;
/// Expansions to find any plan where greedy meets dead ends.
constexpr std::uint64_t kLookForAny = 20'000;
/// Expansions of the first turn of beam; each turn is longer than the one before.
constexpr std::uint64_t kFirstTurn = 5'000;

/// Whether H is small enough to build, looked at as cheaply as possible.
bool worth_building(const TransitionSystem& system, const Budget& budget) {
  const auto allowed = static_cast<double>(allowed_bytes(budget));
  const GraphEstimate most = estimate_without_constraints(system);
  if (most.actions <= kAutomaticMostActions && most.bytes <= allowed) return true;
  const GraphEstimate estimate = estimate_graph(system, budget, kAutomaticMostActions);
  return estimate.actions <= kAutomaticMostActions && estimate.bytes <= allowed;
}

/// After so many turns all subsets of the connections are gone through, where there is memory and
/// time for that.
constexpr std::uint64_t kTurnsBeforeDense = 3;

/// After so many turns larger pieces are listed for the bound, unless the search of pieces lowers
/// it.
constexpr std::uint64_t kTurnsBeforeMany = 1;

double seconds_left(const Budget& budget) {
  return std::chrono::duration<double>(*budget.deadline - Budget::Clock::now()).count();
}

/// Whether the bound gains by larger pieces (SmallPieces), whose listing takes some seconds and
/// some hundred MiB.
bool more_is_worth_listing(const PieceBound& pieces, const Budget& budget) {
  constexpr double kSecondsForMany = 8;
  constexpr std::uint64_t kBytesForMany = std::uint64_t{1} << 30U;
  if (!pieces.known() || !pieces.gains()->prices().more_could_be_listed()) return false;
  if (allowed_bytes(budget) < kBytesForMany) return false;
  return !budget.deadline || seconds_left(budget) >= kSecondsForMany;
}

/// Small pieces, as many, until the budget is spent.
ListingEffort effort_for(std::size_t most_sets, const Budget& budget) {
  return {.most_sets = most_sets, .stop = [&budget] { return budget.expired() != Stop::None; }};
}

/// How many small pieces are listed before anything else.
std::size_t listed_at_first(const Budget& budget) {
  constexpr double kEnoughTime = 1;  // seconds
  constexpr std::uint64_t kEnoughBytes = std::uint64_t{512} << 20U;
  const bool enough = (!budget.deadline || seconds_left(budget) > kEnoughTime) &&
                      allowed_bytes(budget) >= kEnoughBytes;
  return enough ? SmallPieces::kMostSets : SmallPieces::kFewSets;
}

/// About how long dense value iteration takes, on the safe side (docs/performance.md: 14 to 28 ns
/// an action).
double dense_seconds(const TransitionSystem& system, const Budget& budget) {
  constexpr double kSecondsPerAction = 4e-8;
  const auto connections = static_cast<double>(system.num_connections());
  return connections * std::exp2(connections - 1) * kSecondsPerAction /
         std::max(1U, budget.threads);
}

/// What is known so far: the best plan and the least bound of all methods, and what they did.
class Findings {
 public:
  Findings() {
    best_.method = "auto";
    best_.bound = kInfinity;
  }

  void lower(double bound) { best_.bound = std::min(*best_.bound, bound); }

  /// @returns whether `result` taught anything new.
  bool add(const Result& result) {
    Statistics& sum = best_.statistics;
    const Statistics& part = result.statistics;
    sum.states = std::max(sum.states, part.states);
    sum.actions = std::max(sum.actions, part.actions);
    sum.expanded += part.expanded;
    sum.generated += part.generated;
    sum.reopened += part.reopened;
    sum.pruned += part.pruned;
    sum.sweeps += part.sweeps;
    sum.peak_bytes = std::max(sum.peak_bytes, part.peak_bytes);
    const double bound_before = *best_.bound;
    if (result.bound) lower(*result.bound);
    if (result.status == Status::Infeasible) infeasible_ = true;
    const bool better = result.has_plan() && (!best_.has_plan() || result.reward > best_.reward);
    if (better) {
      best_.status = Status::Feasible;
      best_.sequence = result.sequence;
      best_.reward = result.reward;
    }
    return better || *best_.bound < bound_before;
  }

  [[nodiscard]] const Result& best() const { return best_; }
  /// How far the bound is above the best plan; infinite where one of them is not known.
  [[nodiscard]] double gap() const {
    return best_.has_plan() ? *best_.bound - best_.reward : kInfinity;
  }
  [[nodiscard]] bool settled() const {
    return infeasible_ || (best_.has_plan() && detail::meets(best_.reward, *best_.bound));
  }

  [[nodiscard]] Result answer(Stop stop, const std::string& how) const {
    Result result = best_;
    if (infeasible_) {
      result = detail::exhausted("auto", best_.statistics);
    } else if (settled()) {
      result.status = Status::Optimal;
      result.bound = result.reward;
    } else {
      result.stop = stop;
      if (!std::isfinite(*result.bound)) result.bound.reset();
    }
    result.notes.insert(result.notes.begin(), "auto: " + how);
    return result;
  }

 private:
  Result best_;
  bool infeasible_ = false;
};

/// The share of the gap that a turn has to close to be worth more of its kind.
constexpr double kWorthwhile = 0.05;

/// Whether a turn has narrowed the gap by so much that the next one may be four times as long, not
/// twice. So no method takes all the time where another one gets on.
bool worthwhile(double gap_before, double gap) {
  return !std::isfinite(gap) || gap_before - gap >= kWorthwhile * gap_before;
}

/// Looks piece by piece, in turns.
class PieceTurns {
 public:
  PieceTurns(const TransitionSystem& system, const Budget& budget,
             std::shared_ptr<const PieceGains> gains)
      : turns_(system, budget, std::move(gains)) {}

  /// What ended the turn if it was more than its length.
  Stop look(Findings& findings) {
    const double before = findings.gap();
    const double bound_before = *findings.best().bound;
    const Result result = turns_.next(rounds_, findings.best());
    findings.add(result);
    rounds_ = worthwhile(before, findings.gap()) ? 2 : 1;
    const double lowered = bound_before - *findings.best().bound;
    lowers_bound_ = std::isfinite(before) && lowered >= kWorthwhile * before;
    if (result.stop == Stop::None) ended_ = true;
    return result.stop == Stop::ExpansionLimit ? Stop::None : result.stop;
  }
  /// Whether the search of pieces has come to its end.
  [[nodiscard]] bool ended() const { return ended_; }
  /// Whether the last turn closed a good share of the gap from above. Whatever is begun anew with
  /// other prices has to do that again.
  [[nodiscard]] bool lowers_bound() const { return lowers_bound_ && !ended_; }

 private:
  AndOrTurns turns_;
  std::uint64_t rounds_ = 2;
  bool ended_ = false;
  bool lowers_bound_ = false;
};

/// `system` is `forwards`, or that backwards, where more is known about what is still to come.
Result chosen(const TransitionSystem& forwards, const TransitionSystem& system,
              const Budget& budget, const Result* known, const MakeAdvice* advice) {
  const ConnectionSet start = system.start();
  // A result of the system forwards, as one of `system`.
  const auto turned = [&](Result result) {
    if (&system != &forwards) std::ranges::reverse(result.sequence);
    return result;
  };
  Findings findings;
  if (known != nullptr) findings.add(turned(*known));
  Budget first = budget;
  first.max_expansions = std::min(budget.max_expansions, kFirstLook + 4 * system.num_connections());

  // A plan that meets the bound, at any size.
  if (system.num_connections() > detail::kManyConnections) findings.add(detail::quick_plan(system));
  auto pieces = std::make_unique<PieceBound>(
      system, PieceBound::Kind::Both,
      std::make_shared<const PieceGains>(system, effort_for(listed_at_first(budget), budget)));
  if (pieces->known()) {
    findings.lower((*pieces)(start.view()));
    if (!findings.settled() && system.num_connections() > detail::kManyConnections)
      findings.add(detail::peeled_plan(system, *pieces, first));
    if (!findings.settled()) findings.add(plan_at_bound(system, *pieces, first));
    if (!findings.settled()) {
      const CompanionBound companions(system);
      findings.lower(companions.most());
      if (!findings.settled()) findings.add(detail::companion_plan(system, companions, first));
    }
    if (findings.settled())
      return findings.answer(Stop::None,
                             "the plan earns as much as the bound on its pieces allows");
  }
  if (!findings.best().has_plan() && system.num_connections() > detail::kManyConnections)
    findings.add(detail::peeled_plan(system));
  // Piece by piece, a short look; from a plan that can be made better, where one comes at once.
  const bool by_pieces = !and_or_obstacle(system);
  if (by_pieces && !findings.best().has_plan()) {
    Budget at_once = budget;
    at_once.max_expansions = std::min(budget.max_expansions, 2 * system.num_connections());
    findings.add(greedy(system, at_once));
  }
  bool pieces_ended = !by_pieces;
  std::optional<PieceTurns> turns;
  turns.emplace(system, budget, pieces->gains());
  const auto look_at_pieces = [&] {
    const Stop ended = turns->look(findings);
    if (turns->ended()) pieces_ended = true;
    return ended;
  };
  Stop stop = Stop::None;
  if (by_pieces) {
    stop = look_at_pieces();
    if (findings.settled() || stop != Stop::None)
      return findings.answer(stop, "and-or, since the objective sees the piece only");
  }
  // Everything, where that is not much.
  if (worth_building(forwards, budget)) {
    const Result result = turned(value_iteration(forwards, {}, budget));
    findings.add(result);
    return findings.answer(result.stop, "value-iteration, since the state-action graph is small");
  }
  if (!findings.best().has_plan()) findings.add(greedy(system, first));
  if (!findings.best().has_plan() && !system.ordered()) {
    Budget look = budget;
    look.max_expansions = std::min(budget.max_expansions, kLookForAny);
    findings.add(detail::any_plan(system, look));
    if (findings.settled()) return findings.answer(Stop::None, "all orders were looked at");
  }
  ConnectionBound connections(system);
  if (connections.known()) findings.lower(connections(start.view()));

  // In turn until the limit, each turn longer than the one before.
  std::string how =
      pieces->sees_connections() ? "orasp-search, beam and and-or in turn, since the state-action "
                                   "graph is too large to build"
      : by_pieces ? "and-or and beam in turn, since the state-action graph is too large to build"
                  : "beam, since the state-action graph is too large to build";
  bool may_be_dense = dense_values_safe(forwards) && dense_table_fits(forwards, budget);
  std::uint64_t turn_length = kFirstTurn;
  bool many_listed = false;
  for (std::uint64_t turn = 0; !findings.settled() && stop == Stop::None; ++turn) {
    if (turn >= kTurnsBeforeMany && !many_listed && !turns->lowers_bound() &&
        more_is_worth_listing(*pieces, budget)) {
      many_listed = true;
      pieces = std::make_unique<PieceBound>(
          system, PieceBound::Kind::Both,
          std::make_shared<const PieceGains>(system, effort_for(SmallPieces::kManySets, budget)));
      findings.lower((*pieces)(start.view()));
      if (findings.settled()) break;
      turns.emplace(system, budget, pieces->gains());
    }
    Budget some = budget;
    if (!pieces_ended) some.max_expansions = std::min(turn_length, budget.max_expansions);
    const double gap_before = findings.gap();
    if (pieces->sees_connections()) {
      // Pieces and layers tell states apart that promise the same here; a depth-first search sees
      // by the bound that most of them cannot be better.
      const Result deep =
          orasp_search(system, {.like = pieces.get(), .incumbent = &findings.best()}, some);
      findings.add(deep);
      if (deep.status == Status::Optimal) break;
      if (deep.stop != Stop::ExpansionLimit) stop = deep.stop;
      if (findings.settled() || stop != Stop::None) break;
    }
    const Result passes = beam(system,
                               {.like = pieces.get(),
                                .incumbent = &findings.best(),
                                .advice = advice,
                                .most = *findings.best().bound},
                               some);
    findings.add(passes);
    stop = passes.stop == Stop::ExpansionLimit && some.max_expansions < budget.max_expansions
               ? Stop::None
               : passes.stop;
    if (findings.settled() || stop != Stop::None) break;
    if (passes.status == Status::Optimal) break;
    turn_length *= worthwhile(gap_before, findings.gap()) ? 4 : 2;
    if (!pieces_ended) stop = look_at_pieces();
    if (turn < kTurnsBeforeDense || !may_be_dense || stop != Stop::None || findings.settled())
      continue;
    may_be_dense = false;
    if (budget.deadline && seconds_left(budget) < dense_seconds(forwards, budget)) continue;
    const Result dense = turned(dense_value_iteration(forwards, {}, budget));
    findings.add(dense);
    stop = dense.stop;
    how += ", then value iteration over all subsets of connections";
    if (dense.status == Status::Optimal) break;
  }
  return findings.answer(stop, how);
}

}  // namespace

Result automatic(const TransitionSystem& system, std::uint64_t seed, const Budget& budget,
                 const Result* known, const MakeAdvice* advice) {
  if (system.wide()) {
    Result result = detail::wide_automatic(system, budget);
    result.seed = seed;
    return result;
  }
  if (auto result = detail::infeasible_at_once(system, "auto")) return *result;
  Result result = detail::from_the_end(system, [&](const TransitionSystem& from) {
    return chosen(system, from, budget, known, advice);
  });
  if (result.status == Status::Unknown && result.stop != Stop::None) {
    // The limit was over before there was a plan: the bound may take longer than it allows.
    const Result quick =
        detail::stopped_with_quick_plan(system, "auto", result.stop, result.statistics);
    if (quick.has_plan()) {
      result.status = Status::Feasible;
      result.sequence = quick.sequence;
      result.reward = quick.reward;
      result.notes.insert(result.notes.end(), quick.notes.begin(), quick.notes.end());
    }
  }
  result.seed = seed;
  return result;
}

}  // namespace orasp
