#include "orasp/explain/alternatives.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include <boost/multiprecision/cpp_int.hpp>

#include "orasp/model/tolerance.h"
#include "orasp/planners/value_iteration.h"
#include "orasp/symmetry/symmetry.h"

namespace orasp {

namespace {

using BigInt = boost::multiprecision::cpp_int;

/// How far taking `action` in `state` falls short of the best; 0 where that is rounding.
double loss_of(const StateGraph& graph, std::span<const double> values, StateId state,
               ActionId action, double tolerance) {
  const double loss = values[state] - (graph.reward(action) + values[graph.successor(action)]);
  return loss <= tolerance ? 0 : loss;
}

template <class Count>
std::string count_paths(const StateGraph& graph, std::span<const double> values, double tolerance) {
  const StateId goal = *graph.goal();
  std::vector<Count> paths(graph.num_states(), Count(0));
  paths[0] = 1;
  for (StateId s = 0; s < goal; ++s) {
    if (paths[s] == 0) continue;
    for (ActionId a = graph.begin(s); a < graph.end(s); ++a) {
      if (loss_of(graph, values, s, a, tolerance) == 0) paths[graph.successor(a)] += paths[s];
    }
  }
  return BigInt(paths[goal]).str();
}

bool has_plan(const StateGraph& graph, std::span<const double> values) {
  return graph.goal() && !values.empty() && std::isfinite(values[0]);
}

/// A plan that leaves plan `from` at step `step` by `action` and then follows V.
struct Departure {
  /// The loss in units of the tolerance, rounded: losses that differ by less are equal.
  double steps_of_loss;
  /// The place in the order of discovery.
  std::uint64_t number;
  double loss;
  std::size_t from;
  std::size_t step;
  ActionId action;
};

bool worse(const Departure& a, const Departure& b) {
  return std::tie(a.steps_of_loss, a.number) > std::tie(b.steps_of_loss, b.number);
}

}  // namespace

double loss_tolerance(const StateGraph& graph, std::span<const double> values) {
  double greatest = 0;
  for (const double value : values) {
    if (std::isfinite(value)) greatest = std::max(greatest, std::abs(value));
  }
  const auto roundings = 4 * static_cast<double>(graph.system().num_steps());
  return std::max(kRewardTolerance, roundings * std::numeric_limits<double>::epsilon() * greatest);
}

std::string count_optimal(const StateGraph& graph, std::span<const double> values) {
  if (!has_plan(graph, values)) return "0";
  const double tolerance = loss_tolerance(graph, values);
  constexpr std::size_t kMost64 = 20;   // 20! < 2^64
  constexpr std::size_t kMost128 = 34;  // 34! < 2^128
  const std::size_t connections = graph.system().num_steps();
  if (graph.system().wide()) return count_paths<BigInt>(graph, values, tolerance);
  if (connections <= kMost64) return count_paths<std::uint64_t>(graph, values, tolerance);
  if (connections <= kMost128)
    return count_paths<boost::multiprecision::uint128_t>(graph, values, tolerance);
  return count_paths<BigInt>(graph, values, tolerance);
}

Alternatives best_plans(const StateGraph& graph, std::span<const double> values, std::uint64_t most,
                        const Budget& budget) {
  Alternatives result;
  std::vector<Alternative>& plans = result.plans.emplace();
  if (most == 0 || !has_plan(graph, values)) return result;
  const double tolerance = loss_tolerance(graph, values);
  std::vector<std::vector<ActionId>> paths;  // of the plans
  std::vector<Departure> heap;
  std::uint64_t discovered = 0;
  const bool wide = graph.system().wide();
  Expander expander(graph.system());

  const auto state_after = [&](const std::vector<ActionId>& path, std::size_t steps) {
    return steps == 0 ? StateId{0} : graph.successor(path[steps - 1]);
  };
  // Follows V from the end of `path`, which lost `loss` so far, and notes the departures on the
  // way.
  const auto complete = [&](std::vector<ActionId> path, double loss) {
    for (StateId s = state_after(path, path.size()); s != *graph.goal();
         s = graph.successor(path.back())) {
      ActionId best = graph.begin(s);
      for (ActionId a = best + 1; a < graph.end(s); ++a) {
        if (graph.reward(a) + values[graph.successor(a)] >
            graph.reward(best) + values[graph.successor(best)])
          best = a;
      }
      for (ActionId a = graph.begin(s); a < graph.end(s); ++a) {
        if (a == best || !std::isfinite(values[graph.successor(a)])) continue;
        const double total = loss + loss_of(graph, values, s, a, tolerance);
        heap.push_back(
            {std::round(total / tolerance), discovered++, total, paths.size(), path.size(), a});
        std::ranges::push_heap(heap, worse);
      }
      path.push_back(best);
    }
    Alternative plan;
    StateId from = 0;
    for (const ActionId a : path) {
      plan.reward += graph.reward(a);
      if (wide) {
        const auto legal = expander.legal_actions(graph.key(from));
        PlanStep step = expander.plan_step(legal[a - graph.begin(from)]);
        plan.sequence.insert(plan.sequence.end(), step.connections.begin(), step.connections.end());
        if (!step.connections.empty()) plan.steps.push_back(std::move(step));
      } else {
        plan.sequence.push_back(graph.connection(a));
      }
      from = graph.successor(a);
    }
    plans.push_back(std::move(plan));
    paths.push_back(std::move(path));
  };

  complete({}, 0);
  const std::size_t bytes_of_plan =
      graph.system().num_steps() * (sizeof(ActionId) + sizeof(ConnectionIndex));
  while (plans.size() < most && !heap.empty()) {
    const std::uint64_t bytes =
        graph.bytes() + heap.size() * sizeof(Departure) + plans.size() * bytes_of_plan;
    if (plans.size() % 64 == 0) result.stop = budget.expired(bytes);
    if (result.stop != Stop::None) break;
    std::ranges::pop_heap(heap, worse);
    const Departure next = heap.back();
    heap.pop_back();
    const std::vector<ActionId>& origin = paths[next.from];
    std::vector<ActionId> path(origin.begin(),
                               origin.begin() + static_cast<std::ptrdiff_t>(next.step));
    path.push_back(next.action);
    complete(std::move(path), next.loss);
    // Each departure is a plan, and what departs from it is no better: more than are asked for are
    // not needed.
    const std::uint64_t needed = most - plans.size();
    if (heap.size() / 2 > needed) {
      const auto last = heap.begin() + static_cast<std::ptrdiff_t>(needed);
      std::ranges::nth_element(heap, last,
                               [](const Departure& a, const Departure& b) { return worse(b, a); });
      heap.resize(needed);
      std::ranges::make_heap(heap, worse);
    }
  }
  return result;
}

namespace {

/// No exchange but the one that changes nothing leaves a sequence of all connections as it is, so
/// each is one of as many as there are exchanges.
std::optional<std::string> up_to_symmetry(const TransitionSystem& system,
                                          const std::string& sequences) {
  const auto order = symmetry_order(system);
  if (!order || order->empty() || sequences == "0") return std::nullopt;
  boost::multiprecision::cpp_int left(sequences);
  for (const std::uint32_t factor : *order) {
    // Rounding may have told apart what is the same.
    if (left % factor != 0) return std::nullopt;
    left /= factor;
  }
  return left.str();
}

}  // namespace

Alternatives find_alternatives(const TransitionSystem& system, bool count, std::uint64_t most,
                               const Budget& budget) {
  Alternatives result;
  if (system.infeasibility()) {
    if (count) result.optimal_sequences = "0";
    if (most > 0) result.plans.emplace();
    return result;
  }
  const StateGraph graph = StateGraph::build(system, budget);
  result.stop = graph.stop();
  if (result.stop != Stop::None) return result;
  ValueIterationOptions one_sweep;
  one_sweep.max_sweeps = 1;  // exact in layer order
  const Result values = value_iteration(graph, one_sweep, budget);
  if (count) {
    result.optimal_sequences = count_optimal(graph, values.values);
    result.optimal_up_to_symmetry = up_to_symmetry(system, *result.optimal_sequences);
  }
  if (most > 0) {
    Alternatives best = best_plans(graph, values.values, most, budget);
    result.plans = std::move(best.plans);
    result.stop = best.stop;
  }
  return result;
}

}  // namespace orasp
