#pragma once

#include <array>

namespace orasp {

/// A point or a displacement, in metres.
using Vector3 = std::array<double, 3>;

}  // namespace orasp
