#pragma once

#include <span>

#include "orasp/model/detail/plan_replay.h"

namespace orasp::detail {

/// Replays a plan whose steps take parts off, or put them on (StepKind::Part).
/// Problem.   As replay(): to judge a plan without anything that planners use.
/// Idea.      By definition, in the order of the disassembly (an assembly is turned round): before
///            each step all pieces are found by flood fill; the parts of the step's connections say
///            which piece falls apart; of the pieces that it leaves one must be what moves. Every
///            rule is then read off the two states and the pieces between them.
/// Guarantee. As replay(). A step that takes something that no step can take is a fault, and ends
///            the replay: what would come after it has no meaning.
/// Cost.      O(steps * (parts + connections + size of precedence and blocking)).
/// Errors.    As replay().
[[nodiscard]] PlanReplay replay_parts(const Problem& problem, const Situation& situation,
                                      std::span<const PlanStep> steps, bool with_steps);

}  // namespace orasp::detail
