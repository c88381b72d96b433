#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "orasp/graph/state_graph.h"
#include "orasp/model/transition_system.h"
#include "orasp/symmetry/symmetry.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// Runs a method on H up to symmetry (symmetry/symmetry.h, graph/wide_graph_builder.h), which holds
/// one state for all that are exchanged for one another, and brings its plan back to the product.
///
/// Guarantee.  As that of the method: from states that stand for one another the same is still to
///             be earned. `plan` must give a plan of the graph that it is handed where its status
///             is Optimal. Result::values is empty, since the states of that graph are not those of
///             H.
/// Cost.       An expansion and a form for each state that is held, on one thread.
/// @returns nothing where symmetry is not used: it is off, there is none, or, with Auto, H is
/// small, not `least` times smaller up to symmetry, or not thought to fit even so.
/// @throws Refusal of `method` where it was asked for and nothing is known of it.
[[nodiscard]] std::optional<Result> on_symmetric_graph(
    const TransitionSystem& system, SymmetryUse use, double least, const Budget& budget,
    std::string_view method, const std::function<Result(const StateGraph&)>& plan);

/// Why a method that builds H does not take the problem with that symmetry: what was asked for
/// cannot be had, or H is estimated not to fit, even up to symmetry. A clause that goes on from the
/// method's name; empty where it takes it. `without` is the reason why it does not take it without
/// symmetry.
[[nodiscard]] std::optional<std::string> symmetric_graph_obstacle(
    const TransitionSystem& system, SymmetryUse use, double least, const Budget& budget,
    std::optional<std::string> without);

/// Methods that build H do so up to symmetry by themselves where it is so many times smaller then.
inline constexpr double kLeastSymmetryForGraph = 8;
/// The same where the alternative is a table of all subsets, which is quicker than H.
inline constexpr double kLeastSymmetryForTable = 100;

}  // namespace orasp
