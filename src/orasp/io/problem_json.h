#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "orasp/io/objective_json.h"
#include "orasp/model/problem.h"

namespace orasp {

/// Reads a problem in the format `orasp-problem/1` (docs/format.md).
/// @throws InputError with one sentence for the first fault: of malformed JSON with its line and
/// column, then of unknown keys, wrong types and missing keys with their place
/// ("connections[3].parts"), then as Problem's constructor.
[[nodiscard]] Problem parse_problem(std::string_view json);

/// Reads a file. @throws InputError naming the file if it cannot be read, is a directory or is
/// larger than 256 MiB.
[[nodiscard]] Problem read_problem(const std::filesystem::path& file);

/// The problem as a file: two-space indent, one part, connection or constraint a line, defaults
/// left out (but for the objective's type). Notes and `x-` keys inside of objects are not kept.
/// Reading it back gives the same digest.
/// @throws InputError for a `callable` objective, which has no text.
[[nodiscard]] std::string problem_text(const Problem& problem);

/// SHA-256 (64 hex digits) of the canonical problem, which docs/format.md writes out: what planning
/// depends on, every default written; names, notes and sources left out. Two files that differ only
/// in layout, notes, spelled-out defaults or the order of constraints have one digest. Of a
/// `callable` objective only the name counts.
[[nodiscard]] std::string problem_digest(const Problem& problem);

}  // namespace orasp
