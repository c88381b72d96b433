#include "orasp/graph/graph_estimate.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "orasp/bounds/connection_bound.h"
#include "orasp/graph/state_graph.h"
#include "orasp/graph/wide_graph_builder.h"
#include "orasp/model/random.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {

/// The memory to hold H and one number for each state, and the keys of the largest layer while it
/// is merged.
double graph_bytes(const TransitionSystem& system, double states, double actions,
                   double widest_layer_actions) {
  const double key = 8.0 * static_cast<double>(system.words());
  return states * (key + 8 + 8) + actions * 7 + widest_layer_actions * (key + 11);
}

/// False where a state can be seen not to occur: a connection is gone before one that it comes
/// after, or there are too many subassemblies. (In assembly these are reached, and are dead ends.)
bool breaks_no_rule(const TransitionSystem& system, SetView open) {
  const Problem& problem = system.problem();
  const ConnectionSet there = system.present(open);
  const auto present = [&](ConnectionIndex c) { return there.contains(c); };
  for (const PrecedenceClause& clause : problem.precedence()) {
    if (present(clause.connection)) {
      if (!clause.made_after_any.empty() && std::ranges::none_of(clause.made_after_any, present))
        return false;
      continue;
    }
    if (!system.takes_apart() && system.kept().contains(clause.connection)) continue;  // given up
    if (std::ranges::any_of(clause.after, present)) return false;
    if (!clause.after_any.empty() && std::ranges::all_of(clause.after_any, present)) return false;
  }
  const auto most = problem.limits().max_subassemblies;
  return !most || !system.takes_apart() || system.subassemblies(there.view()) <= *most;
}

/// Whether some legal action leads into a state, as far as can be seen from the states before it.
bool has_a_way_in(const TransitionSystem& system, Expander& expander, ConnectionSet& open) {
  if (!breaks_no_rule(system, open.view())) return false;
  bool at_start = true;
  for (ConnectionIndex c = 0; c < open.universe(); ++c) {
    if (open.contains(c) || !system.start().contains(c)) continue;
    at_start = false;
    open.insert(c);
    const bool way = breaks_no_rule(system, open.view()) && expander.legal(open.view(), c);
    open.erase(c);
    if (way) return true;
  }
  return at_start;
}

/// The number of legal ways into `state`, estimated from `probes` of them: one of the connections
/// that are handled is put back, and the question is whether handling it again is legal.
double ways_into(const TransitionSystem& system, Expander& expander, ConnectionSet& state,
                 std::size_t probes, SplitMix64& random) {
  std::vector<ConnectionIndex> handled;
  for (ConnectionIndex c = 0; c < system.num_connections(); ++c) {
    if (system.start().contains(c) && !state.contains(c)) handled.push_back(c);
  }
  const std::size_t all = handled.size();
  const std::size_t looked_at = std::min(probes, all);
  std::size_t legal = 0;
  for (std::size_t i = 0; i < looked_at; ++i) {
    std::swap(handled[i], handled[i + random.below(all - i)]);
    state.insert(handled[i]);
    if (expander.legal(state.view(), handled[i]) && has_a_way_in(system, expander, state)) ++legal;
    state.erase(handled[i]);
  }
  return std::max(
      1.0, static_cast<double>(legal) * static_cast<double>(all) / static_cast<double>(looked_at));
}

/// Systematic resampling: `particles` of `states`, each as often as its weight says, but for
/// rounding.
std::vector<ConnectionSet> resampled(const std::vector<ConnectionSet>& states,
                                     const std::vector<double>& weights, std::size_t particles,
                                     SplitMix64& random) {
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::vector<ConnectionSet> chosen;
  double mark = random.uniform();
  double reached = 0;
  std::size_t i = 0;
  for (std::size_t p = 0; p < particles; ++p, mark += 1) {
    while (i + 1 < states.size() &&
           reached + weights[i] <= mark * total / static_cast<double>(particles)) {
      reached += weights[i++];
    }
    chosen.push_back(states[i]);
  }
  return chosen;
}

/// Sequential Monte Carlo over the layers (Gordon, Salmond, Smith 1993; for counting, Knuth 1975).
/// With s uniform in layer k and s' a uniform successor, the mean of b(s) / p(s') is N(k+1) / N(k);
/// particles are then resampled by these weights. Ways into s' that only come from unreachable
/// states are counted too, which makes the estimate low.
GraphEstimate sampled(const TransitionSystem& system, double enough_actions) {
  const bool is_small = system.num_connections() <= 64;
  const std::size_t particles = is_small ? 256 : 8;
  const std::size_t probes = is_small ? 24 : 8;
  SplitMix64 random(1);
  Expander expander(system);
  std::vector<ConnectionSet> layer(particles, system.start());
  GraphEstimate estimate{1, 0, 0, false};
  double width = 1;
  double widest = 0;
  for (std::size_t k = 0; k < system.num_steps(); ++k) {
    std::vector<ConnectionSet> next;
    std::vector<double> weights;
    double mean_actions = 0;
    double mean_ratio = 0;
    for (const ConnectionSet& state : layer) {
      const auto actions = expander.legal_actions(state.view());
      const double b = static_cast<double>(actions.size());
      mean_actions += b / static_cast<double>(particles);
      if (actions.empty()) continue;
      ConnectionSet successor = state;
      successor.erase(actions[random.below(actions.size())].connection);
      weights.push_back(b / ways_into(system, expander, successor, probes, random));
      mean_ratio += weights.back() / static_cast<double>(particles);
      next.push_back(std::move(successor));
    }
    estimate.actions += width * mean_actions;
    widest = std::max(widest, width * mean_actions);
    if (next.empty() || estimate.actions > enough_actions) break;
    width *= mean_ratio;
    estimate.states += width;
    layer = resampled(next, weights, particles, random);
  }
  estimate.bytes = graph_bytes(system, estimate.states, estimate.actions, widest);
  return estimate;
}

/// Where states and steps are wide nothing is known from the connections alone: a part of H is
/// built. An H that is larger is taken to be as large as there are subsets of its connections, for
/// each context that was met.
GraphEstimate looked_at(const TransitionSystem& system, const Budget& limits) {
  constexpr std::uint64_t kMostStates = 100'000;
  Budget budget;
  budget.deadline = limits.deadline;
  budget.stop = limits.stop;
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30U;
  budget.max_bytes = std::min(allowed_bytes(limits), kMostBytes);
  // An expansion looks at the moves of each part, and for each at all parts and connections; and
  // the more parts, the less likely that H is small.
  const auto parts = static_cast<double>(system.problem().num_parts());
  const double work = parts * parts * (parts + static_cast<double>(system.num_connections()));
  const auto most = static_cast<std::uint64_t>(
      std::clamp(1.5e9 / (work + 1), 1000.0, static_cast<double>(kMostStates)));
  const StateGraph graph = WideGraphBuilder(system, budget).build(most);
  if (graph.stop() == Stop::None) {
    return {static_cast<double>(graph.num_states()), static_cast<double>(graph.num_actions()),
            static_cast<double>(graph.peak_bytes()), true};
  }
  const double subsets = std::exp2(static_cast<double>(system.num_steps()));
  const double states = std::max(10.0 * kMostStates, subsets);
  const double actions = states * static_cast<double>(system.num_steps()) / 2;
  return {states, actions, graph_bytes(system, states, actions, actions), false};
}

/// A count such as 1,234,567 up to a million million, and beyond that a power of ten; one that no
/// `double` holds is more than the largest.
std::string size_text(double count) {
  if (!std::isfinite(count)) return "more than 1e308";
  if (count < 1e12) {
    std::string digits = std::to_string(static_cast<std::uint64_t>(count));
    for (std::ptrdiff_t i = static_cast<std::ptrdiff_t>(digits.size()) - 3; i > 0; i -= 3) {
      digits.insert(static_cast<std::size_t>(i), ",");
    }
    return digits;
  }
  const double power = std::floor(std::log10(count));
  const double leading = std::round(count / std::pow(10, power) * 10) / 10;
  std::string text = std::to_string(leading);
  text.erase(text.find('.') + 2);
  return text + "e" + std::to_string(static_cast<int>(power));
}

std::string bytes_text(double bytes) {
  constexpr double kMebibyte = 1024.0 * 1024.0;
  return bytes < 1024 * kMebibyte ? size_text(std::ceil(bytes / kMebibyte)) + " MiB"
                                  : size_text(std::ceil(bytes / kMebibyte / 1024)) + " GiB";
}

}  // namespace

GraphEstimate estimate_without_constraints(const TransitionSystem& system) {
  const double n = static_cast<double>(system.num_steps());
  const double states = std::exp2(n);
  const double actions = n * states / 2;
  // The widest layer holds about sqrt(2 / (pi n)) of all.
  const double widest = actions * std::min(1.0, std::sqrt(0.64 / std::max(1.0, n)));
  return {states, actions, graph_bytes(system, states, actions, widest), true};
}

bool unconstrained(const TransitionSystem& system) {
  const Problem& problem = system.problem();
  return problem.precedence().empty() && problem.directions().empty() && !problem.limits().any() &&
         !system.ordered() && !system.wide();
}

GraphEstimate estimate_graph(const TransitionSystem& system, const Budget& limits,
                             double enough_actions) {
  if (system.wide()) return looked_at(system, limits);
  return unconstrained(system) ? estimate_without_constraints(system)
                               : sampled(system, enough_actions);
}

namespace {

/// The estimated size of an H that does not fit in `allowed` bytes; empty where H fits. An estimate
/// by sampling may be `slack` times as large as what is allowed.
std::optional<GraphEstimate> too_large(const TransitionSystem& system, double allowed,
                                       double slack) {
  // How large it is shows when it is built: the memory limit stands behind it.
  if (system.wide()) return std::nullopt;
  // Constraints only take states away: where all subsets fit there is nothing to estimate.
  if (estimate_without_constraints(system).bytes <= allowed) return std::nullopt;
  const GraphEstimate estimate = estimate_graph(system);
  if (estimate.exact) slack = 1;
  if (estimate.bytes <= slack * allowed &&
      estimate.states <= slack * static_cast<double>(StateGraph::kMostStates))
    return std::nullopt;
  return estimate;
}

}  // namespace

bool graph_fits(const TransitionSystem& system, const Budget& budget) {
  return !too_large(system, static_cast<double>(allowed_bytes(budget)), 1);
}

std::optional<std::string> graph_obstacle(const TransitionSystem& system, const Budget& budget,
                                          double other_bytes) {
  const auto allowed = static_cast<double>(allowed_bytes(budget));
  // An estimate by sampling may be off by a factor of two or so; the memory limit stands behind it.
  const auto estimate = too_large(system, allowed, 2);
  if (!estimate) return std::nullopt;
  const std::string other =
      other_bytes == 0 ? "" : ", or " + bytes_text(other_bytes) + " for the values of all subsets,";
  return std::string("needs the whole state-action graph: ") + (estimate->exact ? "" : "about ") +
         size_text(estimate->states) + " states and " + size_text(estimate->actions) +
         " actions, " + bytes_text(estimate->bytes) + " of memory" + other + " where " +
         bytes_text(allowed) + " are allowed";
}

}  // namespace orasp
