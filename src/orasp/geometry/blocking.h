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
///
/// Problem: may a part be moved along a direction to infinity without meeting another one? A is
/// blocked by B where, on a line along the direction, the last point of B lies more than the
/// tolerance beyond the first point of A; B blocks A if the region of such lines, seen along the
/// direction, is wider than twice the tolerance (its widest disc is). So there is no step size,
/// nothing is tunnelled through, and inner cavities and open meshes need no care; the narrow
/// regions that are left out are those that come of round faces drawn as triangles, and of faces
/// that lie on one another.
///
/// Idea: depth maps (the z-buffer of Catmull, "A subdivision algorithm for computer display of
/// curved surfaces", 1974) of both parts over the overlap of their shadows; one raster answers for
/// the direction and its opposite, as A held by B one way is B held by A the other way. The lines
/// of a first look, some thousands, settle most pairs: a region that is plainly wide blocks. Else
/// bounds on the heights of the triangles in each cell say where anything may be blocked at all,
/// and only these cells are cut finer, down to half the tolerance, so that a wire or a lip thinner
/// than a cell of the first look is met; where a width is within 1.5 cells of the limit the lines
/// are drawn four times as close. Widths are those of an exact Euclidean distance transform.
///
/// Real drawings overlap: screws in bores of the core's diameter, inserts, press fits, errors. For
/// closed parts that touch (`contacts`), what both cover is first taken on each line from A, and
/// then from B instead; A is free if either leaves no region wider than twice the tolerance or 1.5
/// times the thickness of the overlap, whichever is more.
///
/// Guarantee: regions wider than the limit by more than the tolerance are found, and none narrower
/// than it by more than that is given, as far as the mesh is true and the parts are no larger than
/// about 4,000 tolerances (beyond that the finest cells grow with the part, and thin things may be
/// missed). A region broken into strips at the very distance of the lines could deceive the first
/// look. A numerical answer, not a proof. `width` is good to a cell: a fortieth of the shadow's
/// side where it is wide, a quarter of the tolerance near the limit.
///
/// Cost: for each direction (with its opposite) all vertices are turned once and pairs are found by
/// a sweep over the boxes of the shadows, then 0.1 to 1 ms a pair whose shadows overlap; memory is
/// that of one turned copy of the meshes, and a few MB a thread. The answer does not depend on the
/// number of threads, to the last bit. Throws Interrupted.
[[nodiscard]] std::vector<BlockingFact> find_blocking(std::span<const CadPart> parts,
                                                      std::span<const Contact> contacts,
                                                      std::span<const Vector3> directions,
                                                      const GeometrySettings& settings);

/// Directions that the faces suggest beside the six axes, one of each pair of opposites (the first
/// coordinate that is not 0 is positive), clustered to half a degree, those first that most area
/// speaks for; only those along which some touching pair could part.
///
/// A slot that leans is open along a single line, which no random direction hits; but its faces
/// hold it. Offered are the normals of plane faces and the axes of cylinders and cones of two parts
/// that touch (`CadPart::faces`; else the normals of the largest flat places of the mesh), and the
/// directions in which two planes of the contact meet: the extreme rays of the cone of directions d
/// with n.d >= 0 for all normals n of the contact (Wilson and Latombe, "Geometric reasoning about
/// mechanical assembly", 1994). Kept are those that lie in the cone of that contact, or whose
/// opposites do. No guarantee that what a product needs is among them. About as much time as
/// finding the contacts.
[[nodiscard]] std::vector<Vector3> suggested_directions(std::span<const CadPart> parts,
                                                        std::span<const Contact> contacts,
                                                        const GeometrySettings& settings);

}  // namespace orasp
