#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "orasp/geometry/mesh.h"

namespace orasp {

inline constexpr double kMetre = 1000;  ///< mm, in which models are read

/// What one face of a drawing says about directions: the normal of a plane, the axis of a cylinder
/// or cone.
struct FaceHint {
  enum class Kind : std::uint8_t { Plane, Cylinder, Cone };
  Kind kind = Kind::Plane;
  Vector3 direction{};  ///< of length 1; of a plane away from the material
  Vector3 point{};      ///< a point on the plane or axis, mm
  double radius = 0.0;  ///< of a cylinder, mm; of a cone at `point`
  double area = 0.0;    ///< mm^2
  bool hollow = false;  ///< a hole: the material lies outside of the cylinder or cone
};

/// A turn, then a shift: where a point of a product's own frame lies in the model.
struct Placement {
  std::array<Vector3, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< images of x, y and z
  Vector3 origin{};                                                ///< mm

  [[nodiscard]] Vector3 turned(const Vector3& v) const {
    Vector3 image{};
    for (std::size_t i = 0; i < 3; ++i)
      image[i] = axes[0][i] * v[0] + axes[1][i] * v[1] + axes[2][i] * v[2];
    return image;
  }
  [[nodiscard]] Vector3 placed(const Vector3& point) const {
    const Vector3 image = turned(point);
    return {image[0] + origin[0], image[1] + origin[1], image[2] + origin[2]};
  }
};

/// One part, placed where it stands in the product. Lengths in millimetres.
struct CadPart {
  std::string name;     ///< as the file has it, trimmed; may be empty, may occur twice
  std::string product;  ///< equal for parts of one product and shape; empty where nothing is known
  Mesh mesh;
  std::vector<FaceHint> faces;                 ///< empty where the file holds triangles only
  std::optional<double> volume;                ///< mm^3, from an exact kernel
  std::optional<Vector3> centroid;             ///< from an exact kernel
  std::optional<double> density;               ///< kg/m^3, from the file
  std::string material;                        ///< its name in the file; may be empty
  std::optional<std::array<float, 3>> colour;  ///< linear RGB, 0 to 1
  /// From the frame that all parts of one `product` share; nothing where that is not a turn and a
  /// shift.
  std::optional<Placement> placement;
};

/// What a model file holds.
struct CadModel {
  std::string name;
  std::vector<CadPart> parts;         ///< in the order of the file
  double millimetres_per_unit = 1.0;  ///< of the file
  std::string unit;                   ///< its name, such as "inch"
  bool unit_assumed = false;          ///< a mesh file does not say it
  double tolerance = 0.1;             ///< mm; surfaces lie within half of it
  std::vector<std::string> warnings;  ///< sentences: what was left out or assumed
};

}  // namespace orasp
