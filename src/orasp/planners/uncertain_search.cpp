#include "orasp/planners/uncertain_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "orasp/bounds/connection_bound.h"
#include "orasp/bounds/piece_bound.h"
#include "orasp/bounds/piece_gains.h"
#include "orasp/containers/growing_array.h"
#include "orasp/containers/state_table.h"
#include "orasp/graph/detail/attempt_outcomes.h"
#include "orasp/graph/uncertain_graph.h"
#include "orasp/model/objectives/retried.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/planner_support.h"
#include "orasp/planners/uncertain_value_iteration.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {

/// D of the header: a bound on the problem without failures, and how far it may rise or fall.
struct CertainBound {
  std::unique_ptr<Bound> bound;
  /// By how much it rises at most when a connection comes off by itself: w, by connection.
  std::vector<double> rise;
  /// The least that it is in any state.
  double least = 0;
};

/// The bound by sizes, which depends on a state through what its connections and pieces have.
std::optional<CertainBound> bound_by_sizes(const TransitionSystem& certain) {
  const PieceGains gains(certain);
  if (!gains.known() || !gains.sizes_known() || gains.has_units() || certain.completes_first())
    return std::nullopt;
  CertainBound result;
  result.bound = std::make_unique<PieceBound>(certain, PieceBound::Kind::Sizes);
  const std::size_t parts = certain.problem().num_parts();
  double most_of_cut = 0;
  double least_a_part = 0;
  for (std::size_t n = 2; n <= parts; ++n) {
    for (std::size_t a = 1; 2 * a <= n; ++a)
      most_of_cut =
          std::max(most_of_cut, gains.by_size(a) + gains.by_size(n - a) - gains.by_size(n));
    least_a_part = std::min(least_a_part, gains.by_size(n) / static_cast<double>(n));
  }
  const double last = gains.surplus_of_last_pair();
  result.least = std::min(0.0, last) + least_a_part * static_cast<double>(parts);
  for (ConnectionIndex c = 0; c < certain.num_connections(); ++c) {
    const double own = gains.own(c);
    const double extra = gains.trees().cost(c);
    const double alone = parts < 2 ? 0 : std::max(0.0, extra - gains.by_size(2));
    result.rise.push_back(std::max({0.0, most_of_cut + extra - own, alone - own - last}));
    result.least += std::min(0.0, own) - extra;
  }
  return result;
}

std::optional<CertainBound> bound_by_connections(const TransitionSystem& certain) {
  auto bound = std::make_unique<ConnectionBound>(certain);
  if (!bound->known() || certain.completes_first()) return std::nullopt;
  CertainBound result;
  const double last = bound->last_surplus();
  result.least = std::min(0.0, last);
  for (ConnectionIndex c = 0; c < certain.num_connections(); ++c) {
    const double greatest = bound->greatest(c);
    result.rise.push_back(std::max({0.0, 0.0 - greatest, 0.0 - greatest - last}));
    result.least += std::min(0.0, greatest);
  }
  result.bound = std::move(bound);
  return result;
}

/// Of the two the one that promises less at the start.
std::optional<CertainBound> certain_bound(const TransitionSystem& certain) {
  auto sizes = bound_by_sizes(certain);
  auto connections = bound_by_connections(certain);
  if (!sizes) return connections;
  if (!connections) return sizes;
  const SetView start = certain.start().view();
  return (*sizes->bound)(start) <= (*connections->bound)(start) ? std::move(sizes)
                                                                : std::move(connections);
}

class UncertainSearch {
 public:
  UncertainSearch(const TransitionSystem& system, const TransitionSystem& certain,
                  CertainBound bound, const Budget& budget)
      : system_(system),
        problem_(system.problem()),
        outcomes_(problem_),
        certain_(std::move(bound)),
        budget_(budget),
        allowed_(allowed_bytes(budget)),
        expander_(system),
        certain_expander_(certain),
        states_(system.words()) {
    for (ConnectionIndex c = 0; c < system.num_connections(); ++c) {
      steps_cost_ = steps_cost_ && system.reward_range(c, system.num_steps(), false).greatest <= 0;
    }
    start_ = number_of(system.start().view());
  }

  Result run() {
    const Stopwatch watch;
    std::uint64_t next_look = 1;
    std::uint64_t trials = 0;
    evaluate_policy();
    ends_first_ = true;
    evaluate_policy();
    ends_first_ = false;
    while (!settled_[start_] && stop_ == Stop::None && !proved()) {
      trial();
      if (++trials < next_look) continue;
      next_look = trials * 2;
      evaluate_policy();
    }
    if (settled_[start_] && upper_[start_] > -kInfinity) evaluate_policy();
    Result result = best_;
    result.method = "auto";
    Statistics& statistics = result.statistics;
    statistics = {};
    statistics.states = states_.size();
    statistics.actions = attempts_.size();
    statistics.expanded = expanded_;
    statistics.generated = attempts_.size();
    statistics.sweeps = trials;
    statistics.peak_bytes = bytes();
    statistics.seconds = watch.seconds();
    if (settled_[start_] && upper_[start_] == -kInfinity) {
      result = detail::exhausted("auto", statistics);
      result.notes = {
          "no plan exists: whatever is attempted, a state may be met that has no legal step"};
      return result;
    }
    result.stop = stop_;
    const double bound = std::max(upper_[start_], result.has_plan() ? result.reward : -kInfinity);
    const std::optional<double> known = std::isfinite(bound) ? std::optional(bound) : std::nullopt;
    result.bound = known;  // not that of the one policy
    if (!result.has_plan()) {
      result.status = Status::Unknown;
      return result;
    }
    result.expectation->error = std::max(result.expectation->error, bound - result.reward);
    detail::judge_by(known, result);
    if (result.status == Status::Optimal) result.stop = Stop::None;
    return result;
  }

 private:
  using State = UncertainGraph::State;
  using Attempt = UncertainGraph::Attempt;
  static constexpr State kJobEnded = UncertainGraph::kJobEnded;

  [[nodiscard]] bool proved() const {
    return best_.has_plan() && detail::meets(best_.reward, upper_[start_]);
  }

  /// U of a state at first.
  [[nodiscard]] double promise(SetView open) const {
    const double certain = (*certain_.bound)(open);
    double of_breaks = 0;
    double all_breaks = 0;
    double of_ends = 0;
    double best_end = -kInfinity;
    for_each_connection(open, [&](ConnectionIndex c) {
      const Connection& tried = problem_.connections()[c];
      if (tried.success >= 1) return;
      const double q = 1 - tried.success;
      if (const std::optional<double> end = tried.on_failure.abort) {
        of_ends += q * std::max(0.0, *end - least_after(c));
        best_end = std::max(best_end, *end);
      }
      for (const ConnectionIndex broken : problem_.breaks(c)) {
        if (!contains(open, broken)) continue;
        of_breaks += q * certain_.rise[broken];
        all_breaks += certain_.rise[broken];
      }
    });
    const double by_terms = certain + of_breaks + of_ends;
    return steps_cost_ ? std::min(by_terms, std::max(certain + all_breaks, best_end)) : by_terms;
  }
  /// The least that an attempt which succeeds and all after it are said to earn.
  [[nodiscard]] double least_after(ConnectionIndex connection) const {
    const std::size_t open = system_.num_steps();
    const double last = system_.reward_range(connection, open, true).least;
    return certain_.least +
           std::min({0.0, last, system_.reward_range(connection, open, false).least});
  }

  State number_of(SetView open) {
    const auto [number, is_new] = states_.insert(open.data());
    if (is_new) {
      const bool goal = count(open) == 0;
      upper_.push_back(goal ? 0 : promise(open));
      settled_.push_back(goal ? 1 : 0);
      row_begin_.push_back(0);
      row_end_.push_back(0);
      expanded_states_.push_back(goal ? 1 : 0);
    }
    return number;
  }

  void expand(State s) {
    const std::vector<std::uint64_t> here(states_.key(s), states_.key(s) + system_.words());
    const auto legal = expander_.legal_actions(here);
    const std::vector<Action> actions(legal.begin(), legal.end());
    row_begin_[s] = attempts_.size();
    std::vector<std::uint64_t> next;
    for (const Action& action : actions) {
      const Connection& tried = problem_.connections()[action.connection];
      Attempt attempt{action.reward, action.connection, 0, s};
      next = here;
      next[action.connection / 64] &= ~(std::uint64_t{1} << (action.connection % 64));
      attempt.done = number_of(next);
      if (tried.success < 1 && tried.on_failure.abort) attempt.failed = kJobEnded;
      if (detail::breaks_to(problem_, action.connection, here, next))
        attempt.failed = number_of(next);
      attempts_.push_back(attempt);
    }
    row_end_[s] = attempts_.size();
    expanded_states_[s] = 1;
    if (++expanded_ % kLook == 0 || budget_.max_expansions < kLook) look();
  }

  void look() {
    stop_ = bytes() > allowed_ ? Stop::MemoryLimit : budget_.expired(bytes(), expanded_);
    budget_.report({.phase = "search",
                    .done = expanded_,
                    .states = states_.size(),
                    .best = best_.has_plan() ? best_.reward : -kInfinity});
  }

  /// What an attempt in state s is worth if states are worth what U says.
  [[nodiscard]] double worth(const Attempt& attempt, State s) const {
    return detail::AttemptOutcomes::safe(attempt, s, upper_) ? outcomes_.solved(attempt, s, upper_)
                                                             : -kInfinity;
  }

  /// The place of the attempt of an expanded state that promises most; of several, one whose
  /// outcomes are settled before one whose success is expanded, before the first. row_end_ if there
  /// is none, or none that may not end in a dead end.
  [[nodiscard]] std::uint64_t best_attempt(State s) const {
    std::uint64_t best = row_end_[s];
    double most = -kInfinity;
    int rank = 0;
    for (std::uint64_t i = row_begin_[s]; i < row_end_[s]; ++i) {
      const Attempt& attempt = attempts_[i];
      const double here = worth(attempt, s);
      if (here == -kInfinity) continue;
      // Where U is infinite nothing is known of a state before it is expanded.
      const double slack = std::isfinite(here) ? 1e-12 * std::max(1.0, std::abs(here)) : 0;
      const int known = settled(attempt, s) ? 2 : static_cast<int>(expanded_states_[attempt.done]);
      if (best != row_end_[s] && (here < most - slack || (here <= most + slack && known <= rank))) {
        most = std::max(most, here);
        continue;
      }
      best = i;
      most = std::max(most, here);
      rank = known;
    }
    return best;
  }
  [[nodiscard]] bool settled(const Attempt& attempt, State s) const {
    return settled_[attempt.done] != 0 &&
           (attempt.failed == s || attempt.failed == kJobEnded || settled_[attempt.failed] != 0);
  }

  /// Bellman's equation at an expanded state: U falls to what its attempts promise, and the state
  /// is settled if the outcomes of the best of them are.
  void update(State s) {
    double most = -kInfinity;
    for (std::uint64_t i = row_begin_[s]; i < row_end_[s]; ++i)
      most = std::max(most, worth(attempts_[i], s));
    upper_[s] = std::min(upper_[s], most);
    if (most == -kInfinity) {
      settled_[s] = 1;
      return;
    }
    const std::uint64_t best = best_attempt(s);
    if (settled(attempts_[best], s)) settled_[s] = 1;
  }

  void trial() {
    path_.clear();
    State s = start_;
    while (settled_[s] == 0) {
      if (expanded_states_[s] == 0) expand(s);
      path_.push_back(s);
      if (stop_ != Stop::None) return;
      const std::uint64_t best = best_attempt(s);
      if (best == row_end_[s]) break;
      const Attempt& attempt = attempts_[best];
      const double p = outcomes_.success(attempt);
      const bool done_open = settled_[attempt.done] == 0;
      const bool failed_open =
          attempt.failed != s && attempt.failed != kJobEnded && settled_[attempt.failed] == 0;
      if (!done_open && !failed_open) break;
      s = done_open && (!failed_open || p >= 0.5) ? attempt.done : attempt.failed;
    }
    for (std::size_t i = path_.size(); i > 0; --i) update(path_[i - 1]);
  }

  /// The attempt that the policy makes in a state; in one that was not expanded the one that
  /// promises most by D if it succeeds, with ends_first_ among those that may end the job.
  std::optional<ConnectionIndex> choice(SetView open) {
    const State s = states_.find(open.data());
    if (s != detail::StateTable<0>::kAbsent && expanded_states_[s] != 0) {
      const std::uint64_t best = best_attempt(s);
      return best == row_end_[s] ? std::nullopt : std::optional(attempts_[best].connection);
    }
    const auto legal = certain_expander_.legal_actions(open);
    const std::vector<Action> actions(legal.begin(), legal.end());
    if (actions.empty()) return std::nullopt;
    rests_.resize(actions.size());
    certain_.bound->of_successors(open, (*certain_.bound)(open), actions, rests_);
    const auto ends = [&](std::size_t i) {
      const Connection& tried = problem_.connections()[actions[i].connection];
      return ends_first_ && tried.success < 1 && tried.on_failure.abort.has_value();
    };
    std::size_t best = 0;
    for (std::size_t i = 1; i < actions.size(); ++i) {
      const double more = actions[i].reward + rests_[i] - actions[best].reward - rests_[best];
      if (ends(i) != ends(best) ? ends(i) : more > kRewardTolerance) best = i;
    }
    return actions[best].connection;
  }

  /// Works out what the policy earns, and keeps the best that was met. Nothing where the states
  /// that it can meet are too many.
  void evaluate_policy() {
    Budget some = budget_;
    some.max_expansions = kMostOfPolicy + expanded_;
    some.max_bytes = allowed_ > bytes() ? allowed_ - bytes() : 1;
    const UncertainGraph graph =
        UncertainGraph::build(system_, some, [this](SetView open) { return choice(open); });
    if (graph.stop() != Stop::None) return;
    const UncertainSolution solution = solve_uncertain(graph);
    if (solution.values[0] == -kInfinity) return;
    if (best_.has_plan() && solution.values[0] <= best_.reward) return;
    Budget rest = budget_;
    rest.deadline.reset();
    Result result = uncertain_value_iteration(graph, {}, rest);
    if (!result.has_plan()) return;
    result.status = Status::Feasible;
    best_ = std::move(result);
  }

  [[nodiscard]] std::uint64_t bytes() const {
    return states_.bytes() + attempts_.bytes() + upper_.bytes() + settled_.bytes() +
           expanded_states_.bytes() + row_begin_.bytes() + row_end_.bytes();
  }

  static constexpr std::uint64_t kLook = 256;
  /// The most states of a policy that is evaluated, beside those that were expanded.
  static constexpr std::uint64_t kMostOfPolicy = 50'000;

  const TransitionSystem& system_;
  const Problem& problem_;
  detail::AttemptOutcomes outcomes_;
  CertainBound certain_;
  const Budget& budget_;
  std::uint64_t allowed_;
  /// Whether no step but the last can earn more than 0.
  bool steps_cost_ = true;
  bool ends_first_ = false;
  Expander expander_;
  Expander certain_expander_;
  detail::StateTable<0> states_;
  /// By state: U, whether it is settled or expanded, and its attempts.
  detail::GrowingArray<double> upper_;
  detail::GrowingArray<unsigned char> settled_;
  detail::GrowingArray<unsigned char> expanded_states_;
  detail::GrowingArray<std::uint64_t> row_begin_;
  detail::GrowingArray<std::uint64_t> row_end_;
  detail::GrowingArray<Attempt> attempts_;
  State start_ = 0;
  std::uint64_t expanded_ = 0;
  Stop stop_ = Stop::None;
  Result best_;
  std::vector<State> path_;
  std::vector<double> rests_;
};

}  // namespace

std::optional<std::string> uncertain_search_obstacle(const TransitionSystem& system) {
  const Problem certain = attempts_paid(system.problem());
  const TransitionSystem relaxed(certain, system.situation());
  if (certain_bound(relaxed)) return std::nullopt;
  return "needs a bound on what a step can earn, and none is known for the objective '" +
         system.problem().objective().type + "'";
}

Result uncertain_search(const TransitionSystem& system, const Budget& budget) {
  if (auto result = detail::infeasible_at_once(system, "auto")) return *result;
  const Problem certain = attempts_paid(system.problem());
  const TransitionSystem relaxed(certain, system.situation());
  auto bound = certain_bound(relaxed);
  if (!bound) throw Refusal("auto", *uncertain_search_obstacle(system));
  return UncertainSearch(system, relaxed, std::move(*bound), budget).run();
}

Result uncertain_automatic(const TransitionSystem& system, const ValueIterationOptions& options,
                           const Budget& budget) {
  if (uncertain_search_obstacle(system)) return uncertain_value_iteration(system, options, budget);
  constexpr std::uint64_t kFewAttempts = 6'000'000;
  const std::uint64_t few_states = kFewAttempts / std::max<std::size_t>(1, system.num_steps());
  Budget few = budget;
  few.max_expansions = std::min(budget.max_expansions, few_states);
  Result result = uncertain_value_iteration(system, options, few);
  const bool too_many = result.stop == Stop::ExpansionLimit && budget.max_expansions > few_states;
  if (!too_many) return result;
  result = uncertain_search(system, budget);
  result.notes.insert(result.notes.begin(),
                      "auto: trials along the attempts that promise most, since attempts lead to "
                      "too many states to list them");
  return result;
}

}  // namespace orasp
