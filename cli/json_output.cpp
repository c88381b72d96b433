#include "cli/json_output.h"

#include <nlohmann/json.hpp>

#include "orasp/io/atomic_file.h"

namespace orasp::cli {

std::string json_text(const nlohmann::ordered_json& document) {
  return document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n';
}

void print_result(const Context& context, const std::string& output, bool json,
                  const nlohmann::ordered_json& document,
                  const std::function<std::string()>& summary) {
  if (!output.empty()) write_file(output, json_text(document));
  context.print(json ? json_text(document) : summary());
}

}  // namespace orasp::cli
