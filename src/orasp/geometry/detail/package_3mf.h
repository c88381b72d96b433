#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace orasp::detail {

/// What assimp leaves out of a 3MF file. Part of the module that reads meshes.
struct Package3mf {
  std::string unit;                          ///< as the file states it; "millimeter" where not
  std::map<std::string, std::string> names;  ///< of objects, by their ids; those that have one
};

/// Reads the model of a 3MF file, a ZIP archive of XML (3MF Core Specification 1.3, sections 3.4
/// and 4.1), up to half a GiB of it. What is no 3MF file has no names, and the unit of one that
/// states none.
[[nodiscard]] Package3mf read_3mf(const std::filesystem::path& file);

}  // namespace orasp::detail
