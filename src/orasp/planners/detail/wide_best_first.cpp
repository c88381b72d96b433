#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "orasp/bounds/wide_bound.h"
#include "orasp/containers/growing_array.h"
#include "orasp/containers/state_table.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/detail/grounded_outlook.h"
#include "orasp/planners/detail/wide_search.h"
#include "orasp/planners/detail/wide_support.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/memory_limit.h"

// Best first, and in layers of growing width.

namespace orasp::detail {

std::optional<std::string> wide_bound_obstacle(const TransitionSystem& system) {
  if (WideBound(system).known()) return std::nullopt;
  return "needs a bound on what steps can earn, and the objective has none here";
}

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

}  // namespace orasp::detail
