#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
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
  double duration = 0;  ///< s, of all that it handles
  /// Of a step that takes parts off: the sizes of the pieces that the rest falls into. Else empty.
  std::vector<std::size_t> rest_parts;
  double elapsed = 0;  ///< s, the durations of all that was handled before
  /// Of the user's own numbers: the connection's, and the sums over the moved and the kept piece; 0
  /// where a name is missing.
  std::map<std::string, double> own_numbers;
  std::map<std::string, double> moved_numbers;
  std::map<std::string, double> kept_numbers;
  /// Of each attribute that the objective looks back at: the step's value and the last one before;
  /// missing where there is none.
  std::map<std::string, std::string> attributes;
  std::map<std::string, std::string> in_force;
  std::optional<Vector3> place;       ///< where it is done
  std::optional<Vector3> last_place;  ///< where the step before was done
  double largest_number_sum = 0;      ///< of absolute values, over both pieces
  /// The whole step, for objectives that are functions of the caller; else null.
  const Step* step = nullptr;

  /// The sizes of the pieces that it leaves, or joins.
  [[nodiscard]] std::vector<std::size_t> pieces() const {
    if (rest_parts.empty()) return {a_parts, b_parts};
    std::vector<std::size_t> all = rest_parts;
    all.insert(all.begin(), a_parts);
    return all;
  }
  [[nodiscard]] double number(const std::string& name) const { return found(own_numbers, name); }
  [[nodiscard]] double moved_number(const std::string& name) const {
    return found(moved_numbers, name);
  }
  [[nodiscard]] double kept_number(const std::string& name) const {
    return found(kept_numbers, name);
  }

 private:
  [[nodiscard]] static double found(const std::map<std::string, double>& numbers,
                                    const std::string& name) {
    const auto entry = numbers.find(name);
    return entry == numbers.end() ? 0.0 : entry->second;
  }
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
  bool looks_back = false;  ///< it looks at the steps before
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

  /// Whether some objective looks at the steps before.
  [[nodiscard]] bool looks_back() const { return looks_back_; }
  /// Whether some objective is a function of the whole Step.
  [[nodiscard]] bool needs_step() const { return needs_step_; }

 private:
  CheckedProblem problem_;
  double largest_;
  std::vector<CheckedTerm> terms_;
  bool needs_step_ = false;
  bool looks_back_ = false;
};

}  // namespace orasp::detail
