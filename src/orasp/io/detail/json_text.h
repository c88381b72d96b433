#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "orasp/model/index.h"

namespace orasp::detail {

/// A JSON value on one line with spaces after ':' and ',': {"id": "1", "mass": 2.0}. Numbers read
/// back unchanged.
[[nodiscard]] std::string inline_text(const nlohmann::ordered_json& value);

/// A number; null where it is not finite, for JSON has no word for that. -0 is written as 0.
[[nodiscard]] nlohmann::ordered_json number_or_null(double number);

}  // namespace orasp::detail

/// An index is written and read as the number that it is.
template <class Kind, class Value>
struct nlohmann::adl_serializer<orasp::Index<Kind, Value>> {
  template <class Json>
  static void to_json(Json& json, orasp::Index<Kind, Value> index) {
    json = index.value();
  }
  template <class Json>
  static void from_json(const Json& json, orasp::Index<Kind, Value>& index) {
    index = json.template get<Value>();
  }
};
