#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "orasp/geometry/mesh.h"

namespace orasp {

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

/// One part, placed where it stands in the product. Lengths in millimetres.
struct CadPart {
  std::string name;     ///< as the file has it, trimmed; may be empty, may occur twice
  std::string product;  ///< equal for parts of one product and shape; empty where nothing is known
  Mesh mesh;
  std::vector<FaceHint> faces;    ///< empty where the file holds triangles only
  std::optional<double> volume;   ///< mm^3, from an exact kernel
  std::optional<Vector3> centroid;  ///< from an exact kernel
  std::optional<double> density;  ///< kg/m^3, from the file
  std::string material;           ///< its name in the file; may be empty
  std::optional<std::array<float, 3>> colour;  ///< linear RGB, 0 to 1
};

/// What a model file holds.
struct CadModel {
  std::string name;
  std::vector<CadPart> parts;      ///< in the order of the file
  double millimetres_per_unit = 1.0;  ///< of the file
  std::string unit;                ///< its name, such as "inch"
  std::vector<std::string> warnings;  ///< sentences: what was left out or assumed
};

}  // namespace orasp
