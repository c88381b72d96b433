#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "orasp/bounds/wide_bound.h"
#include "orasp/containers/growing_array.h"
#include "orasp/containers/state_table.h"
#include "orasp/model/random.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/detail/grounded_outlook.h"
#include "orasp/planners/detail/wide_search.h"
#include "orasp/planners/detail/wide_support.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/memory_limit.h"

// Depth first: branch and bound, every sequence, and some plan.

namespace orasp::detail {

namespace {

/// An action not yet followed, and where it leads.
struct Untried {
  double reward;
  double rest;         ///< a bound on what follows
  std::uint32_t next;  ///< the place of its successor among those of the path
};

/// The frame of the searches that hold one path and the untried actions of its states.
class PathSearch {
 public:
  PathSearch(const TransitionSystem& system, const Budget& budget)
      : system_(system), listing_(system, budget), expander_(system), words_(system.words()) {
    const SetView start = system.start_state();
    states_.assign(start.begin(), start.end());
  }

  /// The states of the path, as Expander::steps_along takes them.
  [[nodiscard]] const Words& states() const { return states_; }
  [[nodiscard]] SetView state() const { return SetView(states_).last(words_); }
  [[nodiscard]] double running() const { return running_.back(); }
  [[nodiscard]] bool at_end() const { return system_.ends(state()); }
  /// Whether no state of the path has untried actions, and the path is left.
  [[nodiscard]] bool over() const { return frames_.empty(); }
  [[nodiscard]] bool all_tried() const { return untried_.size() == frames_.back().untried; }
  [[nodiscard]] SetView successor(const Untried& action) const {
    return SetView(successors_).subspan(action.next * words_, words_);
  }
  [[nodiscard]] std::uint64_t bytes() const {
    return untried_.capacity() * sizeof(Untried) + successors_.capacity() * sizeof(std::uint64_t);
  }

  /// Lists the actions of the state at the end of the path; `rest(state)` bounds what follows each,
  /// `order(actions)` puts them into the order in which they are taken, from the back. `stop` says
  /// where the budget was spent before all were listed: then none is there.
  template <class Rest, class Order>
  void enter(Rest&& rest, Order&& order, Stop& stop) {
    frames_.push_back({untried_.size(), successors_.size()});
    const std::span<const Action> actions = listed(expander_, state(), listing_, stop);
    interrupted_ = stop != Stop::None;
    for (const Action& action : actions) {
      const std::size_t begin = successors_.size();
      successors_.resize(begin + words_);
      const std::span<std::uint64_t> next = std::span(successors_).subspan(begin);
      expander_.successor(state(), action, next);
      untried_.push_back(
          {action.reward, rest(SetView(next)), static_cast<std::uint32_t>(begin / words_)});
    }
    order(std::span(untried_).subspan(frames_.back().untried));
  }
  [[nodiscard]] Untried take() {
    const Untried action = untried_.back();
    untried_.pop_back();
    return action;
  }
  void follow(const Untried& action) {
    running_.push_back(running_.back() + action.reward);
    const SetView next = successor(action);
    states_.insert(states_.end(), next.begin(), next.end());
  }
  /// Back from a state that was followed to and not entered.
  void back() {
    states_.resize(states_.size() - words_);
    running_.pop_back();
  }
  /// Back from a state that was entered.
  void leave() {
    successors_.resize(frames_.back().successors);
    frames_.pop_back();
    if (!frames_.empty()) back();
  }
  /// What the state at the end of the path promises where its actions were not all listed.
  template <class Rest>
  [[nodiscard]] double promise_of_last(Rest&& rest) const {
    return interrupted_ ? running() + rest(state()) : -kInfinity;
  }
  /// The most that one of the untried actions of the whole path promises.
  [[nodiscard]] double most_promised() const {
    double most = -kInfinity;
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      const std::size_t end = f + 1 < frames_.size() ? frames_[f + 1].untried : untried_.size();
      for (std::size_t i = frames_[f].untried; i < end; ++i)
        most = std::max(most, running_[f] + untried_[i].reward + untried_[i].rest);
    }
    return most;
  }

 private:
  struct Frame {
    std::size_t untried;     ///< where the actions of the state begin in untried_
    std::size_t successors;  ///< where its successors begin in successors_
  };

  const TransitionSystem& system_;
  ListingWatch listing_;
  Expander expander_;
  std::size_t words_;
  Words states_;
  std::vector<double> running_{0.0};
  std::vector<Untried> untried_;
  std::vector<Frame> frames_;
  Words successors_;
  bool interrupted_ = false;
};

const auto kNoRest = [](SetView) { return 0.0; };

/// A uniform shuffle (Fisher and Yates 1938; Durstenfeld 1964).
void shuffle(std::span<Untried> actions, SplitMix64& random) {
  for (std::size_t left = actions.size(); left > 1; --left)
    std::swap(actions[left - 1], actions[random.below(left)]);
}

}  // namespace

Result wide_depth_first(const TransitionSystem& system, std::uint64_t seed, const Budget& budget) {
  constexpr std::uint64_t kPollEvery = 256;
  if (auto result = infeasible_at_once(system, "orasp-search")) return *result;
  WideBound bound(system);
  if (!bound.known()) throw Refusal("orasp-search", *wide_bound_obstacle(system));
  const Stopwatch watch;
  const std::uint64_t allowed = allowed_bytes(budget);
  Result result;
  result.method = "orasp-search";
  Statistics& statistics = result.statistics;
  PathSearch search(system, budget);
  StateTable<0> met(system.words());
  GrowingArray<double> best;
  const auto meet = [&](SetView state, double running) {
    const auto [number, is_new] = met.insert(state.data());
    if (is_new) {
      best.push_back(running);
      return true;
    }
    if (running <= best[number] + rounding_of(system, running)) return false;
    best[number] = running;
    ++statistics.reopened;
    return true;
  };
  GroundedOutlook outlook(system);
  const auto rest = [&](SetView state) { return bound(state); };
  const auto order = [](std::span<Untried> actions) {
    std::ranges::stable_sort(actions, [](const Untried& a, const Untried& b) {
      const double left = std::floor((a.reward + a.rest) / kRewardTolerance + 0.5);
      const double right = std::floor((b.reward + b.rest) / kRewardTolerance + 0.5);
      return left != right ? left < right : a.reward < b.reward;
    });
  };
  const auto bytes = [&] { return met.bytes() + best.bytes() + search.bytes(); };
  const auto arrive = [&] {
    if (search.at_end()) take_states(system, search.states(), result);
    search.enter(rest, order, result.stop);
    ++statistics.expanded;
  };
  meet(system.start_state(), 0);
  arrive();
  if (result.stop == Stop::None) result.stop = budget.expired(0, statistics.expanded);
  while (!search.over() && result.stop == Stop::None) {
    if (search.all_tried()) {
      search.leave();
      continue;
    }
    const Untried action = search.take();
    ++statistics.generated;
    const double running = search.running() + action.reward;
    const SetView next = search.successor(action);
    if (running + action.rest <= result.reward + kRewardTolerance || !meet(next, running) ||
        (outlook.applies() && outlook.is_shut(system.open(next)))) {
      ++statistics.pruned;
      continue;
    }
    search.follow(action);
    arrive();
    if (result.stop != Stop::None) break;
    if (statistics.expanded % kPollEvery == 0 || budget.max_expansions < kPollEvery) {
      result.stop =
          bytes() > allowed ? Stop::MemoryLimit : budget.expired(bytes(), statistics.expanded);
      budget.report({.phase = "search",
                     .done = statistics.expanded,
                     .states = met.size(),
                     .best = result.reward});
    }
  }
  statistics.states = met.size();
  statistics.peak_bytes = bytes();
  if (result.stop != Stop::None) {
    const double most =
        std::max({result.reward, search.promise_of_last(rest), search.most_promised()});
    if (!result.has_plan())
      result = stopped_with_quick_plan(system, "orasp-search", result.stop, statistics);
    result.bound = std::max(most, result.reward);
  } else if (result.has_plan()) {
    result.status = Status::Optimal;
    result.bound = result.reward;
  } else {
    result = exhausted("orasp-search", statistics);
  }
  result.seed = seed;
  result.statistics.seconds = watch.seconds();
  return result;
}

// -------------------------------------------------------------------------------------------------

Result wide_exhaustive(const TransitionSystem& system, const Budget& budget) {
  constexpr std::uint64_t kPollEvery = 1024;
  if (auto result = infeasible_at_once(system, "exhaustive")) return *result;
  const Stopwatch watch;
  Result result;
  result.method = "exhaustive";
  Statistics& statistics = result.statistics;
  PathSearch search(system, budget);
  const auto as_listed = [](std::span<Untried> actions) { std::ranges::reverse(actions); };
  const auto arrive = [&] {
    if (search.at_end() && (!result.has_plan() || search.running() > result.reward))
      take_states(system, search.states(), result);
    search.enter(kNoRest, as_listed, result.stop);
    ++statistics.expanded;
  };
  arrive();
  if (result.stop == Stop::None) result.stop = budget.expired(0, statistics.expanded);
  while (!search.over() && result.stop == Stop::None) {
    if (search.all_tried()) {
      search.leave();
      continue;
    }
    search.follow(search.take());
    ++statistics.generated;
    arrive();
    if (result.stop != Stop::None) break;
    if (statistics.expanded % kPollEvery == 0 || budget.max_expansions < kPollEvery) {
      result.stop = budget.expired(0, statistics.expanded);
      budget.report({.phase = "search", .done = statistics.expanded, .best = result.reward});
    }
  }
  if (result.stop == Stop::None && !result.has_plan()) {
    result = exhausted("exhaustive", statistics);
  } else if (result.stop == Stop::None) {
    result.status = Status::Optimal;
    result.bound = result.reward;
  } else if (!result.has_plan()) {
    result = stopped_with_quick_plan(system, "exhaustive", result.stop, statistics);
  }
  result.statistics.seconds = watch.seconds();
  return result;
}

// -------------------------------------------------------------------------------------------------

namespace {

/// Some plan, depth first with a memory of states from which everything failed.
///
/// Idea.       What comes first may lead where no end is, and the step that did the harm is then
///             far back: going through all that follows it may take longer than anybody waits.
///             So the search begins again after a while, with another order of the steps, and for
///             twice as long each time all orders had their turn: `order`, the steps as they are
///             listed, and a random one (Gomes, Selman and Kautz 1998, Boosting combinatorial
///             search through randomization). What is known to fail stays known, and where all
///             comes off a base (GroundedOutlook) it is mostly known at once.
/// Guarantee.  Complete, since turns grow: that nothing is left to be tried is a proof.
template <class Rest, class Order>
Result some_plan(const TransitionSystem& system, const Budget& budget, std::string_view method,
                 Rest&& rest, Order&& order) {
  constexpr std::uint64_t kPollEvery = 64;
  constexpr std::uint64_t kOrders = 3;
  constexpr std::uint64_t kLeastTurn = 256;
  if (auto result = infeasible_at_once(system, method)) return *result;
  const Stopwatch watch;
  Result result;
  result.method = method;
  Statistics& statistics = result.statistics;
  std::optional<PathSearch> path(std::in_place, system, budget);
  StateTable<0> failed(system.words());
  GroundedOutlook outlook(system);
  std::uint64_t turn = 0;
  std::uint64_t turn_ends = 0;  // at so many expansions
  SplitMix64 random(0);
  const auto in_turn = [&](std::span<Untried> actions) {
    if (turn % kOrders == 0)
      order(actions);
    else if (turn % kOrders == 1)
      std::ranges::reverse(actions);
    else
      shuffle(actions, random);
  };
  const auto arrive = [&] {
    path->enter(rest, in_turn, result.stop);
    ++statistics.expanded;
  };
  const auto begin_turn = [&] {
    const std::uint64_t whole_path = kLeastTurn + 4 * system.num_steps();
    turn_ends = statistics.expanded + (whole_path << std::min<std::uint64_t>(turn / kOrders, 32));
    path.emplace(system, budget);
    arrive();
  };
  begin_turn();
  if (result.stop == Stop::None) result.stop = budget.expired(0, statistics.expanded);
  while (!path->over() && result.stop == Stop::None && !path->at_end()) {
    if (path->all_tried()) {
      failed.insert(path->state().data());
      path->leave();
      continue;
    }
    const Untried action = path->take();
    const SetView next = path->successor(action);
    const bool fails = failed.find(next.data()) != StateTable<0>::kAbsent;
    if (fails || (outlook.applies() && outlook.is_shut(system.open(next)))) {
      if (!fails) failed.insert(next.data());
      ++statistics.pruned;
      continue;
    }
    path->follow(action);
    ++statistics.generated;
    arrive();
    if (result.stop != Stop::None) break;
    if (statistics.expanded % kPollEvery == 0 || budget.max_expansions < kPollEvery)
      result.stop = budget.expired(failed.bytes() + path->bytes(), statistics.expanded);
    if (statistics.expanded >= turn_ends && !path->at_end() && result.stop == Stop::None) {
      ++turn;
      begin_turn();
    }
  }
  const PathSearch& search = *path;
  statistics.states = failed.size();
  statistics.peak_bytes = failed.bytes() + search.bytes();
  if (!search.over() && search.at_end()) {
    take_states(system, search.states(), result);
    result.stop = Stop::None;
    // Where nothing is to be done, the empty plan is the only one, and so the best.
    if (system.ends(system.start_state())) {
      result.status = Status::Optimal;
      result.bound = 0;
    }
  } else if (result.stop == Stop::None) {
    result = exhausted(method, statistics);
  }
  result.statistics.seconds = watch.seconds();
  return result;
}

const auto greatest_last = [](std::span<Untried> actions) {
  std::ranges::reverse(actions);
  std::ranges::stable_sort(actions, {}, &Untried::reward);
};

}  // namespace

Result turned_round(const TransitionSystem& system, Result result) {
  if (!result.has_plan()) return result;
  Words states(system.start_state().begin(), system.start_state().end());
  for (auto step = result.steps.rbegin(); step != result.steps.rend(); ++step) {
    const std::size_t last = states.size() - system.words();
    for (std::size_t w = 0; w < system.words(); ++w) states.push_back(states[last + w]);
    for (const ConnectionIndex c : step->connections)
      states[last + system.words() + c / 64] &= ~(std::uint64_t{1} << (c % 64));
  }
  if (!system.ends(SetView(states).last(system.words()))) return {};
  const Status status = result.status;
  const double reward = result.reward;
  try {
    take_states(system, states, result);
    result.status = status;
  } catch (const std::logic_error&) {
    return {};
  }
  const bool same = meets(result.reward, reward) && meets(reward, result.reward);
  return same ? result : Result();
}

bool has_many_moves(const TransitionSystem& system) {
  constexpr int kMostAsked = 100;  // times 256 steps
  if (!system.rules().by_part) return false;
  int asked = 0;
  const ListingScope at_most(system,
                             {.stop = [&asked](std::uint64_t) { return ++asked > kMostAsked; }});
  try {
    static_cast<void>(Expander(system).legal_actions(system.start_state()));
  } catch (const ListingStopped&) {
    return true;
  }
  return false;
}

Result plan_of_few_moves(const TransitionSystem& system, const Budget& budget) {
  if (turns_round(system)) {
    const TransitionSystem backwards = system.backwards();
    Result turned = turned_round(system, plan_of_few_moves(backwards, budget));
    if (turned.has_plan()) return turned;
  }
  Result result;
  result.method = "greedy";
  for (const std::size_t most : {1, 2, 4}) {
    const ListingScope few(system, {.most = most});
    Result found = some_plan(system, budget, "greedy", kNoRest, greatest_last);
    if (found.has_plan()) return found;
    result.stop = found.stop;
    if (budget.expired() != Stop::None) break;
  }
  return result;
}

Result wide_greedy(const TransitionSystem& system, const Budget& budget) {
  return or_quick_plan(system, some_plan(system, budget, "greedy", kNoRest, greatest_last));
}

Result wide_random(const TransitionSystem& system, std::uint64_t seed, const Budget& budget) {
  SplitMix64 random(seed);
  Result result = some_plan(system, budget, "random", kNoRest,
                            [&](std::span<Untried> actions) { shuffle(actions, random); });
  result = or_quick_plan(system, std::move(result));
  result.seed = seed;
  return result;
}

Result wide_guided_greedy(const TransitionSystem& system, const Budget& budget) {
  WideBound bound(system);
  if (!bound.known()) return wide_greedy(system, budget);
  return wide_plan_by(
      system, "greedy", [&](SetView state) { return bound(state); }, budget);
}

Result wide_plan_by(const TransitionSystem& system, std::string_view method,
                    const std::function<double(SetView)>& rest, const Budget& budget) {
  return some_plan(system, budget, method, rest, [](std::span<Untried> actions) {
    std::ranges::reverse(actions);
    std::ranges::stable_sort(actions, [](const Untried& a, const Untried& b) {
      return a.reward + a.rest < b.reward + b.rest - kRewardTolerance;
    });
  });
}

}  // namespace orasp::detail
