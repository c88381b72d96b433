#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "orasp/model/problem.h"

namespace orasp {

/// The problem that users call `name`: one with a '/' or that ends in ".json" is a file; else a
/// built-in scenario if there is one, else a file. @throws InputError.
[[nodiscard]] Problem find_problem(const std::string& name);

/// The objective that users call `name`: a type with its defaults, or a JSON file that holds one.
/// @throws InputError that names the types.
[[nodiscard]] Objective find_objective(const std::string& name);

/// "disassembly" or "assembly". @throws InputError.
[[nodiscard]] Direction find_direction(const std::string& name);

/// What is to be other than a problem says. Empty: as it says.
struct ProblemEdits {
  std::optional<Objective> objective{};
  std::optional<Direction> direction{};
  std::optional<std::uint64_t> max_subassemblies{};
  std::optional<std::uint64_t> max_moved_parts{};
  std::optional<double> max_moved_mass{};  ///< kg
  std::optional<std::uint64_t> robots{};   ///< of the fleet
  std::optional<std::uint64_t> sites{};    ///< of the fleet: the first so many

  [[nodiscard]] bool any() const {
    return objective || direction || max_subassemblies || max_moved_parts || max_moved_mass ||
           robots || sites;
  }
};

/// The same problem with those edits. An objective of one robot leaves its fleet out. `mark` stands
/// in front of the names of edits in error messages: "--" on a command line.
/// @throws InputError.
[[nodiscard]] Problem edited(const Problem& problem, const ProblemEdits& edits,
                             std::string_view mark = "");

}  // namespace orasp
