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
    Touch,     ///< faces that lie on one another
    Fit,       ///< a press fit or a hole filled by its peg
    Fastener,  ///< one of the two is a screw, nut, rivet, pin, ... by its name
  };
  std::uint32_t a = 0;  ///< a < b: positions in CadModel::parts
  std::uint32_t b = 0;
  Kind kind = Kind::Touch;
  double distance = 0.0;  ///< mm; 0 where they overlap
  double area = 0.0;      ///< of the faces within the tolerance of one another, mm^2
  std::optional<MeshOverlap> overlap;
  bool proposed = false;  ///< farther apart: nearest neighbours, one of which touches nothing
};

struct GeometrySettings {
  double tolerance = 0.1;  ///< mm: nearer is contact; facts narrower than twice this are none
  unsigned threads = 1;    ///< the answer is the same for any number
  std::stop_token stop;    ///< asked often; a stopped search throws Interrupted
};

/// All contacts, sorted by (a, b); each part that touches nothing gets its nearest neighbour.
///
/// Pairs whose boxes are near are found by a sweep; their distance is the exact one of their
/// triangles, by a hierarchy of boxes for each mesh, and two parts touch if it is not more than the
/// tolerance. The area is that of the pairs of triangles that face one another, each laid onto the
/// other and cut where they are farther apart than the tolerance: exact for plane faces. The
/// overlap of two closed parts, if it is thicker than the tolerance, is measured on rasters of
/// lines along the three axes: the volume to about a hundredth, not to be quoted further. A closed
/// part within the material of another is found as well.
///
/// The kind is Fastener if the name of one of the two says so; Fit if the overlap runs round a
/// hole, if the drawing has a peg and a hole about one axis with radii that differ by at most half
/// the tolerance, or, without such a drawing, if the faces that touch leave no way across some
/// axis; and Touch otherwise.
///
/// O(n log n) for n triangles, and some milliseconds for each pair that touches. The answer does
/// not depend on the number of threads. Throws Interrupted.
[[nodiscard]] std::vector<Contact> find_contacts(std::span<const CadPart> parts,
                                                 const GeometrySettings& settings);

}  // namespace orasp
