#include "orasp/io/state_policy_json.h"

#include <algorithm>
#include <array>
#include <optional>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "orasp/io/detail/json_document.h"
#include "orasp/io/detail/json_text.h"
#include "orasp/io/problem_json.h"
#include "orasp/model/detail/wording.h"

namespace orasp {
namespace {

using detail::in_quotes;
using detail::inline_text;
using detail::JsonDocument;
using detail::JsonKind;
using detail::JsonValue;
using detail::number_or_null;
using nlohmann::ordered_json;

constexpr std::string_view kFormat = "orasp-state-policy/1";

/// What a state calls the connections that were handled.
std::string_view handled_key(const Problem& problem) {
  return problem.direction() == Direction::Assembly ? "made" : "removed";
}

/// The values of `keys` in an object, all of which must be there; other keys mean nothing here.
template <std::size_t N>
std::array<JsonValue, N> required(JsonValue object, const std::string& place,
                                  const std::array<std::string_view, N>& keys) {
  if (!object.is(JsonKind::Object))
    throw InputError(detail::at(place, "expected an object, found " + object.description()));
  std::array<std::optional<JsonValue>, N> found;
  object.for_each([&](JsonValue member) {
    const auto key = std::ranges::find(keys, member.key());
    if (key != keys.end()) found[static_cast<std::size_t>(key - keys.begin())] = member;
  });
  for (std::size_t i = 0; i < N; ++i) {
    if (!found[i])
      throw InputError(detail::at(place, fmt::format("the key {} is missing", in_quotes(keys[i]))));
  }
  return [&]<std::size_t... I>(std::index_sequence<I...>) {
    return std::array<JsonValue, N>{*found[I]...};
  }
  (std::make_index_sequence<N>());
}

JsonValue expect(JsonValue value, JsonKind kind, const std::string& place,
                 std::string_view wanted) {
  if (!value.is(kind)) {
    throw InputError(
        detail::at(place, fmt::format("expected {}, found {}", wanted, value.description())));
  }
  return value;
}

std::string text_of(JsonValue value, const std::string& place) {
  return std::string(expect(value, JsonKind::String, place, "a string").string());
}

}  // namespace

std::string state_policy_text(const TransitionSystem& system, const Result& result) {
  const Problem& problem = system.problem();
  const Expectation expectation = result.expectation.value_or(Expectation{});
  const ConnectionSet start = system.start();
  std::string text = "{\n  \"format\": " + inline_text(kFormat);
  const auto put = [&text](std::string_view key, const ordered_json& value) {
    text.append(",\n  \"").append(key).append("\": ").append(inline_text(value));
  };
  put("problem", problem.name());
  put("problem_digest", problem_digest(problem));
  put("method", result.method);
  put("status", status_name(result.status));
  put("reward", number_or_null(result.reward));
  put("residual", number_or_null(expectation.residual));
  put("error", number_or_null(expectation.error));
  text += ",\n  \"states\": [";
  const char* separator = "\n    ";
  for (const PolicyState& state : expectation.policy) {
    ordered_json handled = ordered_json::array();
    for_each_connection(start.view(), [&](ConnectionIndex c) {
      if (!state.open.contains(c)) handled.push_back(problem.connection_id(c));
    });
    ordered_json entry = ordered_json::object();
    entry[std::string(handled_key(problem))] = std::move(handled);
    entry["next"] = problem.connection_id(state.next);
    entry["reward"] = number_or_null(state.reward);
    text += separator + inline_text(entry);
    separator = ",\n    ";
  }
  return text + (expectation.policy.empty() ? "]\n}\n" : "\n  ]\n}\n");
}

std::vector<PolicyState> parse_state_policy(const TransitionSystem& system, std::string_view text) {
  const Problem& problem = system.problem();
  const JsonDocument document = JsonDocument::parse(text);
  const auto [format_value] = required<1>(document.root(), "", {"format"});
  const std::string format = text_of(format_value, "format");
  if (format != kFormat) {
    throw InputError(
        fmt::format("format: {} is not the format of a policy of states; that is \"{}\"",
                    in_quotes(format), kFormat));
  }
  const auto [digest, states] = required<2>(document.root(), "", {"problem_digest", "states"});
  if (text_of(digest, "problem_digest") != problem_digest(problem)) {
    throw InputError(
        "problem_digest: the policy was made for another problem than this one, objective, limits "
        "and direction included");
  }

  const ConnectionSet start = system.start();
  const std::string_view key = handled_key(problem);
  std::vector<PolicyState> policy;
  std::unordered_map<ConnectionSet, std::size_t> places;
  expect(states, JsonKind::Array, "states", "an array of objects").for_each([&](JsonValue entry) {
    const std::string place = fmt::format("states[{}]", policy.size());
    const auto [handled, next, reward] = required<3>(entry, place, {key, "next", "reward"});
    PolicyState state{.open = start};
    const std::string list = fmt::format("{}.{}", place, key);
    std::size_t i = 0;
    expect(handled, JsonKind::Array, list, "an array of connection ids")
        .for_each([&](JsonValue id) {
          const std::string item = fmt::format("{}[{}]", list, i++);
          const ConnectionIndex c = problem.find_connection(text_of(id, item), item);
          if (!state.open.contains(c)) {
            throw InputError(detail::at(
                item, in_quotes(id.string()) + " is listed twice, or is never handled at all"));
          }
          state.open.erase(c);
        });
    state.next = problem.find_connection(text_of(next, place + ".next"), place + ".next");
    state.reward = expect(reward, JsonKind::Number, place + ".reward", "a number").number();
    const auto [other, is_new] = places.emplace(state.open, policy.size());
    if (!is_new) {
      throw InputError(
          detail::at(place, fmt::format("the same state as states[{}]", other->second)));
    }
    policy.push_back(std::move(state));
  });
  return policy;
}

}  // namespace orasp
