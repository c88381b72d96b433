#pragma once

#include <span>
#include <string_view>

namespace orasp::detail {

/// One file of data/scenarios, compiled into the library by cmake/embed.cmake.
struct EmbeddedFile {
  std::string_view name;  ///< the file's name without ".json"
  std::string_view text;  ///< its bytes
};

/// The built-in problem files, in the order of the list `scenarios` in src/orasp/CMakeLists.txt.
[[nodiscard]] std::span<const EmbeddedFile> embedded_scenarios();

}  // namespace orasp::detail
