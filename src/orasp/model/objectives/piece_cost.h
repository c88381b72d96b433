#pragma once

#include <cstddef>
#include <map>

namespace orasp {

class ObjectiveKind;

/// `piece_cost` and the objectives that are one with fixed numbers, `cubesat` and `custom`:
/// `completion` if the step completes; else -(operation + pieces[|A|] + pieces[|B|]) if it
/// separates; else -operation.
struct PieceCost {
  double operation = 0;
  /// Cost by number of parts; 0 where a size is not listed.
  std::map<std::size_t, double> pieces{};
  double completion = 0;
};

[[nodiscard]] const ObjectiveKind& piece_cost_kind();
[[nodiscard]] const ObjectiveKind& cubesat_kind();
[[nodiscard]] const ObjectiveKind& custom_kind();

}  // namespace orasp
