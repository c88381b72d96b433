#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

/// The searches of planners/ where states and steps are wide (TransitionSystem::wide): the same
/// methods, on states that are words of which only some say what is open, along steps that lead
/// where Expander::successor says, to plans of any length. Each is chosen by the method of the same
/// name; what it promises stands there.
namespace orasp::detail {

/// A clause that says why bounds know nothing here; empty where they do.
[[nodiscard]] std::optional<std::string> wide_bound_obstacle(const TransitionSystem& system);

/// Best first. @throws Refusal with wide_bound_obstacle().
[[nodiscard]] Result wide_a_star(const TransitionSystem& system, const Budget& budget);

/// Depth first, best promise first, cut off by the bound and by states met before with no less.
/// @throws Refusal with wide_bound_obstacle().
[[nodiscard]] Result wide_depth_first(const TransitionSystem& system, std::uint64_t seed,
                                      const Budget& budget);

/// In passes of growing width over layers by open connections, until nothing was cut off.
/// `incumbent`: a plan to improve on; null: none. @throws Refusal with wide_bound_obstacle().
[[nodiscard]] Result wide_beam(const TransitionSystem& system, const Result* incumbent,
                               const Budget& budget);

/// Every sequence.
[[nodiscard]] Result wide_exhaustive(const TransitionSystem& system, const Budget& budget);

/// Some plan, depth first with a memory of states that lead nowhere: the action first that earns
/// most; actions in a random order; the action first that earns most together with what the bound
/// leaves after it (as wide_greedy where none is known). Complete: "infeasible" is proved.
[[nodiscard]] Result wide_greedy(const TransitionSystem& system, const Budget& budget);
[[nodiscard]] Result wide_random(const TransitionSystem& system, std::uint64_t seed,
                                 const Budget& budget);
[[nodiscard]] Result wide_guided_greedy(const TransitionSystem& system, const Budget& budget);

/// The same, where `rest(state)` says what is expected of the state that a step leads to. `method`:
/// that of the result.
[[nodiscard]] Result wide_plan_by(const TransitionSystem& system, std::string_view method,
                                  const std::function<double(SetView)>& rest, const Budget& budget);

/// A plan where steps take parts off or put them on and there may be exponentially many in a state:
/// by steps of one part or onto one piece where that goes, then of some more, each the one that
/// earns most. No plan: none was found soon. O(parts) states, each listed in O(parts * connections)
/// where single parts do.
[[nodiscard]] Result plan_of_few_moves(const TransitionSystem& system, const Budget& budget);

/// A plan of system.backwards() as one of `system`, by the steps that each of them takes there. No
/// plan: it is none there, or earns something else.
[[nodiscard]] Result turned_round(const TransitionSystem& system, Result result);

/// What auto does.
[[nodiscard]] Result wide_automatic(const TransitionSystem& system, const Budget& budget);

}  // namespace orasp::detail
