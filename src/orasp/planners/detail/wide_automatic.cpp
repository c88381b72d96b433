#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "orasp/bounds/wide_bound.h"
#include "orasp/graph/graph_estimate.h"
#include "orasp/planners/and_or.h"
#include "orasp/planners/detail/part_trees.h"
#include "orasp/planners/detail/wide_search.h"
#include "orasp/planners/detail/wide_support.h"
#include "orasp/planners/planner_support.h"
#include "orasp/planners/value_iteration.h"
#include "orasp/task/memory_limit.h"

// What auto does.

namespace orasp::detail {

namespace {

/// With more parts than this, a plan of steps that move few parts comes first.
constexpr std::size_t kManyParts = 30;

/// How many states may be expanded before something else is tried, at the cost of about `work`
/// numbers: an expansion bounds up to n states, each by up to n^2 of them.
std::uint64_t expansions_at_first(const TransitionSystem& system, double work) {
  const auto n = static_cast<double>(system.num_steps());
  return static_cast<std::uint64_t>(std::clamp(work / (n * n * n + 1), 200.0, 20'000.0));
}

/// A plan of steps that move few parts, improved by a beam over these; what bounds it holds for all
/// steps. No plan: none was found soon.
Result by_few_moves(const TransitionSystem& system, bool bounded, const Budget& budget) {
  Result best = plan_of_few_moves(system, budget);
  if (!best.has_plan()) return best;
  best.status = Status::Feasible;
  if (!bounded) return best;
  const double most = WideBound(system)(system.start_state());
  Budget look = budget;
  look.max_expansions = std::min(budget.max_expansions, expansions_at_first(system, 3e9));
  for (const std::size_t parts : {1, 2}) {
    if (meets(best.reward, most) || budget.expired() != Stop::None) break;
    const ListingScope few(system, {.most = parts});
    Result found = wide_beam(system, &best, look);
    if (found.has_plan() && found.reward > best.reward) best = std::move(found);
  }
  best.status = Status::Feasible;
  best.stop = budget.expired();
  best.bound = std::max(most, best.reward);
  judge_by(best.bound, best);
  return best;
}

/// A plan of an assembly that is found from its end, where more is known about what is still to
/// come. That there is none, or how good it is, is not said: where steps take parts off, what they
/// earn may depend on the way in which they are walked.
/// `many`: has_many_moves(system), so that little is to be hoped for from the beginning.
Result plan_from_the_end(const TransitionSystem& system, bool many, const Budget& budget) {
  Budget part = budget;
  const auto now = Budget::Clock::now();
  if (budget.deadline) part.deadline = now + (*budget.deadline - now) * (many ? 3 : 1) / 4;
  const TransitionSystem backwards = system.backwards();
  const bool bounded = WideBound(backwards).known();
  Result found = by_few_moves(backwards, bounded, part);
  if (bounded && !has_many_moves(backwards)) {
    if (!budget.deadline)
      part.max_expansions = std::min(part.max_expansions, expansions_at_first(system, 3e8));
    Result better = wide_beam(backwards, found.has_plan() ? &found : nullptr, part);
    if (better.has_plan()) found = std::move(better);
  }
  Result result = turned_round(system, std::move(found));
  if (result.has_plan()) result.status = Status::Feasible;
  result.bound.reset();
  return result;
}

/// How many pieces and-or may look at before something else is tried: none where steps do not take
/// parts off, or where a piece may have too many. `many`: has_many_moves(system).
std::uint64_t pieces_worth_a_look(const TransitionSystem& system, bool many) {
  if (!takes_part_trees(system) || and_or_obstacle(system)) return 0;
  const auto of_what_is_taken_apart = [](const TransitionSystem& from) {
    constexpr double kMostSteps = 2e8;
    const auto steps = static_cast<double>(Expander(from).legal_actions(from.start_state()).size());
    return static_cast<std::uint64_t>(std::clamp(kMostSteps / (steps + 1), 2'000.0, 200'000.0));
  };
  if (system.takes_apart()) return many ? 0 : of_what_is_taken_apart(system);
  const TransitionSystem backwards = system.backwards();
  return has_many_moves(backwards) ? 0 : of_what_is_taken_apart(backwards);
}

/// One run of auto: each look either answers, or leaves what it found to the next one.
class WideChoice {
 public:
  WideChoice(const TransitionSystem& system, const Budget& budget)
      : system_(system),
        budget_(budget),
        many_(has_many_moves(system)),
        pieces_(pieces_worth_a_look(system, many_)),
        bounded_(WideBound(system).known()) {}

  Result run() {
    std::optional<Result> found = turned_round_first();
    if (!found && many_) found = few_moves();
    if (!found) found = some_plan();
    if (!found && bounded_) found = best_first();
    if (!found && pieces_ > 0) found = half_by_pieces();
    if (!found) found = whole_graph_or_beam();
    found->method = "auto";
    found->statistics.seconds = watch_.seconds();
    return *std::move(found);
  }

 private:
  static Result answer(Result result, const std::string& how) {
    result.notes.insert(result.notes.begin(), "auto: " + how);
    return result;
  }
  static bool is_proof(const Result& result) {
    return result.status == Status::Optimal || result.status == Status::Infeasible;
  }
  static Result by_the_piece(Result result) {
    return answer(std::move(result), "and-or, since the objective sees the piece only");
  }

  /// Piece by piece, for so much of the time, and no more than so many pieces.
  Result by_pieces(std::uint64_t pieces, int share) {
    Budget look = budget_;
    look.max_expansions = std::min(budget_.max_expansions, pieces);
    const auto now = Budget::Clock::now();
    if (budget_.deadline) look.deadline = now + (*budget_.deadline - now) / share;
    return part_trees(system_, look);
  }
  [[nodiscard]] Result better_of(Result plan) const {
    if (!turned_.has_plan() || plan.reward >= turned_.reward) return plan;
    take_plan(turned_, plan);
    plan.status = Status::Feasible;
    return plan;
  }
  void add(Result found) {
    if (found.bound) most_ = std::min(most_, *found.bound);
    if (found.has_plan() && found.reward > plan_.reward) plan_ = std::move(found);
  }

  /// An assembly from its end.
  std::optional<Result> turned_round_first() {
    if (!turns_round(system_)) return std::nullopt;
    constexpr std::uint64_t kFewPieces = 2'000;
    if (pieces_ > 0) {
      Result found = by_pieces(std::min(pieces_, kFewPieces), 4);
      if (is_proof(found)) return by_the_piece(std::move(found));
    }
    turned_ = plan_from_the_end(system_, many_, budget_);
    return if_at_the_bound(turned_);
  }
  /// A plan that meets the bound ends it at once.
  std::optional<Result> if_at_the_bound(Result plan) {
    if (!bounded_ || !plan.has_plan() ||
        !meets(plan.reward, WideBound(system_)(system_.start_state())))
      return std::nullopt;
    judge_by(plan.reward, plan);
    return answer(std::move(plan), "the plan earns as much as the bound allows");
  }

  std::optional<Result> few_moves() {
    Result result = better_of(by_few_moves(system_, bounded_, budget_));
    if (!result.has_plan()) return std::nullopt;
    judge_by(result.bound, result);
    return answer(std::move(result),
                  "beam over steps that move few parts, since there are too many others");
  }

  std::optional<Result> some_plan() {
    const bool large =
        !many_ && system_.rules().by_part && system_.problem().num_parts() > kManyParts;
    plan_ = large ? plan_of_few_moves(system_, budget_) : Result();
    if (!plan_.has_plan()) {
      Budget look = budget_;
      look.max_expansions = std::min(budget_.max_expansions, expansions_at_first(system_, 3e9));
      plan_ = wide_guided_greedy(system_, look);
    }
    if (plan_.status == Status::Infeasible)
      return answer(std::move(plan_), "all orders were looked at");
    plan_ = better_of(std::move(plan_));
    return if_at_the_bound(plan_);
  }

  /// As long as that is quick.
  std::optional<Result> best_first() {
    Budget look = budget_;
    constexpr std::uint64_t kFewest = 500;
    const std::uint64_t few = pieces_ > 0 ? kFewest : expansions_at_first(system_, 3e8);
    look.max_expansions = std::min(budget_.max_expansions, few);
    Result found = wide_a_star(system_, look);
    if (is_proof(found)) return answer(std::move(found), "a-star, since few states promise enough");
    add(std::move(found));
    return std::nullopt;
  }

  std::optional<Result> half_by_pieces() {
    Result found = by_pieces(pieces_, 2);
    if (is_proof(found)) return by_the_piece(std::move(found));
    add(std::move(found));
    if (!plan_.has_plan() || !meets(plan_.reward, most_)) return std::nullopt;
    judge_by(most_, plan_);
    return answer(std::move(plan_), "the plan earns as much as and-or allows");
  }

  Result whole_graph_or_beam() {
    const GraphEstimate estimate = estimate_graph(system_, budget_);
    const bool fits =
        estimate.exact && estimate.bytes <= static_cast<double>(allowed_bytes(budget_));
    const bool builds = fits || !bounded_;
    Result result =
        builds ? value_iteration(system_, {}, budget_) : wide_beam(system_, &plan_, budget_);
    if (result.status == Status::Feasible || result.status == Status::Unknown) {
      // It was stopped: what was found before may be better.
      if (plan_.has_plan() && plan_.reward > result.reward) {
        take_plan(plan_, result);
        result.notes.clear();
      }
      most_ = std::min(most_, result.bound.value_or(kInfinity));
      if (result.reward > -kInfinity)
        judge_by(most_ < kInfinity ? std::optional(most_) : std::nullopt, result);
    }
    return answer(std::move(result),
                  !builds ? "beam, since the state-action graph is too large to build"
                  : fits  ? "value-iteration, since the state-action graph is small"
                          : "value-iteration, since no bound is known for the objective");
  }

  const TransitionSystem& system_;
  const Budget& budget_;
  Stopwatch watch_;
  bool many_;
  std::uint64_t pieces_;
  bool bounded_;
  Result turned_;  ///< a plan of an assembly from its end; or none
  Result plan_;    ///< the best one so far
  double most_ = kInfinity;
};

}  // namespace

Result wide_automatic(const TransitionSystem& system, const Budget& budget) {
  if (auto result = infeasible_at_once(system, "auto")) return *result;
  return WideChoice(system, budget).run();
}

}  // namespace orasp::detail
