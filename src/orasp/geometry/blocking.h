#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "orasp/geometry/contacts.h"

namespace orasp {

/// `part` cannot leave `by` along a direction: on a region of lines of sight some of `by` lies
/// beyond some of `part`.
struct BlockingFact {
  std::uint32_t part = 0;
  std::uint32_t by = 0;
  std::uint32_t direction = 0;  ///< position in the list that was asked for
  double width = 0.0;           ///< of the widest blocked region, across its narrow way, mm
  double depth = 0.0;           ///< how far `by` lies beyond `part` there at most, mm
};

/// All facts of all ordered pairs, sorted by (direction, part, by). Directions have length 1.
[[nodiscard]] std::vector<BlockingFact> find_blocking(std::span<const CadPart> parts,
                                                      std::span<const Contact> contacts,
                                                      std::span<const Vector3> directions,
                                                      const GeometrySettings& settings);

/// Directions that the faces suggest beside the six axes, one of each pair of opposites, clustered,
/// those first that most area speaks for; only those along which some touching pair could part.
[[nodiscard]] std::vector<Vector3> suggested_directions(std::span<const CadPart> parts,
                                                        std::span<const Contact> contacts,
                                                        const GeometrySettings& settings);

}  // namespace orasp
