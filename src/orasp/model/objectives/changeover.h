#pragma once

#include <optional>
#include <string>
#include <vector>

namespace orasp {

class ObjectiveKind;

/// What a change from one value of an attribute to another costs.
struct ChangeCost {
  std::string from{};
  std::string to{};
  double cost = 0;
};

/// The attribute that stands for the way in which the moved piece leaves.
inline constexpr const char* kDirectionAttribute = "direction";

/// `changeover`: minus the cost of the change, if the step has a value of the attribute other than
/// the one in force. In force is the last value that a step had, and `start` before any had one;
/// without `start` the first value is free. A step without a value changes nothing.
struct Changeover {
  std::string attribute{};
  double cost = 1;                  ///< of every change that `costs` does not list
  std::vector<ChangeCost> costs{};  ///< of some changes
  std::optional<std::string> start{};
};

[[nodiscard]] const ObjectiveKind& changeover_kind();

}  // namespace orasp
