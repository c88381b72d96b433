#include "orasp/io/formats/detail/left_out.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include "orasp/model/detail/wording.h"

namespace orasp::detail {

std::string left_out_sentence(const ProblemSpec& spec, const LeftOut& left_out) {
  std::vector<std::string_view> names;
  const auto put = [&names](bool stated, std::string_view name) {
    if (stated) names.push_back(name);
  };
  const auto any_part = [&](auto&& states) { return std::ranges::any_of(spec.parts, states); };
  const auto any_connection = [&](auto&& states) {
    return std::ranges::any_of(spec.connections, states);
  };
  if (left_out.values) {
    put(any_part([](const Part& part) { return part.position.has_value(); }) ||
            any_connection(
                [](const Connection& connection) { return connection.position.has_value(); }),
        "position");
    put(any_part([](const Part& part) { return !part.numbers.empty(); }) ||
            any_connection(
                [](const Connection& connection) { return !connection.numbers.empty(); }),
        "numbers");
    put(any_connection([](const Connection& connection) { return !connection.attributes.empty(); }),
        "attributes");
    put(any_connection([](const Connection& connection) { return connection.success != 1; }),
        "success");
    put(any_connection([](const Connection& connection) { return !connection.axis.empty(); }),
        "axis");
  }
  put(any_part([](const Part& part) { return !part.product.empty(); }), "product");
  put(any_connection([](const Connection& connection) { return !connection.on_failure.retries(); }),
      "on_failure");
  put(!spec.precedence.empty(), "precedence");
  put(spec.blocking.has_value(), "blocking");
  put(spec.limits.any(), "limits");
  put(left_out.base && !spec.base.empty(), "base");
  put(spec.goal.has_value(), "goal");
  put(spec.action == StepKind::Part, "action");
  put(left_out.objective, "objective");
  put(left_out.direction && spec.direction == Direction::Assembly, "direction");
  put(spec.fleet.has_value(), "fleet");
  put(spec.geometry.has_value(), "geometry");
  put(!spec.note.empty(), "note");
  put(!spec.source.empty(), "source");
  if (names.empty()) return {};
  return "left out of what the problem says: " + listed(names, "and");
}

}  // namespace orasp::detail
