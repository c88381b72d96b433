#pragma once

#include <string_view>

#include "orasp/io/formats/conversion.h"

namespace orasp {

/// MJCF, the models of MuJoCo, as the IKEA furniture assembly environment uses them
/// (github.com/clvrai/furniture): each body of the world, with the bodies inside of it, is a part,
/// and each `weld` between two of them a connection, whether it is active or not. Welds that repeat
/// a pair are one connection. Masses come from `inertial`, from masses of geoms, or from the volume
/// and density of boxes, spheres, capsules, cylinders and ellipsoids: for all parts, or for none.
/// Poses are left out: they are where a simulation begins, which need not be where parts belong.
/// Reference. Lee, Hu and Lim (2021), IKEA furniture assembly environment for long-horizon complex
/// manipulation tasks, ICRA; MuJoCo's XML reference.
/// @throws InputError with the line of the first fault.
[[nodiscard]] Converted read_mjcf(std::string_view text);

}  // namespace orasp
