#pragma once

#include <optional>
#include <span>

#include "orasp/model/transition_system.h"

namespace orasp {

/// Sets Step::direction of the steps of a plan, which know what is free. A step that has one which
/// is free keeps it: the objective looked at it. `stated` is empty or has the direction that
/// somebody chose for each step, if any: it is taken where it is free. Else a piece leaves as the
/// one before it that moved, where that is free, or in the first direction of the file that is. A
/// step that moves nothing, or for which nothing is free, has none. This is the one place where a
/// direction is chosen.
void choose_directions(std::span<Step> steps,
                       std::span<const std::optional<DirectionIndex>> stated = {});

}  // namespace orasp
