#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "orasp/model/problem.h"
#include "orasp/model/transition_system.h"

namespace orasp::detail {

/// What objectives see of one step, worked out by the replay of a plan.
struct SeenStep {
  ConnectionIndex connection = 0;
  std::size_t before = 0;
  std::size_t after = 0;
  bool separates = false;
  bool completes = false;
  std::size_t subassemblies = 0;
  std::size_t a_parts = 0;  ///< as all that follows, 0 or nothing unless the step separates
  std::size_t b_parts = 0;
  std::size_t moved_parts = 0;
  double moved_mass = 0;
  double kept_mass = 0;
  /// The mean of the moved parts' positions; nothing where one of them has no position.
  std::optional<Vector3> moved_centroid;
  /// The whole step, for objectives that are functions of the caller; else null.
  const Step* step = nullptr;
};

/// What a step earns, and by how much an honest reward may differ beyond relative errors.
struct CheckedValue {
  double reward = 0;
  double rounding = 0;
};

/// What the formulas of the check need to know of the whole problem.
class CheckedProblem {
 public:
  explicit CheckedProblem(const Problem& problem);

  [[nodiscard]] const Problem& problem() const { return problem_; }
  /// Parts of the piece of the whole product that holds `part`.
  [[nodiscard]] std::size_t starting_piece(PartIndex part) const { return starting_piece_[part]; }
  /// How far two honest means of the same positions can lie apart, and two distances with them.
  [[nodiscard]] double distance_error(const SeenStep& step, const Vector3& depot) const;

 private:
  const Problem& problem_;
  double farthest_coordinate_ = 0;
  std::vector<std::size_t> starting_piece_;
};

[[nodiscard]] double metres_between(const Vector3& point, const Vector3& depot);

/// One addend of the objective. Every objective states its formula a second time for it
/// (ObjectiveKind::add_checked_terms).
struct CheckedTerm {
  double weight = 1;
  std::function<CheckedValue(const SeenStep&)> value;
  bool calls_out = false;   ///< a formula or a function of the user, which may not be finite
  bool needs_step = false;  ///< it looks at SeenStep::step
};

/// Rewards for the check of plans.
/// Problem.   A reward formula with a mistake would be in every planner's answer, and a replay
///            that used the same formula would find nothing wrong with it.
/// Idea.      The sentences of docs/format.md once more, from the numbers of the problem alone.
///            Nothing here is shared with TransitionSystem.
/// Guarantee. Where both are right they agree up to the rounding of sums whose addends come in
///            another order; `rounding` says how much that can be.
/// Cost.      O(terms of the objective) a step; a formula is evaluated up to three times.
class CheckedReward {
 public:
  /// @throws InputError if an expression of the objective has no compiler or does not compile, or
  /// the objective is one of fleets.
  explicit CheckedReward(const Problem& problem);
  CheckedReward(const CheckedReward&) = delete;
  CheckedReward& operator=(const CheckedReward&) = delete;

  struct Value {
    double reward = 0;
    double magnitude = 0;  ///< the sum of the terms' absolute values
    double rounding = 0;   ///< by how much an honest reward may differ beyond relative errors
    bool finite = true;    ///< no formula and no function gave what cannot be added up, as `unfit`
    double unfit = 0;
  };
  [[nodiscard]] Value of(const SeenStep& step) const;

  /// Whether some objective is a function of the whole Step.
  [[nodiscard]] bool needs_step() const { return needs_step_; }

 private:
  CheckedProblem problem_;
  double largest_;
  std::vector<CheckedTerm> terms_;
  bool needs_step_ = false;
};

}  // namespace orasp::detail
