#pragma once

#include <string_view>

namespace orasp::detail {

/// Whether a part is a fastener by its name: a word such as screw, bolt, nut, washer, rivet, pin,
/// stud or dowel, a thread such as M3 or M3x12, or a standard with its number such as DIN 912, in
/// any case and between any signs. A lead screw, a nut block or a pin holder is none.
[[nodiscard]] bool names_fastener(std::string_view name);

}  // namespace orasp::detail
