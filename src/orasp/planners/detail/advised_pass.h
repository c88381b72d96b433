#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "orasp/bounds/bound.h"
#include "orasp/bounds/bound_kinds.h"
#include "orasp/model/transition_system.h"
#include "orasp/planners/step_advice.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp::detail {

/// Passes of a beam search that keep the states which advice speaks least against.
///
/// Idea.       Layer by layer, as beam(). But of a layer those states are kept against whose steps
///             the least was said, summed along the way: the first is that to which the advice
///             itself leads, the others differ from it where it matters least. Where a bound is
///             loose, states that have put off what must be paid promise most, so that a narrow
///             beam runs after them; a policy that has learned from proved plans does not. States
///             that cannot beat the best plan are left out by the bound.
/// Reference.  Beam search over the choices of a policy: Choo et al. (2022), Simulation-guided beam
///             search for neural combinatorial optimization, NeurIPS.
/// Guarantee.  Every plan is legal, and what is left out for want of room is bounded, so that a
///             pass that leaves nothing out proves its plan.
/// Cost.       A pass: width * steps questions to the advice.
/// Repeatable. The same for any number of threads.
class AdvisedPass {
 public:
  /// `like`: a bound of the system and kind, whose prices serve again. All must outlive it.
  AdvisedPass(const TransitionSystem& system, const MakeAdvice& advice, BoundKind kind,
              const Bound* like, unsigned threads);
  ~AdvisedPass();

  /// Runs a pass. Returns the greatest promise of a state that found no room, -infinity where every
  /// state did. A better plan goes into `result`, whose statistics and stop it keeps; promises that
  /// differ by less than `tick` are equal.
  double run(std::size_t width, double tick, const Budget& budget, Result& result);

 private:
  struct State;
  struct Candidate;
  struct Taken;
  struct Worker;
  void expand(Worker& worker, std::size_t begin, std::size_t end, double least, double tick,
              bool bounded, const Budget& budget);
  [[nodiscard]] SetView state_of(std::size_t i) const;
  [[nodiscard]] bool same_state(const Candidate& a, const Candidate& b) const;
  void merge_equal(std::vector<Candidate>& found) const;
  std::vector<Candidate> successors(double tick, const Budget& budget, Result& result);
  double go_on(std::vector<Candidate>& found, std::size_t width, std::vector<Taken>& ways);

  const TransitionSystem& system_;
  std::size_t words_;
  std::vector<std::unique_ptr<Worker>> workers_;
  /// The layer: its states one after another, and what is known of each.
  std::vector<std::uint64_t> states_;
  std::vector<State> layer_;
};

}  // namespace orasp::detail
