#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "orasp/model/tolerance.h"
#include "orasp/model/vector3.h"

namespace orasp {

class ObjectiveKind;
struct Step;  // model/transition_system.h

/// What formulas see of a step, of many steps: a column for each variable, a row for each step.
struct StepTable {
  /// Of the columns: those of kFormulaVariables (model/formula.h), in that order, then of each of
  /// the user's own numbers its names_in_formulas.
  std::vector<std::string> names{};
  std::vector<std::vector<double>> columns{};

  [[nodiscard]] std::size_t num_steps() const { return columns.empty() ? 0 : columns[0].size(); }
};

/// Any function of the step. It must be pure and safe to call from several threads at once.
struct Callable {
  std::string name = "callable";
  std::function<double(const Step&)> reward{};
  /// Instead of `reward`: a function of many steps at once, for who pays for each call; what step i
  /// earns goes to rewards[i], and it must not depend on which steps it comes with. While H is
  /// built it gets the steps of thousands of states, from searches those of one state. One by one
  /// it is asked in a plan's check, in a `sum`, and where there is more to steps
  /// (TransitionSystem::wide).
  std::function<void(const StepTable& steps, std::span<double> rewards)> rewards{};
  /// m; where the column `distance` is measured from.
  Vector3 depot{};
  /// Least and greatest reward that one step can earn, if known. ORASP Search needs the greatest.
  double least = -kInfinity;
  double greatest = kInfinity;
};

[[nodiscard]] const ObjectiveKind& callable_kind();

}  // namespace orasp
