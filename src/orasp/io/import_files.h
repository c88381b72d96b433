#pragma once

#include <filesystem>
#include <string>

#include "orasp/geometry/assembly_from_cad.h"

namespace orasp {

/// The problem of an import as a file: problem_text(), and in keys that planners pass over what the
/// model says beside (docs/import.md): `x-density` and `x-volume` of parts, `x-kind`, `x-area`
/// and `x-distance` of connections, `x-width` and `x-depth` of what blocks. In m, m^2, m^3
/// and kg/m^3. `geometry` names the file with the shapes; empty: none.
/// @throws InputError as Problem's constructor.
[[nodiscard]] std::string imported_problem_text(const ImportedAssembly& assembly,
                                                const std::string& geometry);

/// The shapes as a binary glTF file: a node for each part, named by its id, in metres; equal parts
/// share a mesh.
[[nodiscard]] std::string shapes_glb(const ImportedAssembly& assembly);

/// Writes the problem, and the shapes beside it under the same name with the ending .glb: both or
/// neither. @returns the file of the shapes. @throws InputError.
std::filesystem::path write_import(const ImportedAssembly& assembly,
                                   const std::filesystem::path& file);

}  // namespace orasp
