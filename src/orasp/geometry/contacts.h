#pragma once

#include <cstdint>
#include <exception>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "orasp/geometry/cad_model.h"

namespace orasp {

/// What a search throws when `GeometrySettings::stop` asks it to stop.
class Interrupted : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override { return "interrupted"; }
};

/// Where two parts cover the same space in the drawing.
struct MeshOverlap {
  double volume = 0.0;     ///< mm^3
  double thickness = 0.0;  ///< of the thickest place, mm, measured across its thinnest way
  double share = 0.0;      ///< of the volume of the smaller part
};

/// Two parts that touch or overlap, or that nothing but play parts (`proposed`).
struct Contact {
  enum class Kind : std::uint8_t {
    Touch,  ///< faces that lie on one another
    Fit,  ///< a press fit or a hole filled by its peg: coaxial without clearance, or an overlap ring
    Fastener,  ///< one of the two is a screw, nut, rivet, pin, ... by its name
  };
  std::uint32_t a = 0;  ///< a < b: positions in CadModel::parts
  std::uint32_t b = 0;
  Kind kind = Kind::Touch;
  double distance = 0.0;  ///< mm; 0 where they overlap
  double area = 0.0;      ///< of the faces within the tolerance of one another, mm^2
  std::optional<MeshOverlap> overlap;
  bool proposed =
      false;  ///< beyond the tolerance: the nearest neighbour of a part that touches nothing
};

struct GeometrySettings {
  double tolerance = 0.1;  ///< mm: nearer is contact; facts narrower than twice this are none
  unsigned threads = 1;    ///< the answer is the same for any number
  std::stop_token stop;    ///< asked often; a stopped search throws Interrupted
};

/// All contacts, sorted by (a, b); each part that touches nothing gets its nearest neighbour.
[[nodiscard]] std::vector<Contact> find_contacts(std::span<const CadPart> parts,
                                                 const GeometrySettings& settings);

}  // namespace orasp
