#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "orasp/model/transition_system.h"

namespace orasp {

/// Steps of a plan that one does in one go: those that only loosen something and the one that then
/// takes a piece off; in assembly the one that brings a piece and those that then fasten it.
struct Operation {
  std::size_t first = 0;              ///< its steps are those from `first`, counted from 0, ...
  std::size_t end = 0;                ///< ... to the one before `end`
  std::optional<std::size_t> moving;  ///< the step that moves a piece, if there is one
};

/// The steps of a plan, each in one operation, in order. Steps that belong to no piece, at the end
/// of a disassembly or the beginning of an assembly, are an operation of their own. O(steps).
[[nodiscard]] std::vector<Operation> operations(std::span<const Step> steps, Direction direction);

}  // namespace orasp
