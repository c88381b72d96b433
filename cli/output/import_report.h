#pragma once

#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "cli/context.h"
#include "orasp/geometry/assembly_from_cad.h"

namespace orasp::cli {

/// What is said of an import beside what is in it.
struct ImportFacts {
  std::string problem_file;  ///< as it is told; empty: none was written
  std::string shapes_file;
  std::size_t shapes_bytes = 0;
  double tolerance = 0;                                 ///< mm
  std::vector<std::pair<std::string, double>> seconds;  ///< by stage
};

/// The report of an import for people.
[[nodiscard]] std::string import_summary(const ImportedAssembly& assembly, const ImportFacts& facts,
                                         const Context& context);

/// The same as a document, with nothing cut.
[[nodiscard]] nlohmann::ordered_json import_json(const ImportedAssembly& assembly,
                                                 const ImportFacts& facts);

}  // namespace orasp::cli
