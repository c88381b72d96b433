#include "orasp/io/detail/json_text.h"

#include <cmath>

namespace orasp::detail {
namespace {

void append(std::string& text, const nlohmann::ordered_json& value) {
  if (!value.is_structured()) {
    text += value.dump();
    return;
  }
  text += value.is_object() ? '{' : '[';
  bool first = true;
  for (const auto& [key, member] : value.items()) {
    if (!first) text += ", ";
    first = false;
    if (value.is_object()) text += nlohmann::ordered_json(key).dump() + ": ";
    append(text, member);
  }
  text += value.is_object() ? '}' : ']';
}

}  // namespace

std::string inline_text(const nlohmann::ordered_json& value) {
  std::string text;
  append(text, value);
  return text;
}

nlohmann::ordered_json number_or_null(double number) {
  if (!std::isfinite(number)) return nullptr;
  return number + 0.0;
}

}  // namespace orasp::detail
