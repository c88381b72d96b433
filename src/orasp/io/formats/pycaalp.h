#pragma once

#include <string_view>

#include "orasp/io/formats/conversion.h"

namespace orasp {

/// The parts files of PyCAALP (github.com/TUM-utg/PyCAALP): "parts" by name with "weight" and
/// "handling", "joints" by name with two "parts", "technology", "time" and "tolerance".
/// A joint becomes a connection that is made, one at a time; as there, no more than one subassembly
/// may be under work (`max_subassemblies` 1, `direction` assembly). The objective counts changes of
/// technology; handling and tolerance become numbers for objectives of the user's own.
/// @throws InputError with the place of the first fault: joints.joint2.time.
[[nodiscard]] Converted read_pycaalp(std::string_view text);

}  // namespace orasp
