#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/options/command_line.h"
#include "orasp/geometry/assembly_from_cad.h"

namespace orasp::cli {

struct ImportOptions {
  std::vector<std::string> models;  ///< files and folders
  std::string output;               ///< file for the problem; "-": standard output, without shapes
  std::string poses;                ///< file; empty: none
  std::optional<double> tolerance;  ///< mm
  std::optional<double> millimetres_per_unit;
  bool solids = false;
  bool json = false;
  std::optional<std::uint64_t> threads;
  ImportSettings settings;
};

/// `orasp import MODEL... -o FILE`: makes a problem of a CAD model, and says what was found.
/// @returns the exit code. @throws InputError.
[[nodiscard]] int run(const ImportOptions& options, const Context& context);

/// Declares the arguments and options of `orasp import`.
/// @returns what runs it once they are read.
[[nodiscard]] CommandWork import_command(CommandLine& line);

}  // namespace orasp::cli
