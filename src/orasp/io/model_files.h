#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/geometry/cad_model.h"
#include "orasp/geometry/cad_reader.h"

namespace orasp {

/// Where parts stand, by the name of their file without its ending or by their own name.
struct Poses {
  std::map<std::string, Placement> by_name;  ///< shifts in the unit of the meshes
};

/// Reads a pose file (docs/import.md): an object of poses by name, each with "position" and, where
/// the part is turned, one of "quaternion" [w, x, y, z], "euler" [rx, ry, rz] in radians about the
/// fixed x, y and z, in this order, and "matrix", three rows. The `final_state` of ASAP's
/// config.json, [x, y, z, rx, ry, rz], is read too.
/// @throws InputError with the place of the first fault.
[[nodiscard]] Poses parse_poses(std::string_view json);
[[nodiscard]] Poses read_poses(const std::filesystem::path& file);

/// Which files a model is made of, and where its parts stand.
struct ModelFiles {
  std::vector<std::filesystem::path> models{};  ///< files, and folders of mesh files
  std::filesystem::path poses{};                ///< empty: parts stand where they are drawn
};

/// Reads all of it into one model. Of a folder every mesh file is one part, in the order of their
/// names, numbers by their value. Modules are loaded where a file needs them.
/// @throws InputError with one sentence that names the file; Interrupted.
[[nodiscard]] CadModel read_model(const ModelFiles& files, const CadReadSettings& settings);

}  // namespace orasp
