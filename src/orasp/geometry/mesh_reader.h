#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "orasp/geometry/cad_reader.h"

namespace orasp {

/// How the names of files of triangles end, in lower case.
inline constexpr auto kMeshEndings =
    std::to_array<std::string_view>({".obj", ".stl", ".ply", ".gltf", ".glb", ".3mf"});

/// Reads triangles: OBJ, STL, PLY, glTF (.gltf, .glb) and 3MF.
///
/// One node of the file (an object or group of an OBJ) is a part; with `whole`, the file is. glTF
/// is in metres; all others are taken for millimetres. Vertices at one place are one.
///
/// Lives in a module of its own with assimp, loaded when the first file is read.
class MeshReader {
 public:
  MeshReader() = default;
  MeshReader(const MeshReader&) = delete;
  MeshReader& operator=(const MeshReader&) = delete;
  virtual ~MeshReader() = default;
  /// @throws InputError with one sentence that names the file; Interrupted.
  [[nodiscard]] virtual CadModel read(const std::filesystem::path& file, bool whole,
                                      const CadReadSettings& settings) = 0;
};

[[nodiscard]] std::optional<std::string> mesh_reader_obstacle();
/// @throws InputError if the module is missing or cannot be loaded, with how to get it.
[[nodiscard]] std::unique_ptr<MeshReader> make_mesh_reader();

}  // namespace orasp
