#pragma once

namespace orasp {

class ObjectiveKind;

/// `cubesat_zone`: the Markov form of the minimum-fuel CubeSat with a construction zone. 1 if the
/// step completes; else -(cost of A + cost of B) if it separates, else 0. A part alone costs more
/// where the piece it came from has four or more parts or is a whole starting piece: it comes from
/// the depot, not from the zone. No parameters.
struct CubesatZone {};

[[nodiscard]] const ObjectiveKind& cubesat_zone_kind();

}  // namespace orasp
