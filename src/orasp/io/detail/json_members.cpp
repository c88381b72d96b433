#include "orasp/io/detail/json_members.h"

#include <cmath>

#include <fmt/format.h>

#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"

namespace orasp::detail {

std::string Place::text() const {
  if (parent_ == nullptr) return std::string(name_);
  const std::string outer = parent_->text();
  if (index_) return fmt::format("{}[{}]", outer, *index_);
  return outer.empty() ? key_text(name_) : outer + "." + key_text(name_);
}

[[noreturn]] void fail(const Place& place, std::string_view message) {
  throw InputError(at(place.text(), message));
}

[[noreturn]] void fail_type(const Place& place, JsonValue value, std::string_view wanted) {
  fail(place, fmt::format("expected {}, found {}", wanted, value.description()));
}

bool is_comment(JsonValue member) {
  const std::string_view key = member.key();
  return key.starts_with("x-") ||
         ((key == "note" || key == "source") && member.is(JsonKind::String));
}

Members::Members(JsonValue object, const Place& place, std::span<const std::string_view> known)
    : place_(place), known_(known), values_(known.size()) {
  if (!object.is(JsonKind::Object)) fail_type(place, object, "an object");
  object.for_each([&](JsonValue member) {
    const auto found = std::ranges::find(known, member.key());
    if (found != known.end()) {
      values_[static_cast<std::size_t>(found - known.begin())] = member;
    } else if (member.key() == "note" || member.key() == "source") {
      if (!member.is(JsonKind::String)) fail_type(Place(place, member.key()), member, "a string");
    } else if (!is_comment(member)) {
      fail(place, fmt::format("unknown key {}; known keys are {}{}", in_quotes(member.key()),
                              listed(known), suggestion(member.key(), known)));
    }
  });
}

JsonValue Members::require(std::string_view key) const {
  const auto value = find(key);
  if (!value) fail(place_, fmt::format("the key {} is missing", in_quotes(key)));
  return *value;
}

std::string read_string(JsonValue value, const Place& place) {
  if (!value.is(JsonKind::String)) fail_type(place, value, "a string");
  return std::string(value.string());
}

std::string read_id(JsonValue value, const Place& place) {
  if (value.is(JsonKind::Number)) {
    fail(place, fmt::format("expected an id, which is a string, found {0}; write \"{1}\"",
                            value.description(), number_text(value.number())));
  }
  if (!value.is(JsonKind::String)) fail_type(place, value, "an id, which is a string");
  if (value.string().empty()) fail(place, "an id must not be empty");
  return std::string(value.string());
}

double read_number(JsonValue value, const Place& place) {
  if (!value.is(JsonKind::Number)) fail_type(place, value, "a number");
  return value.number();
}

std::size_t read_count(JsonValue value, const Place& place) {
  constexpr double kMost =
      9007199254740991;  // 2^53 - 1: beyond it a JSON number may not be what was written
  const bool is_number = value.is(JsonKind::Number);
  if (!is_number || value.number() < 0 || value.number() > kMost ||
      value.number() != std::floor(value.number())) {
    fail_type(place, value, "a whole number from 0 to 2^53 - 1");
  }
  return static_cast<std::size_t>(value.number());
}

bool read_flag(JsonValue value, const Place& place) {
  if (!value.is(JsonKind::Boolean)) fail_type(place, value, "true or false");
  return value.boolean();
}

std::vector<double> read_numbers(JsonValue value, const Place& place, std::size_t size) {
  const std::string wanted = fmt::format("an array of {} numbers", size);
  std::vector<double> numbers = read_array(value, place, wanted, read_number);
  if (numbers.size() != size)
    fail(place, fmt::format("expected {}, found {}", wanted, numbers.size()));
  return numbers;
}

}  // namespace orasp::detail
