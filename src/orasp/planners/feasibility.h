#pragma once

#include <cstdint>
#include <vector>

#include "orasp/model/connection_set.h"
#include "orasp/model/problem.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// Whether connections can be removed, and in which order.
struct Feasibility {
  /// Feasible, Infeasible (which is then proved) or Unknown.
  Status status = Status::Unknown;
  /// Why the answer is unknown.
  Stop stop = Stop::None;
  /// A legal order of disassembly; empty unless feasible.
  std::vector<ConnectionIndex> order = {};
  /// The same step by step, where there is more to steps (TransitionSystem::wide).
  std::vector<PlanStep> steps = {};
  /// How many states were looked at.
  std::uint64_t expanded = 0;
};

/// Looks for any legal order in which to take the connections `from` down to `to`, a subset, in
/// disassembly order whatever the problem's direction (a legal assembly order is one of these
/// backwards). In disassembly `to` is what stays; in assembly it is what is made already, and what
/// is not in `from` is given up. Rewards do not matter.
///
/// Idea.       Depth first with a table of failed states, and few branches: a cut that can do no
///             harm is made at once and nothing else is tried in that state. A legal removal of c
///             that cuts a piece is harmless unless a limit grows worse with more cuts. Proof: let
///             p be any legal order from here, and make c first. c is in no cycle, so every other
///             connection separates exactly when it did in p, and its piece is the one of p or a
///             part of it, cut into parts of p's A and B. Precedence only asks for absence. Parts
///             that were free of each other stay so, and the smaller side stays as small; with
///             equal masses it stays as light. Only the number of subassemblies may grow, and not
///             if c cuts off a single part: its piece counted one with it and counts at most one
///             without it. So with a limit on subassemblies that can be exceeded only single parts
///             are cut at once; with a limit on unequal masses, nothing is (what is smaller may be
///             heavier). Where no constraint judges cuts every legal removal is harmless. With
///             `made_after_any`, which asks for presence, none is.
///             Elsewhere connections of a part that may leave its piece alone come first.
/// Guarantee.  Complete: Infeasible is a proof.
/// Cost.       O(connections * (parts + connections)) where nothing has to be tried twice, and the
///             number of subsets of connections in the worst case. (Already whether an assembly in
///             the plane falls into two connected parts is NP-complete: Kavraki, Latombe and Wilson
///             1993, Inf. Proc. Letters 48(5), 229-235.)
[[nodiscard]] Feasibility find_order(const Problem& problem, const ConnectionSet& from,
                                     const ConnectionSet& to, const Budget& budget);

/// The legal steps of a state that do no harm when they are made at once, whatever plan one had in
/// mind: with the step in front, the rest of the plan stays legal.
enum class Harmless {
  None,        ///< none is known to be
  SingleCuts,  ///< those that cut off a single part
  Cuts,        ///< those that cut a piece
  All
};
/// What find_order() says about the steps of a problem that is taken apart, proved there.
[[nodiscard]] Harmless harmless_steps(const Problem& problem);

/// The same for a whole problem: whether a plan exists. A start with too many subassemblies has
/// none.
/// @throws InputError as the constructor of Problem.
[[nodiscard]] Feasibility find_order(ProblemSpec spec, const Budget& budget);

}  // namespace orasp
