#include "orasp/io/run_records.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "orasp/io/detail/json_document.h"
#include "orasp/model/error.h"

namespace orasp {
namespace {

using detail::JsonDocument;
using detail::JsonKind;
using detail::JsonValue;

/// A number, or nothing for null.
std::optional<double> number_or_none(JsonValue value) {
  if (value.is(JsonKind::Null)) return std::nullopt;
  if (!value.is(JsonKind::Number)) {
    throw InputError(
        fmt::format("{}: expected a number or null, found {}", value.key(), value.description()));
  }
  return value.number();
}

LearningPoint learning_point(std::string_view line) {
  const JsonDocument document = JsonDocument::parse(line);
  const JsonValue root = document.root();
  if (!root.is(JsonKind::Object))
    throw InputError("expected an object, found " + root.description());
  LearningPoint point;
  std::optional<double> episodes;
  root.for_each([&](JsonValue member) {
    if (member.key() == "episodes") episodes = number_or_none(member);
    if (member.key() == "greedy") point.greedy = number_or_none(member);
    if (member.key() == "best_greedy") point.best_greedy = number_or_none(member);
    if (member.key() == "best") point.best = number_or_none(member);
    if (member.key() == "bound") point.bound = number_or_none(member);
  });
  if (!episodes) throw InputError("the key \"episodes\" is missing or null");
  point.episodes = *episodes;
  return point;
}

std::vector<double> numbers_of(JsonValue list, std::string_view place) {
  if (!list.is(JsonKind::Array)) {
    throw InputError(
        fmt::format("{}expected an array of numbers, found {}", place, list.description()));
  }
  std::vector<double> numbers;
  numbers.reserve(list.size());
  list.for_each([&](JsonValue value) {
    if (!value.is(JsonKind::Number)) {
      throw InputError(fmt::format("{}expected an array of numbers, found {} at place {}", place,
                                   value.description(), numbers.size()));
    }
    numbers.push_back(value.number());
  });
  return numbers;
}

}  // namespace

std::vector<LearningPoint> parse_training_log(std::string_view text) {
  std::vector<LearningPoint> points;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    try {
      points.push_back(learning_point(line));
    } catch (const InputError& error) {
      throw InputError(fmt::format("training log, line {}: {}", number, error.what()));
    }
  }
  if (points.empty()) throw InputError("the training log is empty");
  return points;
}

std::vector<double> parse_sample(std::string_view text) {
  const JsonDocument document = JsonDocument::parse(text);
  const JsonValue root = document.root();
  std::vector<double> rewards;
  if (root.is(JsonKind::Array)) {
    rewards = numbers_of(root, "");
  } else if (root.is(JsonKind::Object)) {
    std::optional<JsonValue> list;
    root.for_each([&](JsonValue member) {
      if (member.key() == "rewards") list = member;
    });
    if (!list)
      throw InputError("the key \"rewards\" is missing, which `orasp sample --json` writes");
    rewards = numbers_of(*list, "rewards: ");
  } else {
    throw InputError("expected what `orasp sample --json` writes, found " + root.description());
  }
  if (rewards.empty()) throw InputError("the sample holds no reward");
  return rewards;
}

}  // namespace orasp
