#include "orasp/execution/replanner.h"

#include <algorithm>
#include <span>
#include <utility>

#include "orasp/execution/waiting.h"
#include "orasp/graph/graph_estimate.h"
#include "orasp/graph/state_graph.h"
#include "orasp/graph/state_index.h"
#include "orasp/model/tolerance.h"
#include "orasp/model/transition_system.h"
#include "orasp/planners/automatic.h"
#include "orasp/planners/planner_support.h"
#include "orasp/planners/uncertain_value_iteration.h"
#include "orasp/planners/value_iteration.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {
constexpr std::size_t kMostHeld = 4;
/// Expansions to find what waits for lost parts.
constexpr std::uint64_t kMostForWaiting = 200'000;
constexpr std::string_view kMethod = "replanner";

bool same_limits(const Limits& a, const Limits& b) {
  return a.max_subassemblies == b.max_subassemblies && a.max_moved_parts == b.max_moved_parts &&
         a.max_moved_mass == b.max_moved_mass && a.grounded == b.grounded;
}

}  // namespace

/// A problem under one choice of limits and, where it fits, H with every state's best reward still
/// to come.
struct Replanner::Held {
  Problem problem;
  Situation origin;
  TransitionSystem system;
  Expander expander;
  std::optional<StateGraph> graph;
  std::optional<StateIndex> index;
  std::vector<double> values;
  double seconds = 0;

  // The scratch memory of a query. The states that it has reached, layer by layer; where the layers
  // begin; and the best reward still to come from each state reached.
  std::vector<StateId> reached;
  std::vector<std::size_t> layers;
  std::vector<double> left;
  // By StateId: the last query that reached the state, and its place in `reached`.
  std::vector<std::uint32_t> query_of;
  std::vector<std::uint32_t> place_of;
  std::uint32_t query = 0;

  Held(Problem the_problem, const Situation& from_here)
      : problem(std::move(the_problem)),
        origin(from_here),
        system(problem, origin),
        expander(system) {}

  void build(const ReplannerOptions& options, const Budget& budget) {
    const Stopwatch watch;
    if (!problem.uncertain() && !system.wide() && !system.infeasibility() &&
        fits(options, budget)) {
      graph.emplace(StateGraph::build(system, budget));
      measure(budget);
    }
    seconds = watch.seconds();
  }

  /// Takes over the H of `other` and gives it the rewards of this problem. Where that is not
  /// possible, returns false and leaves `other` as it was.
  bool take_over(Held& other, const Budget& budget) {
    const Stopwatch watch;
    if (!other.graph || system.infeasibility() ||
        other.graph->reweigh(system, budget) != StateGraph::Reweighed::Done)
      return false;
    graph = std::move(other.graph);
    other.graph.reset();
    measure(budget);
    seconds = watch.seconds();
    return true;
  }

  [[nodiscard]] bool fits(const ReplannerOptions& options, const Budget& budget) const {
    const auto allowed = static_cast<double>(allowed_bytes(budget));
    const auto small = [&](const GraphEstimate& estimate) {
      return estimate.actions <= options.most_actions && estimate.bytes <= allowed;
    };
    return small(estimate_without_constraints(system)) || small(estimate_graph(system));
  }

  /// Works out the values and the index of the graph; where the budget does not suffice, the graph
  /// is given up.
  void measure(const Budget& budget) {
    if (graph->stop() == Stop::None) {
      Result result = value_iteration(*graph, {}, budget);
      if (result.stop == Stop::None) {
        values = std::move(result.values);
        index.emplace(*graph);
        query_of.assign(graph->num_states(), 0);
        place_of.resize(graph->num_states());
        return;
      }
    }
    graph.reset();
  }

  /// Answers where everything that is open is accessible and in time: the values of H are then
  /// right.
  void read_off(StateId from, const ConnectionSet& not_next, Result& result) const {
    StateId state = from;
    double total = 0;
    while (graph->begin(state) < graph->end(state)) {
      double best = -kInfinity;
      ActionId chosen = graph->end(state);
      for (ActionId a = graph->begin(state); a < graph->end(state); ++a) {
        const double value = graph->reward(a) + values[graph->successor(a)];
        if (value <= best || (state == from && not_next.contains(graph->connection(a)))) continue;
        best = value;
        chosen = a;
      }
      if (chosen == graph->end(state)) return;
      result.sequence.push_back(graph->connection(chosen));
      total += graph->reward(chosen);
      state = graph->successor(chosen);
    }
    if (graph->goal() != state) return;
    result.reward = total;
    result.status = Status::Optimal;
  }

  /// Calls visit(action, whether it reaches the goal) for the actions of `state` that `now` allows.
  template <class Visit>
  void for_each_allowed(StateId state, bool first, bool last, const Situation& now,
                        Visit&& visit) const {
    const auto allowed = [&](ActionId a) {
      const ConnectionIndex c = graph->connection(a);
      return !now.inaccessible.contains(c) && !(first && now.not_next.contains(c));
    };
    bool waits = false;  // late ones, for another
    if (!now.late.empty()) {
      for (ActionId a = graph->begin(state); a < graph->end(state) && !waits; ++a)
        waits = allowed(a) && !now.late.contains(graph->connection(a));
    }
    for (ActionId a = graph->begin(state); a < graph->end(state); ++a) {
      if (allowed(a) && !(waits && now.late.contains(graph->connection(a)))) visit(a, last);
    }
  }

  [[nodiscard]] double reward_of(StateId state, ActionId action, bool last, bool partly) {
    if (!last || !partly) return graph->reward(action);
    return expander.completing_reward(graph->state(state), graph->connection(action));
  }

  /// The part of H that can be reached, forwards, and its values, backwards. `steps` to the goal.
  void go_through(StateId from, const Situation& now, std::size_t steps, Result& result) {
    const bool partly = !now.inaccessible.empty();
    if (++query == 0) {
      std::ranges::fill(query_of, 0U);
      query = 1;
    }
    reached.assign(1, from);
    layers.assign(1, 0);
    query_of[from] = query;
    place_of[from] = 0;
    for (std::size_t k = 0; k < steps; ++k) {
      const std::size_t begin = layers.back();
      const std::size_t end = reached.size();
      layers.push_back(end);
      for (std::size_t i = begin; i < end; ++i) {
        for_each_allowed(reached[i], k == 0, false, now, [&](ActionId a, bool) {
          const StateId next = graph->successor(a);
          if (query_of[next] == query) return;
          query_of[next] = query;
          place_of[next] = static_cast<std::uint32_t>(reached.size());
          reached.push_back(next);
        });
      }
      result.statistics.expanded += end - begin;
    }
    left.assign(reached.size(), 0);
    const auto best_of = [&](std::size_t i, std::size_t k, ActionId& chosen) {
      double best = -kInfinity;
      const bool last = k + 1 == steps;
      for_each_allowed(reached[i], k == 0, last, now, [&](ActionId a, bool completes) {
        const double value =
            reward_of(reached[i], a, completes, partly) + left[place_of[graph->successor(a)]];
        if (value <= best) return;
        best = value;
        chosen = a;
      });
      return best;
    };
    ActionId chosen = 0;
    for (std::size_t k = steps; k-- > 0;) {
      for (std::size_t i = layers[k]; i < layers[k + 1]; ++i) left[i] = best_of(i, k, chosen);
    }
    result.statistics.states = reached.size();
    if (left.front() == -kInfinity) return;
    double total = 0;
    std::size_t i = 0;
    for (std::size_t k = 0; k < steps; ++k) {
      static_cast<void>(best_of(i, k, chosen));
      result.sequence.push_back(graph->connection(chosen));
      total += reward_of(reached[i], chosen, k + 1 == steps, partly);
      i = place_of[graph->successor(chosen)];
    }
    result.reward = total;
    result.status = Status::Optimal;
  }
};

Replanner::Replanner(const Problem& problem, const ReplannerOptions& options, const Budget& budget)
    : options_(options),
      open_(ConnectionSet::all(problem.num_connections())),
      inaccessible_(problem.num_connections()),
      not_next_(problem.num_connections()) {
  held_.push_back(std::make_unique<Held>(problem, Situation::whole(problem.num_connections())));
  held_.front()->build(options_, budget);
}
Replanner::~Replanner() = default;
Replanner::Replanner(Replanner&&) noexcept = default;
Replanner& Replanner::operator=(Replanner&&) noexcept = default;

const Problem& Replanner::problem() const {
  return held_.front()->problem;
}

Situation Replanner::situation() const {
  const Problem& now = problem();
  Situation situation{open_, inaccessible_, not_next_, ConnectionSet(now.num_connections()), {},
                      {}};
  if (held_.front()->system.looks_back()) {
    situation.in_force = in_force_;
    situation.last_place = last_place_;
  }
  if (lost_.empty() && late_.empty()) return situation;
  ConnectionSet missing(now.num_connections());
  for (ConnectionIndex c = 0; c < now.num_connections(); ++c) {
    for (const PartIndex part : now.ends(c)) {
      if (lost_.contains(part)) missing.insert(c);
      if (late_.contains(part)) situation.late.insert(c);
    }
  }
  if (missing.empty()) return situation;
  Budget budget;
  budget.max_expansions = kMostForWaiting;
  const ConnectionSet waiting = waiting_for(now, situation, missing, budget).connections;
  for_each_connection(waiting.view(), [&](ConnectionIndex c) { situation.inaccessible.insert(c); });
  return situation;
}

Situation Replanner::situation_of_steps() const {
  Situation now = Situation::whole(open_.universe());
  now.in_force = in_force_;
  now.last_place = last_place_;
  return now;
}

void Replanner::set_done(ConnectionIndex connection, bool done) {
  if (done) {
    // The direction in which a piece left is known from the plan.
    PlanStep step{{connection}, std::nullopt};
    const auto planned = std::ranges::find_if(planned_, [&](const PlanStep& one) {
      return std::ranges::find(one.connections, connection) != one.connections.end();
    });
    if (planned != planned_.end()) step.direction = planned->direction;
    Situation before = situation_of_steps();
    note_done(problem(), step, before);
    in_force_ = std::move(before.in_force);
    last_place_ = before.last_place;
    open_.erase(connection);
    not_next_ = ConnectionSet(open_.universe());
  } else {
    open_.insert(connection);
  }
}

void Replanner::set_accessible(ConnectionIndex connection, bool accessible) {
  accessible ? inaccessible_.erase(connection) : inaccessible_.insert(connection);
}

void Replanner::set_possible_next(ConnectionIndex connection, bool possible) {
  possible ? not_next_.erase(connection) : not_next_.insert(connection);
}

void Replanner::set_lost(PartIndex part, bool lost) {
  if (lost) {
    lost_.insert(part);
  } else {
    lost_.erase(part);
  }
}

void Replanner::set_late(PartIndex part, bool late) {
  if (late) {
    late_.insert(part);
  } else {
    late_.erase(part);
  }
}

void Replanner::set_limits(const Limits& limits, const Budget& budget) {
  const auto found = std::ranges::find_if(held_, [&](const std::unique_ptr<Held>& held) {
    return same_limits(held->problem.limits(), limits);
  });
  if (found != held_.end()) {
    std::rotate(held_.begin(), found, found + 1);
    return;
  }
  Situation from = Situation::whole(problem().num_connections());
  from.open = open_;
  auto held = std::make_unique<Held>(problem().with_limits(limits), from);
  held->build(options_, budget);
  held_.insert(held_.begin(), std::move(held));
  if (held_.size() > kMostHeld) held_.pop_back();
}

bool Replanner::reweigh(const Problem& problem, const Budget& budget) {
  const Problem& now = this->problem();
  const auto same_ids = [](const auto& a, const auto& b) {
    return std::ranges::equal(
        a, b, {}, [](const auto& x) { return x.id; }, [](const auto& x) { return x.id; });
  };
  const auto same_ends = [&] {
    for (ConnectionIndex c = 0; c < now.num_connections(); ++c) {
      if (now.ends(c) != problem.ends(c)) return false;
    }
    return true;
  };
  if (!same_ids(now.parts(), problem.parts()) ||
      !same_ids(now.connections(), problem.connections()) || !same_ends()) {
    throw InputError(
        "reweighing: the parts and connections must be those of the problem at hand, in the same "
        "order");
  }
  auto held = std::make_unique<Held>(problem, held_.front()->origin);
  const bool replaced = held->take_over(*held_.front(), budget);
  if (!replaced) held->build(options_, budget);
  held_.clear();
  held_.push_back(std::move(held));
  return replaced;
}

Result Replanner::plan(const Budget& budget) {
  const Stopwatch watch;
  Held& held = *held_.front();
  Situation now = situation();
  std::size_t steps = 0;
  ConnectionSet kept(open_.universe());
  for_each_connection(open_.view(), [&](ConnectionIndex c) {
    if (now.inaccessible.contains(c)) {
      kept.insert(c);
    } else {
      ++steps;
    }
  });
  now.inaccessible = kept;
  const auto from = held.graph ? held.index->find(open_.view()) : std::nullopt;
  const auto limit = held.problem.limits().max_subassemblies;
  const bool assembly = held.problem.direction() == Direction::Assembly;
  const bool ordered = !held.problem.precedence().empty();
  // What is late may come sooner where that alone leaves a way to the end.
  const bool may_be_sooner = !now.late.empty() && held.system.may_shut_out();
  if (!from || may_be_sooner || (assembly && (limit || ordered) && !kept.empty())) {
    // In assembly what is left out may leave the product itself in too many subassemblies, and what
    // had to be made before others need not be any more.
    const TransitionSystem left(held.problem, now);
    if (!from || ordered || may_be_sooner || left.infeasibility()) {
      Result result = held.problem.uncertain() ? uncertain_value_iteration(left, {}, budget)
                                               : automatic(left, 1, budget);
      planned_ = result.steps;
      result.statistics.seconds = watch.seconds();
      return result;
    }
  }
  Result result;
  result.method = kMethod;
  if (kept.empty() && now.late.empty()) {
    held.read_off(*from, now.not_next, result);
  } else {
    held.go_through(*from, now, steps, result);
  }
  if (result.status == Status::Optimal) {
    result.bound = result.reward;
  } else {
    const Statistics statistics = result.statistics;
    const auto reason = detail::infeasible_at_once(TransitionSystem(held.problem, now), kMethod);
    result = reason ? *reason : detail::exhausted(kMethod, statistics);
  }
  result.statistics.seconds = watch.seconds();
  return result;
}

bool Replanner::holds_graph() const {
  return held_.front()->graph.has_value();
}

std::uint64_t Replanner::held_states() const {
  return holds_graph() ? held_.front()->graph->num_states() : 0;
}

double Replanner::seconds_to_build() const {
  return held_.front()->seconds;
}

}  // namespace orasp
