#pragma once

#include <vector>

namespace orasp {

class ObjectiveKind;
struct WeightedObjective;  // model/objective.h

/// `sum`: the weighted sum of other objectives.
struct WeightedSum {
  std::vector<WeightedObjective> terms;
};

[[nodiscard]] const ObjectiveKind& sum_kind();

}  // namespace orasp
