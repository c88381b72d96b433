#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "orasp/model/problem.h"
#include "orasp/model/situation.h"
#include "orasp/model/transition_system.h"

namespace orasp::detail {

/// One rule that a plan breaks.
struct PlanFault {
  std::size_t step = 0;  ///< from 1; 0: the start, one more than there are: the end
  Constraint constraint = Constraint::NotOpen;
  ConnectionIndex connection = 0;  ///< of the step, or missing at the end
  std::size_t entry = 0;           ///< of ProblemSpec::precedence, where that is broken
  ConnectionIndex other = 0;       ///< the one that stands in the way, or is shut out
  std::size_t amount = 0;          ///< subassemblies, or parts that move
  double mass = 0;                 ///< kg that move
  PartIndex part = 0;              ///< of a subassembly without base part at the start
};

/// A direction that a plan states though the moved piece cannot leave in it.
struct PlanDirectionFault {
  std::size_t step = 0;  ///< from 1
  ConnectionIndex connection = 0;
  DirectionIndex direction = 0;
  PartIndex part = 0;  ///< of the moved piece
  PartIndex by = 0;    ///< what stands in its way
};

/// A plan replayed: every broken rule, ascending by step, and what the steps earn.
struct PlanReplay {
  std::vector<PlanFault> faults;
  std::vector<PlanDirectionFault> direction_faults;  ///< ascending by step
  std::vector<Step> steps;  ///< those that could be made, where they were asked for
  double reward = 0;
  /// Of each step that could be made, in the order of the plan; empty where steps take parts.
  std::vector<double> rewards;
  double tolerance = 0;  ///< see PlanCheck
  /// Whether it was judged that late steps come when nothing else can be done. That is left out
  /// where a legal step may shut something out, since then it takes a search.
  bool late_judged = true;
};

/// Replays a plan.
/// Problem.   To judge a plan without anything that planners use: connectivity, constraints, moved
///            piece, masses and rewards are worked out from the data of the problem.
/// Idea.      Seen from its end, a disassembly puts the product together; an assembly does so
///            anyway. In that order pieces only merge. Each part carries the name of its piece and
///            is renamed when it is in the smaller one of two that merge, so it is renamed at most
///            log2(parts) times. Masses, positions and numbers of parts are added up as pieces
///            merge. What is there in a state is read off the times at which connections are
///            handled.
/// Reference. Aho, Hopcroft and Ullman (1974), The Design and Analysis of Computer Algorithms,
///            section 4.6: merge the smaller into the larger.
/// Guarantee. Every step that can be made (its connection exists, is open and accessible) is
///            judged, in the state that the steps before it leave, legal or not.
/// Direction. `directions` is empty or has the direction that the plan states for each step, if
///            any; each of them is looked up in the blockers of the moved piece. It means nothing
///            where the step moves nothing or the problem has no blocking.
/// Blame.     A rule of precedence is broken by the step after which it can no longer be kept, not
///            by the one that finds it broken: in an assembly by what is made too early. Which
///            step that is is looked for only in a plan that breaks one.
/// Cost.      O((parts + connections) log parts + size of precedence), and the blockers of a part
///            once for each time that it is renamed. With steps asked for, or for an objective that
///            is a function of the whole Step, O(parts + directions) for each step more. A late
///            step, while others are open: O(parts + connections) for each of them, at worst.
/// Errors.    @throws InputError where an expression or a callable yields a reward that is not
///            finite, an expression cannot be compiled, the objective is one of
///            fleets, the situation is over other connections, or there are directions for another
///            number of steps.
///
/// Where there is more to steps (TransitionSystem::wide), PlanSteps say what each takes and in
/// which direction the moved piece leaves. Where an objective looks at directions and none is
/// stated they are chosen so that the steps earn most.
[[nodiscard]] PlanReplay replay(const Problem& problem, const Situation& situation,
                                std::span<const ConnectionIndex> sequence, bool with_steps,
                                std::span<const std::optional<DirectionIndex>> directions = {});
[[nodiscard]] PlanReplay replay(const Problem& problem, const Situation& situation,
                                std::span<const PlanStep> steps, bool with_steps);
/// The same with steps that list only the parts that move, so that all lists together hold at most
/// parts * log2(parts) of them where nothing is fixed. The other side of each step is empty. Where
/// there is more to steps, or the objective looks at whole steps or back, nothing is left out.
[[nodiscard]] PlanReplay replay_moves(const Problem& problem, const Situation& situation,
                                      std::span<const ConnectionIndex> sequence);

}  // namespace orasp::detail
