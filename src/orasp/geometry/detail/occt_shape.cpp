#include "orasp/geometry/detail/occt_shape.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include <BRepAdaptor_Surface.hxx>
#include <BRepGProp.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <Poly_Triangulation.hxx>
#include <TopExp_Explorer.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <gp_Ax3.hxx>
#include <gp_Cone.hxx>
#include <gp_Cylinder.hxx>
#include <gp_Pln.hxx>

#include "orasp/model/detail/vector_math.h"

namespace orasp::detail {

namespace {

constexpr double kAngle = 0.3;  ///< radians between neighbouring triangles

/// Gives points numbers; points nearer than a nanometre have one. Neighbouring faces share the
/// points of their edge up to rounding.
class PointTable {
 public:
  explicit PointTable(std::vector<Vector3>& points) : points_(points) {}

  std::uint32_t number_of(const Vector3& point) {
    std::array<std::int64_t, 3> cell{};
    std::array<std::int64_t, 3> other{};
    for (std::size_t i = 0; i < 3; ++i) {
      const double at = point[i] / kCell;
      cell[i] = static_cast<std::int64_t>(std::floor(at));
      const double part = at - std::floor(at);
      other[i] = part < kReach / kCell       ? cell[i] - 1
                 : part > 1 - kReach / kCell ? cell[i] + 1
                                             : cell[i];
    }
    for (unsigned corner = 0; corner < 8; ++corner) {
      std::array<std::int64_t, 3> at{};
      bool twice = false;
      for (std::size_t i = 0; i < 3; ++i) {
        const bool takes_other = (corner >> i & 1U) != 0;
        twice = twice || (takes_other && other[i] == cell[i]);
        at[i] = takes_other ? other[i] : cell[i];
      }
      if (twice) continue;
      const auto found = numbers_.find(key(at));
      if (found != numbers_.end() && near(points_[found->second], point)) return found->second;
    }
    const auto number = static_cast<std::uint32_t>(points_.size());
    points_.push_back(point);
    numbers_.emplace(key(cell), number);
    return number;
  }

 private:
  static constexpr double kCell = 1e-4;   // mm
  static constexpr double kReach = 1e-6;  // mm

  static bool near(const Vector3& a, const Vector3& b) {
    return std::abs(a[0] - b[0]) <= kReach && std::abs(a[1] - b[1]) <= kReach &&
           std::abs(a[2] - b[2]) <= kReach;
  }
  static std::uint64_t key(const std::array<std::int64_t, 3>& cell) {
    std::uint64_t mixed = 0;
    for (const std::int64_t number : cell) {
      mixed = (mixed ^ static_cast<std::uint64_t>(number)) * 0x9E3779B97F4A7C15U;
      mixed ^= mixed >> 29U;
    }
    return mixed;
  }

  std::vector<Vector3>& points_;
  std::unordered_map<std::uint64_t, std::uint32_t> numbers_;
};

Vector3 vector_of(const gp_XYZ& xyz) {
  return {xyz.X(), xyz.Y(), xyz.Z()};
}

Vector3 minus(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

double triangle_area(const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 u = minus(b, a);
  const Vector3 v = minus(c, a);
  return 0.5 * std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                          u[0] * v[1] - u[1] * v[0]);
}

/// By the divergence theorem; of a closed mesh.
double enclosed_volume(const Mesh& mesh) {
  double volume = 0;
  for (const auto& triangle : mesh.triangles) {
    volume += dot(mesh.vertices[triangle[0]],
                  cross(mesh.vertices[triangle[1]], mesh.vertices[triangle[2]])) /
              6;
  }
  return volume;
}

/// Adds the triangles of a face. @returns their area; negative where there are none.
double add_triangles(const TopoDS_Face& face, PointTable& table, Mesh& mesh) {
  TopLoc_Location location;
  const Handle(Poly_Triangulation)& triangulation = BRep_Tool::Triangulation(face, location);
  if (triangulation.IsNull()) return -1;
  const gp_Trsf where = location.Transformation();
  const bool reversed = (face.Orientation() == TopAbs_REVERSED) != where.IsNegative();
  std::vector<std::uint32_t> numbers(static_cast<std::size_t>(triangulation->NbNodes()));
  for (int i = 1; i <= triangulation->NbNodes(); ++i) {
    const gp_Pnt point = triangulation->Node(i).Transformed(where);
    numbers[static_cast<std::size_t>(i - 1)] = table.number_of(vector_of(point.XYZ()));
  }
  double area = 0;
  for (int i = 1; i <= triangulation->NbTriangles(); ++i) {
    int a = 0;
    int b = 0;
    int c = 0;
    triangulation->Triangle(i).Get(a, b, c);
    if (reversed) std::swap(b, c);
    const std::array<std::uint32_t, 3> triangle = {numbers[static_cast<std::size_t>(a - 1)],
                                                   numbers[static_cast<std::size_t>(b - 1)],
                                                   numbers[static_cast<std::size_t>(c - 1)]};
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0])
      continue;
    mesh.triangles.push_back(triangle);
    area += triangle_area(mesh.vertices[triangle[0]], mesh.vertices[triangle[1]],
                          mesh.vertices[triangle[2]]);
  }
  return area;
}

/// The hint of a face; nothing for surfaces that suggest no direction.
std::optional<FaceHint> hint_of(const TopoDS_Face& face, double area) {
  const BRepAdaptor_Surface surface(face, Standard_False);
  const bool reversed = face.Orientation() == TopAbs_REVERSED;
  FaceHint hint;
  hint.area = area;
  gp_Ax3 frame;
  switch (surface.GetType()) {
    case GeomAbs_Plane:
      hint.kind = FaceHint::Kind::Plane;
      frame = surface.Plane().Position();
      break;
    case GeomAbs_Cylinder:
      hint.kind = FaceHint::Kind::Cylinder;
      frame = surface.Cylinder().Position();
      hint.radius = surface.Cylinder().Radius();
      break;
    case GeomAbs_Cone:
      hint.kind = FaceHint::Kind::Cone;
      frame = surface.Cone().Position();
      hint.radius = surface.Cone().RefRadius();
      break;
    default: return std::nullopt;
  }
  hint.point = vector_of(frame.Location().XYZ());
  hint.direction = vector_of(frame.Direction().XYZ());
  // In a left-handed frame the surface's normal is the other one.
  const bool inward = reversed == frame.Direct();
  if (hint.kind == FaceHint::Kind::Plane && inward) {
    for (double& number : hint.direction) number = -number;
  }
  hint.hollow = hint.kind != FaceHint::Kind::Plane && inward;
  return hint;
}

}  // namespace

OcctShape meshed(const TopoDS_Shape& shape, double deflection, bool parallel) {
  const BRepMesh_IncrementalMesh mesher(shape, deflection, Standard_False, kAngle, parallel);
  OcctShape result;
  PointTable table(result.mesh.vertices);
  for (TopExp_Explorer at(shape, TopAbs_FACE); at.More(); at.Next()) {
    const TopoDS_Face& face = TopoDS::Face(at.Current());
    const double area = add_triangles(face, table, result.mesh);
    if (area < 0) {
      ++result.failed_faces;
      continue;
    }
    if (const auto hint = hint_of(face, area)) result.faces.push_back(*hint);
  }
  return result;
}

void measure_volume(const TopoDS_Shape& shape, OcctShape& measured) {
  GProp_GProps properties;
  BRepGProp::VolumeProperties(shape, properties, /*OnlyClosed=*/Standard_True);
  if (!(properties.Mass() > 0)) return;
  // The kernel's integrals go astray on some faces, such as those of threads; then the triangles
  // know better.
  constexpr double kAstray = 0.02;
  const double by_triangles = enclosed_volume(measured.mesh);
  if (std::abs(properties.Mass() - by_triangles) > kAstray * by_triangles) return;
  measured.volume = properties.Mass();
  measured.centroid = vector_of(properties.CentreOfMass().XYZ());
}

void place(const OcctShape& shape, const gp_Trsf& where, double scale, CadPart& part) {
  const gp_Mat& turn = where.HVectorialPart();
  Placement placement;
  for (std::size_t axis = 0; axis < 3; ++axis)
    placement.axes[axis] = vector_of(turn.Column(static_cast<int>(axis) + 1));
  placement.origin = vector_of(where.TranslationPart());
  for (double& number : placement.origin) number *= scale;
  const double factor = where.ScaleFactor();
  const double length = std::abs(factor);

  const auto placed = [&](Vector3 point) {
    for (double& number : point) number *= scale;
    return placement.placed(Vector3{point[0] * length, point[1] * length, point[2] * length});
  };
  // A scale other than 1 is taken out of the axes, a mirror stays in them.
  for (Vector3& axis : placement.axes) {
    const double own = std::hypot(axis[0], axis[1], axis[2]);
    if (own > 0) {
      for (double& number : axis) number /= own;
    }
  }
  const bool mirrored = where.IsNegative();
  part.mesh = shape.mesh;
  for (Vector3& vertex : part.mesh.vertices) vertex = placed(vertex);
  if (mirrored) {
    for (auto& triangle : part.mesh.triangles) std::swap(triangle[1], triangle[2]);
  }
  part.faces = shape.faces;
  for (FaceHint& hint : part.faces) {
    hint.point = placed(hint.point);
    hint.direction = placement.turned(hint.direction);
    hint.radius *= scale * length;
    hint.area *= scale * scale * length * length;
  }
  const double size = scale * length;
  if (shape.volume) part.volume = *shape.volume * size * size * size;
  if (shape.centroid) part.centroid = placed(*shape.centroid);
  constexpr double kSame = 1e-9;
  if (mirrored || std::abs(length - 1) > kSame) {
    part.product.clear();
  } else {
    part.placement = placement;
  }
}

}  // namespace orasp::detail
