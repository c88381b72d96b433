#include "orasp/planners/uncertain.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "orasp/model/random.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {

using State = UncertainGraph::State;
using Attempt = UncertainGraph::Attempt;
constexpr std::uint64_t kPollEvery = 256;  // states, or attempts of a simulation

/// The parts of Bellman's equation, once for all that use them. `self` is the attempt's own state.
class Outcomes {
 public:
  explicit Outcomes(const UncertainGraph& graph) : problem_(graph.system().problem()) {}

  [[nodiscard]] double success(const Attempt& attempt) const {
    return problem_.connections()[attempt.connection].success;
  }
  /// Whether each outcome leads to a state of which `is_safe` holds, or ends the job.
  [[nodiscard]] static bool safe(const Attempt& attempt, State self,
                                 const std::vector<double>& values) {
    const State failed = attempt.failed;
    return values[attempt.done] != -kInfinity &&
           (failed == UncertainGraph::kJobEnded || failed == self || values[failed] != -kInfinity);
  }
  /// What a failure is worth, given what it is worth to be in a state.
  [[nodiscard]] double failure(const Attempt& attempt, const std::vector<double>& values) const {
    if (attempt.failed == UncertainGraph::kJobEnded)
      return *problem_.connections()[attempt.connection].on_failure.abort;
    return attempt.reward + values[attempt.failed];
  }
  /// The plain Bellman operator.
  [[nodiscard]] double plain(const Attempt& attempt, const std::vector<double>& values) const {
    const double p = success(attempt);
    const double done = p * (attempt.reward + values[attempt.done]);
    return p == 1 ? done : done + (1 - p) * failure(attempt, values);
  }
  /// The same solved for the state's own value, where a failure leads back to it.
  [[nodiscard]] double solved(const Attempt& attempt, State self,
                              const std::vector<double>& values) const {
    if (attempt.failed == self) return attempt.reward / success(attempt) + values[attempt.done];
    return plain(attempt, values);
  }
  /// Expected attempts from `self` on, given those of the states after it.
  [[nodiscard]] double attempts(const Attempt& attempt, State self,
                                const std::vector<double>& after) const {
    const double p = success(attempt);
    if (attempt.failed == self) return 1 / p + after[attempt.done];
    const double rest = attempt.failed == UncertainGraph::kJobEnded ? 0 : after[attempt.failed];
    return 1 + p * after[attempt.done] + (1 - p) * rest;
  }

 private:
  const Problem& problem_;
};

/// The greatest of `worth(attempt)` over the safe attempts of a state, and where it stands.
template <class Worth>
std::pair<double, std::uint32_t> best_of(const UncertainGraph& graph, State s,
                                         const std::vector<double>& values, Worth&& worth) {
  double best = -kInfinity;
  std::uint32_t place = UncertainSolution::kNone;
  const std::span<const Attempt> attempts = graph.attempts(s);
  for (std::uint32_t i = 0; i < attempts.size(); ++i) {
    if (!Outcomes::safe(attempts[i], s, values)) continue;
    const double here = worth(attempts[i]);
    if (place != UncertainSolution::kNone && here <= best) continue;
    best = here;
    place = i;
  }
  return {best, place};
}

bool is_goal(const UncertainGraph& graph, State s) {
  return count(graph.state(s)) == 0;
}

/// Expected rewards and attempts under a choice, fewest open connections first.
void evaluate_choice(const UncertainGraph& graph, UncertainSolution& solution) {
  const Outcomes outcomes(graph);
  for (const State s : graph.last_first()) {
    const std::uint32_t place = solution.choice[s];
    if (place == UncertainSolution::kNone) continue;
    const Attempt& attempt = graph.attempts(s)[place];
    solution.values[s] = outcomes.solved(attempt, s, solution.values);
    solution.attempts[s] = outcomes.attempts(attempt, s, solution.attempts);
  }
}

/// How far V at the start may be from the optimum: see "Guarantee" in the header.
struct Accuracy {
  double residual = 0;
  double error = 0;
};
Accuracy accuracy_of(const UncertainGraph& graph, const std::vector<double>& values) {
  const Outcomes outcomes(graph);
  Accuracy accuracy;
  double largest = 0;  // number that the residual is worked out from
  std::vector<double> most_attempts(graph.num_states(), 0.0);
  for (const State s : graph.last_first()) {
    if (values[s] == -kInfinity || is_goal(graph, s)) continue;
    const auto [next, place] = best_of(graph, s, values, [&](const Attempt& attempt) {
      largest = std::max(largest, std::abs(attempt.reward));
      if (attempt.failed == UncertainGraph::kJobEnded)
        largest = std::max(largest, std::abs(outcomes.failure(attempt, values)));
      return outcomes.plain(attempt, values);
    });
    accuracy.residual = std::max(accuracy.residual, std::abs(next - values[s]));
    largest = std::max(largest, std::abs(values[s]));
    most_attempts[s] = best_of(graph, s, values, [&](const Attempt& attempt) {
                         return outcomes.attempts(attempt, s, most_attempts);
                       }).first;
  }
  // The operator sums and multiplies a handful of numbers, none above twice the largest.
  const double rounding = 16 * std::numeric_limits<double>::epsilon() * largest;
  if (most_attempts[0] > 0) accuracy.error = (accuracy.residual + rounding) * most_attempts[0];
  return accuracy;
}

/// The states that the policy can meet, but the goal: the start, then most open first.
std::vector<PolicyState> policy_of(const UncertainGraph& graph, const UncertainSolution& solution) {
  std::vector<bool> met(graph.num_states(), false);
  met[0] = true;
  std::vector<PolicyState> policy;
  const std::size_t connections = graph.system().num_connections();
  const auto& order = graph.last_first();
  for (auto s = order.rbegin(); s != order.rend(); ++s) {
    if (!met[*s] || solution.choice[*s] == UncertainSolution::kNone) continue;
    const Attempt& attempt = graph.attempts(*s)[solution.choice[*s]];
    policy.push_back({.open = ConnectionSet(connections, graph.state(*s)),
                      .next = attempt.connection,
                      .reward = solution.values[*s]});
    met[attempt.done] = true;
    if (attempt.failed != UncertainGraph::kJobEnded) met[attempt.failed] = true;
  }
  return policy;
}

/// The likeliest course under the choice. A failure that leaves the state as it is changes nothing:
/// the attempt is made again, and succeeds in the end. Of two that are equally likely, the one that
/// succeeds.
void find_most_likely(const UncertainGraph& graph, const UncertainSolution& solution,
                      Expectation& expectation) {
  const Outcomes outcomes(graph);
  struct Likelihood {
    double best = 1;
    bool succeeds = true;
  };
  std::vector<Likelihood> likelihoods(graph.num_states());
  for (const State s : graph.last_first()) {
    if (solution.choice[s] == UncertainSolution::kNone) continue;
    const Attempt& attempt = graph.attempts(s)[solution.choice[s]];
    const double p = attempt.failed == s ? 1 : outcomes.success(attempt);
    const double done = p * likelihoods[attempt.done].best;
    const double rest =
        attempt.failed == UncertainGraph::kJobEnded ? 1 : likelihoods[attempt.failed].best;
    const double failed = p == 1 ? 0 : (1 - p) * rest;
    likelihoods[s] = {.best = std::max(done, failed), .succeeds = done >= failed};
  }
  expectation.probability = likelihoods[0].best;
  for (State s = 0;
       s != UncertainGraph::kJobEnded && solution.choice[s] != UncertainSolution::kNone;) {
    const Attempt& attempt = graph.attempts(s)[solution.choice[s]];
    expectation.most_likely.push_back({attempt.connection, likelihoods[s].succeeds});
    s = likelihoods[s].succeeds ? attempt.done : attempt.failed;
  }
}

/// Iterates the plain operator on the states that have a value, V_{k+1} from V_k.
void sweep_textbook(const UncertainGraph& graph, const ValueIterationOptions& options,
                    const Budget& budget, std::vector<double>& values, Result& result) {
  const Outcomes outcomes(graph);
  for (State s = 0; s < graph.num_states(); ++s) {
    if (values[s] != -kInfinity && !is_goal(graph, s)) values[s] = options.initial_value;
  }
  std::vector<double> previous = values;
  std::uint64_t& sweeps = result.statistics.sweeps;
  bool changing = true;
  while (changing && sweeps < options.max_sweeps) {
    std::swap(values, previous);
    double change = 0;
    double largest = 0;
    for (State s = 0; s < graph.num_states(); ++s) {
      values[s] = previous[s];
      if (previous[s] == -kInfinity || is_goal(graph, s)) continue;
      values[s] = best_of(graph, s, previous, [&](const Attempt& attempt) {
                    return outcomes.plain(attempt, previous);
                  }).first;
      change = std::max(change, std::abs(values[s] - previous[s]));
      largest = std::max(largest, std::abs(values[s]));
    }
    ++sweeps;
    // Below the last bits of the values a change says nothing.
    changing =
        change >= options.epsilon && change > 2 * std::numeric_limits<double>::epsilon() * largest;
    budget.report({.phase = "sweep", .done = sweeps, .total = 0, .states = graph.num_states()});
    result.stop = budget.expired(result.statistics.peak_bytes);
    if (result.stop != Stop::None) break;
  }
}

/// The order in which the policy handles the connections where no failure changes the state.
std::vector<ConnectionIndex> sequence_of(const UncertainGraph& graph,
                                         const UncertainSolution& solution) {
  std::vector<ConnectionIndex> sequence;
  for (State s = 0; solution.choice[s] != UncertainSolution::kNone;) {
    const Attempt& attempt = graph.attempts(s)[solution.choice[s]];
    sequence.push_back(attempt.connection);
    s = attempt.done;
  }
  return sequence;
}

}  // namespace

std::uint64_t UncertainGraph::bytes() const {
  return states_.bytes() + attempts_.bytes() +
         states_.size() * (2 * sizeof(std::uint64_t) + sizeof(State) + 1);
}

UncertainGraph UncertainGraph::build(const TransitionSystem& system, const Budget& budget,
                                     const Guide& guide) {
  UncertainGraph graph(system);
  const Problem& problem = system.problem();
  const ConnectionSet start = system.start();
  Budget limited = budget;
  limited.max_bytes = allowed_bytes(budget);

  std::vector<std::vector<State>> by_open(start.size() + 1);
  const auto number_of = [&](const std::uint64_t* key, std::size_t open) {
    if (graph.states_.size() >= kJobEnded - 1)
      throw InputError("value-iteration: there are more than 2^32 - 2 states");
    const auto [number, is_new] = graph.states_.insert(key);
    if (is_new) {
      by_open[open].push_back(number);
      graph.row_begin_.push_back(0);
      graph.row_end_.push_back(0);
      graph.guided_.push_back(false);
    }
    return number;
  };
  static_cast<void>(number_of(start.view().data(), start.size()));

  Expander expander(system);
  std::vector<std::uint64_t> here(system.words());
  std::vector<std::uint64_t> next(system.words());
  const auto clear = [&next](ConnectionIndex c) {
    next[c / 64] &= ~(std::uint64_t{1} << (c % 64));
  };
  std::uint64_t expanded = 0;
  for (std::size_t open = start.size(); open > 0; --open) {
    for (const State s : by_open[open]) {
      if (expanded++ % kPollEvery == 0) {
        limited.report({.phase = "building the states",
                        .done = expanded,
                        .total = 0,
                        .states = graph.num_states()});
        graph.stop_ = limited.expired(graph.bytes(), expanded);
        if (graph.stop_ != Stop::None) return graph;
      }
      std::copy_n(graph.states_.key(s), here.size(), here.begin());
      std::span<const Action> actions = expander.legal_actions(here);
      if (guide && !actions.empty()) {
        if (const auto chosen = guide(here)) {
          const auto found = std::ranges::find(actions, *chosen, &Action::connection);
          if (found != actions.end()) {
            actions = actions.subspan(static_cast<std::size_t>(found - actions.begin()), 1);
            graph.guided_[s] = true;
          }
        }
      }
      graph.row_begin_[s] = graph.attempts_.size();
      for (const auto& [connection, reward] : actions) {
        Attempt attempt{.reward = reward, .connection = connection, .done = 0, .failed = s};
        next = here;
        clear(connection);
        attempt.done = number_of(next.data(), open - 1);
        const Connection& tried = problem.connections()[connection];
        if (tried.success < 1 && tried.on_failure.abort) attempt.failed = kJobEnded;
        if (tried.success < 1 && !problem.breaks(connection).empty()) {
          next = here;
          for (const ConnectionIndex broken : problem.breaks(connection)) clear(broken);
          const std::size_t left = count(next);
          if (left < open) attempt.failed = number_of(next.data(), left);
        }
        graph.attempts_.push_back(attempt);
      }
      graph.row_end_[s] = graph.attempts_.size();
    }
  }
  graph.stop_ = limited.expired(graph.bytes());
  graph.last_first_.reserve(graph.num_states());
  for (const std::vector<State>& layer : by_open)
    graph.last_first_.insert(graph.last_first_.end(), layer.rbegin(), layer.rend());
  return graph;
}

UncertainSolution solve_uncertain(const UncertainGraph& graph) {
  const Outcomes outcomes(graph);
  UncertainSolution solution;
  solution.values.assign(graph.num_states(), -kInfinity);
  solution.choice.assign(graph.num_states(), UncertainSolution::kNone);
  solution.attempts.assign(graph.num_states(), 0.0);
  for (const State s : graph.last_first()) {
    if (is_goal(graph, s)) {
      solution.values[s] = 0;
      continue;
    }
    std::tie(solution.values[s], solution.choice[s]) = best_of(
        graph, s, solution.values,
        [&](const Attempt& attempt) { return outcomes.solved(attempt, s, solution.values); });
    if (solution.choice[s] == UncertainSolution::kNone) continue;
    const Attempt& attempt = graph.attempts(s)[solution.choice[s]];
    solution.attempts[s] = outcomes.attempts(attempt, s, solution.attempts);
    if (!std::isfinite(solution.values[s]) || !std::isfinite(solution.attempts[s])) {
      throw InputError("connections[" + std::to_string(attempt.connection) +
                       "].success: so small that the expected reward is not a finite number");
    }
  }
  return solution;
}

Result uncertain_value_iteration(const UncertainGraph& graph, const ValueIterationOptions& options,
                                 const Budget& budget) {
  const Stopwatch watch;
  require_valid(options);
  Result result;
  result.method = "value-iteration";
  Statistics& statistics = result.statistics;
  statistics.states = graph.num_states();
  statistics.actions = graph.num_attempts();
  statistics.expanded = graph.num_states();
  statistics.generated = graph.num_attempts();
  statistics.peak_bytes = graph.bytes();
  if (graph.stop() != Stop::None) {
    result.stop = graph.stop();
    result.notes.emplace_back("stopped before all states were known that attempts lead to");
    return result;
  }

  UncertainSolution solution = solve_uncertain(graph);
  const bool textbook = options.order == ValueIterationOptions::Order::Textbook;
  const std::size_t numbers = textbook ? 4 : 3;
  statistics.peak_bytes += graph.num_states() * (numbers * sizeof(double) + sizeof(std::uint32_t));
  if (solution.values[0] == -kInfinity) {
    result = detail::exhausted(result.method, statistics);
    result.notes = {
        "no plan exists: whatever is attempted, a state may be met that has no legal step"};
    return result;
  }

  double bound = 0;
  if (textbook) {
    // What the sweeps find stands on its own: the choice is theirs, and is evaluated exactly.
    std::vector<double> values = solution.values;
    sweep_textbook(graph, options, budget, values, result);
    const Outcomes outcomes(graph);
    for (const State s : graph.last_first()) {
      if (values[s] == -kInfinity || is_goal(graph, s)) continue;
      solution.choice[s] = best_of(graph, s, values, [&](const Attempt& attempt) {
                             return outcomes.plain(attempt, values);
                           }).second;
    }
    evaluate_choice(graph, solution);
    const Accuracy accuracy = accuracy_of(graph, values);
    result.expectation =
        Expectation{solution.attempts[0], accuracy.residual, accuracy.error, {}, 1, {}};
    bound = std::max(values[0] + accuracy.error, solution.values[0]);
  } else {
    statistics.sweeps = 1;
    const Accuracy accuracy = accuracy_of(graph, solution.values);
    result.expectation =
        Expectation{solution.attempts[0], accuracy.residual, accuracy.error, {}, 1, {}};
    bound = solution.values[0];
  }
  result.reward = solution.values[0];
  result.sequence = sequence_of(graph, solution);
  find_most_likely(graph, solution, *result.expectation);
  result.expectation->policy = policy_of(graph, solution);
  detail::judge_by(bound, result);
  if (result.status != Status::Optimal) {
    result.notes.push_back("stopped after " + std::to_string(statistics.sweeps) +
                           " sweeps, before the values were final: the policy is not proved best");
  }
  statistics.seconds = watch.seconds();
  return result;
}

Result uncertain_value_iteration(const TransitionSystem& system,
                                 const ValueIterationOptions& options, const Budget& budget) {
  const Stopwatch watch;
  if (auto result = detail::settled(system, "value-iteration")) return *result;
  Result result = uncertain_value_iteration(UncertainGraph::build(system, budget), options, budget);
  result.statistics.seconds = watch.seconds();
  return result;
}

UncertainGraph::Guide guide_by_plan(std::span<const ConnectionIndex> sequence) {
  return [plan = std::vector(sequence.begin(), sequence.end())](
             SetView open) -> std::optional<ConnectionIndex> {
    const auto next =
        std::ranges::find_if(plan, [open](ConnectionIndex c) { return contains(open, c); });
    if (next == plan.end()) return std::nullopt;
    return *next;
  };
}

UncertainGraph::Guide guide_by_policy(const TransitionSystem& system,
                                      std::span<const PolicyState> policy) {
  struct Entries {
    explicit Entries(const TransitionSystem& rules) : system(rules), expander(rules) {}
    const TransitionSystem& system;
    Expander expander;
    std::unordered_map<ConnectionSet, ConnectionIndex> next;
  };
  auto entries = std::make_shared<Entries>(system);
  for (const PolicyState& state : policy) entries->next.emplace(state.open, state.next);
  return [entries](SetView open) -> std::optional<ConnectionIndex> {
    const Problem& problem = entries->system.problem();
    const auto found = entries->next.find(ConnectionSet(entries->system.num_connections(), open));
    if (found == entries->next.end()) {
      throw InputError("the policy says nothing for a state that it leads to, with " +
                       std::to_string(count(open)) + " connections still open");
    }
    if (!entries->expander.legal(open, found->second)) {
      throw InputError("the policy attempts connection \"" + problem.connection_id(found->second) +
                       "\" where that is not legal, with " + std::to_string(count(open)) +
                       " connections still open");
    }
    return found->second;
  };
}

Simulation simulate(const UncertainGraph& graph, std::span<const std::uint32_t> choice,
                    std::span<const ConnectionIndex> plan, const SimulationOptions& options,
                    const Budget& budget) {
  const Problem& problem = graph.system().problem();
  const std::size_t connections = graph.system().num_connections();
  Simulation simulation;
  SplitMix64 seeds(options.seed);
  std::uint64_t polled = 0;
  for (std::uint64_t run = 0; run < options.runs; ++run) {
    SplitMix64 random(seeds.next());
    double reward = 0;
    std::uint64_t attempts = 0;
    std::uint64_t replanned = 0;
    bool aborted = false;
    std::size_t place = 0;  // in the plan: all before it is handled or has come off
    ConnectionSet came_off(connections);
    State s = 0;
    bool arrived = true;  // in a state that is new to this run
    while (choice[s] != UncertainSolution::kNone) {
      if (polled++ % kPollEvery == 0) {
        budget.report({.phase = "runs", .done = run, .total = options.runs});
        simulation.stop = budget.expired();
        if (simulation.stop != Stop::None) return simulation;
      }
      if (arrived && !plan.empty()) {
        bool interrupted = !graph.guided(s);
        for (; place < plan.size() && !contains(graph.state(s), plan[place]); ++place)
          interrupted = interrupted || came_off.contains(plan[place]);
        if (interrupted) ++replanned;
      }
      const Attempt& attempt = graph.attempts(s)[choice[s]];
      const Connection& tried = problem.connections()[attempt.connection];
      ++attempts;
      const bool succeeds = tried.success == 1 || random.uniform() < tried.success;
      if (!succeeds && attempt.failed == UncertainGraph::kJobEnded) {
        reward += *tried.on_failure.abort;
        aborted = true;
        break;
      }
      reward += attempt.reward;
      const State next = succeeds ? attempt.done : attempt.failed;
      arrived = next != s;
      if (!succeeds && arrived) {
        for (const ConnectionIndex c : problem.breaks(attempt.connection)) {
          if (contains(graph.state(s), c)) came_off.insert(c);
        }
      }
      s = next;
    }
    simulation.rewards.push_back(reward);
    simulation.attempts.push_back(attempts);
    simulation.replanned += replanned;
    if (aborted) ++simulation.aborted;
  }
  return simulation;
}

}  // namespace orasp
