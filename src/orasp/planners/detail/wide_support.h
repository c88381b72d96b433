#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "orasp/containers/state_table.h"
#include "orasp/model/detail/listing.h"
#include "orasp/model/detail/rules.h"
#include "orasp/model/transition_system.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/detail/listing_watch.h"
#include "orasp/task/result.h"

/// What the searches of wide_search.h share.
namespace orasp::detail {

using Words = std::vector<std::uint64_t>;

/// Sets the plan of a result to that which goes through these states. Their steps were listed
/// before and are listed to the end, although time may be over by now.
inline void take_states(const TransitionSystem& system, const Words& states, Result& result) {
  const ListingScope as_before(system, {.most = system.rules().listing.most});
  take_walk(Expander(system).steps_along(states), result);
  result.status = Status::Feasible;
}

inline void take_plan(const Result& from, Result& to) {
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
inline std::span<const Action> listed(Expander& expander, SetView state, const ListingWatch& watch,
                                      Stop& stop) {
  try {
    return expander.legal_actions(state);
  } catch (const ListingStopped& stopped) {
    stop = watch.reason(stopped);
    return {};
  }
}

inline double rounding_of(const TransitionSystem& system, double running) {
  return 1e-15 * static_cast<double>(system.num_connections()) * std::max(1.0, std::abs(running));
}

/// Whether plans can be looked for backwards: where steps put parts on and look at nothing that was
/// done before.
[[nodiscard]] inline bool turns_round(const TransitionSystem& system) {
  return system.rules().by_part && !system.takes_apart() && !system.ordered() &&
         !system.looks_back();
}

/// Whether the start has more steps than can be gone through again and again.
[[nodiscard]] bool has_many_moves(const TransitionSystem& system);

}  // namespace orasp::detail
