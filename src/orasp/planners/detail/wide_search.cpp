#include "orasp/planners/detail/wide_search.h"

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
#include "orasp/graph/graph_estimate.h"
#include "orasp/model/detail/listing.h"
#include "orasp/model/detail/rules.h"
#include "orasp/model/random.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/and_or.h"
#include "orasp/planners/detail/grounded_outlook.h"
#include "orasp/planners/detail/part_trees.h"
#include "orasp/planners/planner_support.h"
#include "orasp/planners/value_iteration.h"
#include "orasp/task/detail/listing_watch.h"
#include "orasp/task/memory_limit.h"

namespace orasp::detail {

namespace {

using Words = std::vector<std::uint64_t>;

/// Sets the plan of a result to that which goes through these states. Their steps were listed
/// before and are listed to the end, although time may be over by now.
void take_states(const TransitionSystem& system, const Words& states, Result& result) {
  const ListingScope as_before(system, {.most = system.rules().listing.most});
  take_walk(Expander(system).steps_along(states), result);
  result.status = Status::Feasible;
}

void take_plan(const Result& from, Result& to) {
  to.reward = from.reward;
  to.sequence = from.sequence;
  to.steps = from.steps;
}

/// The states from the start to `last`, by each state's parent in a table.
template <class Parents>
Words states_to(const StateTable<0>& table, const Parents& parent, std::uint32_t last,
                std::size_t words) {
  std::vector<std::uint32_t> path{last};
  while (path.back() != 0) path.push_back(parent[path.back()]);
  Words states;
  for (auto state = path.rbegin(); state != path.rend(); ++state)
    states.insert(states.end(), table.key(*state), table.key(*state) + words);
  return states;
}

/// The legal actions of a state; `stop` says where the budget was spent before all were listed.
std::span<const Action> listed(Expander& expander, SetView state, const ListingWatch& watch,
                               Stop& stop) {
  try {
    return expander.legal_actions(state);
  } catch (const ListingStopped& stopped) {
    stop = watch.reason(stopped);
    return {};
  }
}

double rounding_of(const TransitionSystem& system, double running) {
  return 1e-15 * static_cast<double>(system.num_connections()) * std::max(1.0, std::abs(running));
}

}  // namespace

std::optional<std::string> wide_bound_obstacle(const TransitionSystem& system) {
  if (WideBound(system).known()) return std::nullopt;
  return "needs a bound on what steps can earn, and the objective has none here";
}

// -------------------------------------------------------------------------------------------------

Result wide_a_star(const TransitionSystem& system, const Budget& budget) {
  constexpr std::uint64_t kPollEvery = 256;
  if (auto result = infeasible_at_once(system, "a-star")) return *result;
  WideBound bound(system);
  if (const auto reason = wide_bound_obstacle(system)) throw Refusal("a-star", *reason);
  const Stopwatch watch;
  const std::uint64_t allowed = allowed_bytes(budget);
  const std::size_t words = system.words();
  struct Open {
    double promise;
    std::uint32_t open;  ///< connections
    std::uint32_t state;
    double reward;
  };
  // The best on top: the greatest promise, but for rounding, then the fewest open connections.
  const double all = bound(system.start_state());
  const double tick = kRewardTolerance * std::max(1.0, std::abs(all));
  const auto later = [](const Open& a, const Open& b) {
    if (a.promise != b.promise) return a.promise < b.promise;
    return a.open != b.open ? a.open > b.open : a.state < b.state;
  };
  const ListingWatch listing(system, budget);
  Expander expander(system);
  StateTable<0> table(words);
  GrowingArray<double> reward;
  GrowingArray<double> rest;
  GrowingArray<std::uint32_t> parent;
  std::vector<Open> heap;
  Result result;
  result.method = "a-star";
  Statistics& statistics = result.statistics;
  const auto meet = [&](const std::uint64_t* key, double running, std::uint32_t from) {
    const auto [number, is_new] = table.insert(key);
    if (is_new) {
      reward.push_back(running);
      rest.push_back(bound({key, words}));
      parent.push_back(from);
    } else {
      if (running <= reward[number] + rounding_of(system, running)) {
        ++statistics.pruned;
        return;
      }
      ++statistics.reopened;
      reward[number] = running;
      parent[number] = from;
    }
    if (rest[number] == -kInfinity) return;
    heap.push_back({std::floor((running + rest[number]) / tick + 0.5) * tick,
                    static_cast<std::uint32_t>(count(system.open({key, words}))), number, running});
    std::ranges::push_heap(heap, later);
  };
  const auto bytes = [&] {
    return table.bytes() + reward.bytes() + rest.bytes() + parent.bytes() +
           heap.capacity() * sizeof(Open);
  };
  meet(system.start_state().data(), 0, 0);
  GroundedOutlook outlook(system);
  Words key(words);
  Words next(words);
  result.stop = budget.expired();
  while (!heap.empty() && result.stop == Stop::None) {
    std::ranges::pop_heap(heap, later);
    const Open top = heap.back();
    heap.pop_back();
    if (top.reward < reward[top.state]) continue;  // met again by a better way
    std::copy_n(table.key(top.state), words, key.begin());
    if (system.ends(key)) {
      take_states(system, states_to(table, parent, top.state, words), result);
      result.status = Status::Optimal;
      result.bound = result.reward;
      break;
    }
    if (outlook.applies() && outlook.is_shut(system.open(key))) continue;
    if (++statistics.expanded % kPollEvery == 0 || budget.max_expansions < kPollEvery) {
      result.stop =
          bytes() > allowed ? Stop::MemoryLimit : budget.expired(bytes(), statistics.expanded);
      budget.report({.phase = "search", .done = statistics.expanded, .states = table.size()});
      if (result.stop != Stop::None) {
        result.bound = top.promise + tick;
        break;
      }
    }
    const std::span<const Action> actions = listed(expander, key, listing, result.stop);
    if (result.stop != Stop::None) {
      result.bound = top.promise + tick;
      break;
    }
    for (const Action& action : actions) {
      ++statistics.generated;
      expander.successor(key, action, next);
      meet(next.data(), top.reward + action.reward, top.state);
    }
  }
  statistics.states = table.size();
  statistics.peak_bytes = bytes();
  if (result.stop != Stop::None) {
    const std::optional<double> most = result.bound ? result.bound : std::optional(all);
    result = stopped_with_quick_plan(system, "a-star", result.stop, statistics);
    result.bound = most;
  } else if (result.status != Status::Optimal) {
    result = exhausted("a-star", statistics);
  }
  result.statistics.seconds = watch.seconds();
  return result;
}

// -------------------------------------------------------------------------------------------------

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

/// Whether plans can be looked for backwards: where steps put parts on and look at nothing that was
/// done before.
bool turns_round(const TransitionSystem& system) {
  return system.rules().by_part && !system.takes_apart() && !system.ordered() &&
         !system.looks_back();
}

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

namespace {

/// Whether the start has more steps than can be gone through again and again.
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

}  // namespace

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

// -------------------------------------------------------------------------------------------------

Result wide_beam(const TransitionSystem& system, const Result* incumbent, const Budget& budget) {
  if (auto result = infeasible_at_once(system, "beam")) return *result;
  WideBound bound(system);
  if (!bound.known()) throw Refusal("beam", *wide_bound_obstacle(system));
  const Stopwatch watch;
  constexpr std::uint64_t kPollEvery = 256;
  constexpr std::size_t kFirstWidth = 64;
  const std::size_t words = system.words();
  const std::uint64_t allowed = allowed_bytes(budget);
  Result result;
  result.method = "beam";
  if (incumbent != nullptr && incumbent->has_plan()) {
    result.status = Status::Feasible;
    take_plan(*incumbent, result);
  }
  Statistics& statistics = result.statistics;
  const double all = bound(system.start_state());
  const ListingWatch listing(system, budget);
  Expander expander(system);
  Words key(words);
  Words next(words);
  struct Node {
    double promise;
    double rank;  ///< the greatest stay
    std::uint32_t state;
  };
  result.stop = budget.expired();
  double proved = all;
  GroundedOutlook outlook(system);
  bool priced = true;  // whether states are ordered by what moves are priced at
  for (std::size_t width = kFirstWidth; result.stop == Stop::None; width *= 2) {
    priced = !priced;
    StateTable<0> table(words);
    GrowingArray<double> reward;
    GrowingArray<std::uint32_t> parent;
    std::vector<std::vector<Node>> layers(system.num_steps() + 1);  // by open connections
    double dropped = -kInfinity;
    const auto meet = [&](const Words& state, double running, std::uint32_t from) {
      const double promise = running + bound(state);
      if (promise <= result.reward + kRewardTolerance) {
        ++statistics.pruned;
        return;
      }
      const auto [number, is_new] = table.insert(state.data());
      if (is_new) {
        reward.push_back(running);
        parent.push_back(from);
        layers[count(system.open(state))].push_back({promise, promise, number});
      } else if (running > reward[number] + rounding_of(system, running)) {
        reward[number] = running;
        parent[number] = from;
        ++statistics.reopened;
      } else {
        ++statistics.pruned;
      }
    };
    const SetView start = system.start_state();
    meet({start.begin(), start.end()}, 0, 0);
    for (std::size_t left = system.num_steps(); left > 0 && result.stop == Stop::None; --left) {
      std::vector<Node>& layer = layers[left];
      for (Node& node : layer) {
        std::copy_n(table.key(node.state), words, key.begin());
        node.promise = reward[node.state] + bound(key);
        node.rank = node.promise + (priced ? 0.0 : bound.priced_moves());
      }
      if (layer.size() > width) {
        std::ranges::nth_element(layer, layer.begin() + static_cast<std::ptrdiff_t>(width),
                                 std::ranges::greater{}, &Node::rank);
        for (std::size_t i = width; i < layer.size(); ++i)
          dropped = std::max(dropped, layer[i].promise);
        layer.resize(width);
      }
      for (const Node& node : layer) {
        std::copy_n(table.key(node.state), words, key.begin());
        if (outlook.applies() && outlook.is_shut(system.open(key))) continue;
        const std::span<const Action> actions = listed(expander, key, listing, result.stop);
        if (result.stop != Stop::None) break;
        for (const Action& action : actions) {
          expander.successor(key, action, next);
          ++statistics.generated;
          meet(next, reward[node.state] + action.reward, node.state);
        }
        if (++statistics.expanded % kPollEvery == 0 || budget.max_expansions < kPollEvery) {
          const std::uint64_t bytes =
              table.bytes() + reward.bytes() + parent.bytes() + table.size() * sizeof(Node);
          statistics.peak_bytes = std::max(statistics.peak_bytes, bytes);
          result.stop =
              bytes > allowed ? Stop::MemoryLimit : budget.expired(bytes, statistics.expanded);
          budget.report({.phase = "search",
                         .done = statistics.expanded,
                         .states = table.size(),
                         .best = result.reward});
          if (result.stop != Stop::None) break;
        }
      }
    }
    statistics.states = std::max<std::uint64_t>(statistics.states, table.size());
    for (const Node& end : layers[0]) {
      if (reward[end.state] <= result.reward) continue;
      take_states(system, states_to(table, parent, end.state, words), result);
    }
    if (result.stop != Stop::None) break;
    // Nothing that was dropped can earn more than this.
    proved = std::min(proved, std::max(dropped, result.reward));
    if (dropped <= result.reward + kRewardTolerance) break;
  }
  if (result.stop == Stop::None && !result.has_plan()) {
    result = exhausted("beam", statistics);
  } else if (result.stop == Stop::None) {
    result.status = Status::Optimal;
    result.bound = result.reward;
  } else {
    if (!result.has_plan())
      result = stopped_with_quick_plan(system, "beam", result.stop, statistics);
    result.bound = std::max(proved, result.reward);
    if (meets(result.reward, *result.bound)) judge_by(result.bound, result);
  }
  result.statistics.seconds = watch.seconds();
  return result;
}

// -------------------------------------------------------------------------------------------------

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
