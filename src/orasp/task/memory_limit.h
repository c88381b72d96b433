#pragma once

#include <cstdint>

#include "orasp/task/budget.h"

namespace orasp {

/// Bytes of memory that a method may take under `budget`: Budget::max_bytes, but never more than
/// 80 % of what the machine has.
[[nodiscard]] std::uint64_t allowed_bytes(const Budget& budget);

/// Three quarters of the memory that this process may use (that of the machine, or of its control
/// group where that is less), in bytes: what the program allows a method unless told otherwise.
[[nodiscard]] std::uint64_t default_memory_limit();

}  // namespace orasp
