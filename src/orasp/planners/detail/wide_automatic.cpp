#include <algorithm>
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

}  // namespace

Result wide_automatic(const TransitionSystem& system, const Budget& budget) {
  if (auto result = infeasible_at_once(system, "auto")) return *result;
  const Stopwatch watch;
  const auto answer = [&](Result result, const std::string& how) {
    result.method = "auto";
    result.notes.insert(result.notes.begin(), "auto: " + how);
    result.statistics.seconds = watch.seconds();
    return result;
  };
  double most = kInfinity;
  // Piece by piece, for so much of the time, and no more than so many pieces.
  const auto by_pieces = [&](std::uint64_t pieces, int share) {
    Budget look = budget;
    look.max_expansions = std::min(budget.max_expansions, pieces);
    const auto now = Budget::Clock::now();
    if (budget.deadline) look.deadline = now + (*budget.deadline - now) / share;
    return part_trees(system, look);
  };
  const std::string why_pieces = "and-or, since the objective sees the piece only";
  const bool many = has_many_moves(system);
  const std::uint64_t pieces = pieces_worth_a_look(system, many);
  Result turned;
  if (turns_round(system)) {
    constexpr std::uint64_t kFewPieces = 2'000;
    if (pieces > 0) {
      Result found = by_pieces(std::min(pieces, kFewPieces), 4);
      if (found.status == Status::Optimal || found.status == Status::Infeasible)
        return answer(std::move(found), why_pieces);
    }
    turned = plan_from_the_end(system, many, budget);
  }
  const auto better_of = [&turned](Result plan) {
    if (!turned.has_plan() || plan.reward >= turned.reward) return plan;
    take_plan(turned, plan);
    plan.status = Status::Feasible;
    return plan;
  };
  const bool bounded = WideBound(system).known();
  if (many) {
    Result result = better_of(by_few_moves(system, bounded, budget));
    if (result.has_plan()) {
      judge_by(result.bound, result);
      return answer(std::move(result),
                    "beam over steps that move few parts, since there are too many others");
    }
  }
  // A plan that meets the bound ends it at once.
  const bool large = !many && system.rules().by_part && system.problem().num_parts() > kManyParts;
  Result plan = large ? plan_of_few_moves(system, budget) : Result();
  if (!plan.has_plan()) {
    Budget look = budget;
    look.max_expansions = std::min(budget.max_expansions, expansions_at_first(system, 3e9));
    plan = wide_guided_greedy(system, look);
  }
  if (plan.status != Status::Infeasible) plan = better_of(std::move(plan));
  if (plan.status == Status::Infeasible)
    return answer(std::move(plan), "all orders were looked at");
  if (bounded && plan.has_plan() && meets(plan.reward, WideBound(system)(system.start_state()))) {
    judge_by(plan.reward, plan);
    return answer(std::move(plan), "the plan earns as much as the bound allows");
  }
  const auto add = [&](Result found) {
    if (found.bound) most = std::min(most, *found.bound);
    if (found.has_plan() && found.reward > plan.reward) plan = std::move(found);
  };
  // Best first, as long as that is quick.
  if (bounded) {
    Budget look = budget;
    constexpr std::uint64_t kFewest = 500;
    const std::uint64_t few = pieces > 0 ? kFewest : expansions_at_first(system, 3e8);
    look.max_expansions = std::min(budget.max_expansions, few);
    Result found = wide_a_star(system, look);
    if (found.status == Status::Optimal || found.status == Status::Infeasible)
      return answer(std::move(found), "a-star, since few states promise enough");
    add(std::move(found));
  }
  if (pieces > 0) {
    Result found = by_pieces(pieces, 2);
    if (found.status == Status::Optimal || found.status == Status::Infeasible)
      return answer(std::move(found), why_pieces);
    add(std::move(found));
    if (plan.has_plan() && meets(plan.reward, most)) {
      judge_by(most, plan);
      return answer(std::move(plan), "the plan earns as much as and-or allows");
    }
  }
  const GraphEstimate estimate = estimate_graph(system, budget);
  const bool fits = estimate.exact && estimate.bytes <= static_cast<double>(allowed_bytes(budget));
  const bool builds = fits || !bounded;
  Result result = builds ? value_iteration(system, {}, budget) : wide_beam(system, &plan, budget);
  if (result.status == Status::Feasible || result.status == Status::Unknown) {
    // It was stopped: what was found before may be better.
    if (plan.has_plan() && plan.reward > result.reward) {
      take_plan(plan, result);
      result.notes.clear();
    }
    most = std::min(most, result.bound.value_or(kInfinity));
    if (result.reward > -kInfinity)
      judge_by(most < kInfinity ? std::optional(most) : std::nullopt, result);
  }
  return answer(std::move(result),
                !builds ? "beam, since the state-action graph is too large to build"
                : fits  ? "value-iteration, since the state-action graph is small"
                        : "value-iteration, since no bound is known for the objective");
}

}  // namespace orasp::detail
