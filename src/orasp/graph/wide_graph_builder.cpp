#include "orasp/graph/wide_graph_builder.h"

#include <algorithm>
#include <span>
#include <vector>

#include "orasp/containers/state_table.h"
#include "orasp/task/detail/listing_watch.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

StateGraph WideGraphBuilder::build(std::uint64_t most_states) {
  constexpr std::size_t kPollEvery = 1024;
  const std::size_t words = system_.words();
  const std::size_t steps = system_.num_steps();
  const std::uint64_t allowed = allowed_bytes(budget_);
  StateGraph graph(system_);
  Expander expander(system_);
  detail::StateTable<0> table(words);
  detail::GrowingArray<std::uint64_t> first_action;  // by state, in the order of the table
  detail::GrowingArray<StateId> successors;
  detail::GrowingArray<std::uint16_t> connections;
  detail::GrowingArray<double> rewards;
  detail::GrowingArray<std::uint32_t> actions_of;
  std::vector<std::vector<StateId>> open_states(steps + 1);  // by open connections

  const auto meet = [&](const std::uint64_t* key) {
    const auto [number, is_new] = table.insert(key);
    if (is_new) {
      const SetView open = system_.open({key, words});
      open_states[count(open)].push_back(number);
      first_action.push_back(0);
      actions_of.push_back(0);
    }
    return number;
  };
  meet(system_.start_state().data());
  std::vector<std::uint64_t> key(words);
  std::vector<std::uint64_t> next(words);
  std::size_t expanded = 0;
  const detail::ListingWatch watch(system_, budget_);
  Stop stop = budget_.expired();
  for (std::size_t left = steps; left > 0 && stop == Stop::None; --left) {
    for (std::size_t i = 0; i < open_states[left].size() && stop == Stop::None; ++i) {
      const StateId state = open_states[left][i];
      std::copy_n(table.key(state), words, key.begin());
      std::span<const Action> legal;
      try {
        legal = expander.legal_actions(key);
      } catch (const detail::ListingStopped& stopped) {
        stop = watch.reason(stopped);
        break;
      }
      first_action[state] = successors.size();
      actions_of[state] = static_cast<std::uint32_t>(legal.size());
      for (const Action& action : legal) {
        expander.successor(key, action, next);
        if (form_) form_->canonical_but_for(action.connection, next);
        successors.push_back(meet(next.data()));
        connections.push_back(static_cast<std::uint16_t>(action.connection));
        rewards.push_back(action.reward);
      }
      if (++expanded % kPollEvery != 0) continue;
      const std::uint64_t bytes = table.bytes() + first_action.bytes() + actions_of.bytes() +
                                  2 * (successors.bytes() + connections.bytes() + rewards.bytes());
      graph.peak_bytes_ = std::max(graph.peak_bytes_, bytes);
      stop = bytes > allowed ? Stop::MemoryLimit : budget_.expired(bytes);
      if (table.size() > most_states) stop = Stop::ExpansionLimit;
      budget_.report(
          {.phase = "building H", .done = steps - left, .total = steps, .states = table.size()});
    }
  }
  if (table.size() > most_states) stop = Stop::ExpansionLimit;
  graph.stop_ = stop;
  if (stop != Stop::None) {
    // The start alone, without actions.
    for (const std::uint64_t word : system_.start_state()) graph.states_.push_back(word);
    graph.row_begin_.push_back(0);
    graph.row_begin_.push_back(0);
    graph.layer_begin_ = {0, 1};
    return graph;
  }

  // States with more open connections first.
  std::vector<StateId> order;
  std::vector<StateId> number(table.size());
  graph.layer_begin_.clear();
  for (std::size_t left = steps + 1; left-- > 0;) {
    graph.layer_begin_.push_back(static_cast<StateId>(order.size()));
    for (const StateId state : open_states[left]) {
      number[state] = static_cast<StateId>(order.size());
      order.push_back(state);
    }
  }
  graph.layer_begin_.push_back(static_cast<StateId>(order.size()));
  // Where steps are not wide, layers that no path reaches are none.
  while (!system_.wide() && graph.num_layers() > 1 &&
         graph.layer_begin(graph.num_layers() - 1) == graph.num_states())
    graph.layer_begin_.pop_back();
  graph.goal_reached_ = !open_states[0].empty();
  const bool narrow = system_.num_connections() <= 256;
  graph.row_begin_.push_back(0);
  detail::ValueNumbers values;
  std::vector<std::uint32_t> numbers;
  std::vector<double> in_order;
  for (const StateId state : order) {
    for (std::size_t w = 0; w < words; ++w) graph.states_.push_back(table.key(state)[w]);
    const std::uint64_t begin = first_action[state];
    for (std::uint64_t a = begin; a < begin + actions_of[state]; ++a) {
      graph.successors_.push_back(number[successors[a]]);
      if (narrow) {
        graph.narrow_connections_.push_back(static_cast<std::uint8_t>(connections[a]));
      } else {
        graph.wide_connections_.push_back(connections[a]);
      }
      numbers.push_back(values.number(rewards[a]));
      in_order.push_back(rewards[a]);
    }
    graph.row_begin_.push_back(graph.successors_.size());
  }
  const std::vector<std::uint32_t> admitted = graph.rewards_.admit(values.values());
  graph.rewards_.extend(in_order.size());
  for (std::size_t a = 0; a < in_order.size(); ++a) {
    if (graph.rewards_.numbered()) {
      graph.rewards_.set_number(a, admitted[numbers[a]]);
    } else {
      graph.rewards_.set_value(a, in_order[a]);
    }
  }
  graph.rewards_.shrink_to_fit();
  graph.peak_bytes_ = std::max(graph.peak_bytes_, graph.bytes() + table.bytes());
  return graph;
}

}  // namespace orasp
