#pragma once

#include <span>
#include <string>
#include <string_view>

#include "orasp/io/formats/conversion.h"
#include "orasp/io/plan_json.h"
#include "orasp/model/problem.h"

namespace orasp {

/// A file format that problems are read from, or that problems or plans are written in. What each
/// means, and what it cannot carry, stands in docs/convert.md.
struct Format {
  std::string_view name;
  /// The endings of its files, ".graphml", with spaces between them; empty: none of its own.
  std::string_view endings;
  /// One line, for help texts.
  std::string_view summary;
  /// One line: what is left out, or refused.
  std::string_view limits;
  /// Null where problems are not read from it.
  Converted (*read)(std::string_view text) = nullptr;
  /// Null where nothing is written in it.
  Written (*write)(const WriteRequest& request) = nullptr;
  /// Whether what is written is a plan, not a problem.
  bool of_plan = false;
};

/// All formats, in the order of the documentation. The one table: the program, its help, the
/// completion of the shell and the tests walk it.
[[nodiscard]] std::span<const Format> formats();

/// @throws InputError `unknown format "graphlm"; known: ...`.
[[nodiscard]] const Format& find_format(std::string_view name);

/// The format of an input file by its ending, or else by what its text begins with.
/// @throws InputError with one sentence where that is not certain.
[[nodiscard]] const Format& format_of_input(std::string_view file, std::string_view text);

/// The format of an output file by its ending; of "-", standard output, that of problem files.
/// Where an ending is that of a problem and of plans, it means the problem.
/// @throws InputError with one sentence that lists the formats where several or none have it.
[[nodiscard]] const Format& format_of_output(std::string_view file);

/// Reads a problem from the text of a file. What Problem's constructor would refuse is refused.
///
///     const Converted read = orasp::read_format(text, "graphml");
///     const Problem problem(read.problem);
///
/// @throws InputError with one sentence that says where in the text the fault stands, or that the
/// format is not read.
[[nodiscard]] Converted read_format(std::string_view text, std::string_view format);

/// Writes a problem. @throws InputError where the format cannot say what the problem says, is not
/// written, or needs a plan.
[[nodiscard]] Written write_format(const Problem& problem, std::string_view format);

/// Writes a plan of one robot for the whole of a problem (parse_plan reads one; a plan for a format
/// that needs none is checked and passed over).
/// @throws InputError as above, and where the plan breaks a rule of the problem.
[[nodiscard]] Written write_format(const Problem& problem, std::string_view format,
                                   const PlanFile& plan);

}  // namespace orasp
