#pragma once

#include <functional>
#include <string>

#include "orasp/model/tolerance.h"

namespace orasp {

class ObjectiveKind;
struct Step;  // model/transition_system.h

/// Any function of the step. It must be pure and safe to call from several threads at once.
struct Callable {
  std::string name = "callable";
  std::function<double(const Step&)> reward{};
  /// Least and greatest reward that one step can earn, if known. ORASP Search needs the greatest.
  double least = -kInfinity;
  double greatest = kInfinity;
};

[[nodiscard]] const ObjectiveKind& callable_kind();

}  // namespace orasp
