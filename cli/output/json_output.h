#pragma once

#include <functional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "cli/context.h"

namespace orasp::cli {

/// A JSON document as a file: a line for each member, and for each object or array in a list; bytes
/// that are not UTF-8 become U+FFFD. Ends with a newline.
[[nodiscard]] std::string json_text(const nlohmann::ordered_json& document);

/// Writes `document` to the file `output`, unless that is empty, and prints it if `json`, else
/// `summary()`.
/// @throws InputError if either cannot be written.
void print_result(const Context& context, const std::string& output, bool json,
                  const nlohmann::ordered_json& document,
                  const std::function<std::string()>& summary);

}  // namespace orasp::cli
