#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "orasp/model/formula.h"
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

  struct Value {
    double reward = 0;
    double magnitude = 0;  ///< the sum of the terms' absolute values
    double rounding = 0;   ///< by how much an honest reward may differ beyond relative errors
    bool finite = true;  ///< no formula and no function gave anything else; `unfit` is what it gave
    double unfit = 0;
  };
  [[nodiscard]] Value of(const SeenStep& step) const;

  /// Whether some objective is a function of the whole Step.
  [[nodiscard]] bool needs_step() const { return needs_step_; }

 private:
  struct Term {
    double weight;
    const Objective::Parameters* parameters;
    std::unique_ptr<Formula> formula;
    bool formula_measures;  ///< the formula looks at a mass or a distance
  };
  struct TermValue;

  void add_terms(const Objective& objective, double weight);
  void find_starting_pieces();
  [[nodiscard]] double zone_cost(std::size_t parts, std::size_t of_parts, bool starting) const;
  [[nodiscard]] double distance_error(const SeenStep& step, const Vector3& depot) const;
  [[nodiscard]] TermValue value(const Term& term, const SeenStep& step) const;

  const Problem& problem_;
  std::vector<Term> terms_;
  bool needs_step_ = false;
  double farthest_coordinate_ = 0;
  std::vector<std::size_t> starting_piece_;  ///< by part: parts of its piece of the whole product
};

}  // namespace orasp::detail
