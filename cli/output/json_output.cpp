#include "cli/output/json_output.h"

#include <nlohmann/json.hpp>

#include "orasp/io/atomic_file.h"

namespace orasp::cli {

namespace {

using nlohmann::ordered_json;

std::string inline_text(const ordered_json& value) {
  return value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

/// An array, a line for each item if the items have parts themselves.
std::string list_text(const ordered_json& list, const std::string& indent) {
  if (list.empty() || !list.front().is_structured()) return inline_text(list);
  std::string text = "[";
  for (const ordered_json& item : list)
    text += (text.size() > 1 ? ",\n" : "\n") + indent + "  " + inline_text(item);
  return text + '\n' + indent + ']';
}

}  // namespace

std::string json_text(const ordered_json& document) {
  if (document.is_array()) return list_text(document, "") + '\n';
  std::string text = "{";
  for (const auto& [key, value] : document.items()) {
    text += (text.size() > 1 ? ",\n  " : "\n  ") + inline_text(key) + ": ";
    text += value.is_array() ? list_text(value, "  ") : inline_text(value);
  }
  return text + "\n}\n";
}

void print_result(const Context& context, const std::string& output, bool json,
                  const nlohmann::ordered_json& document,
                  const std::function<std::string()>& summary) {
  if (!output.empty()) write_file(output, json_text(document));
  context.print(json ? json_text(document) : summary());
}

}  // namespace orasp::cli
