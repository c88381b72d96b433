#include "orasp/model/operations.h"

namespace orasp {

std::vector<Operation> operations(std::span<const Step> steps, Direction direction) {
  const bool assembly = direction == Direction::Assembly;
  std::vector<Operation> list;
  const auto moves = [&](std::size_t i) { return !steps[i].moved().empty(); };
  for (std::size_t i = 0; i < steps.size(); ++i) {
    // What moves a piece ends an operation, in assembly it begins one.
    const bool begins = i == 0 || moves(assembly ? i : i - 1);
    if (begins) list.push_back({.first = i, .end = i, .moving = std::nullopt});
    list.back().end = i + 1;
    if (moves(i)) list.back().moving = i;
  }
  return list;
}

}  // namespace orasp
