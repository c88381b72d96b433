#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "orasp/io/detail/json_document.h"

/// The kit that reads JSON objects member by member. Every fault becomes one sentence that says
/// where it stands.
namespace orasp::detail {

/// Where a value stands in the file. Places live on the stack, each pointing to the one around it,
/// and become text only for a message: files have millions of them.
class Place {
 public:
  explicit Place(std::string_view name) : name_(name) {}
  Place(const Place& parent, std::string_view key) : parent_(&parent), name_(key) {}
  Place(const Place& parent, std::size_t index) : parent_(&parent), index_(index) {}

  [[nodiscard]] std::string text() const;

 private:
  const Place* parent_ = nullptr;
  std::string_view name_;
  std::optional<std::size_t> index_;
};

[[noreturn]] void fail(const Place& place, std::string_view message);
[[noreturn]] void fail_type(const Place& place, JsonValue value, std::string_view wanted);

/// Keys that any object may have and that mean nothing to a planner.
bool is_comment(JsonValue member);

/// The members of one JSON object whose keys are known. Owns nothing.
class Members {
 public:
  /// @throws InputError if `object` is not an object or has a key that is neither known nor a
  /// comment.
  Members(JsonValue object, const Place& place, std::span<const std::string_view> known);

  [[nodiscard]] std::optional<JsonValue> find(std::string_view key) const {
    return values_[static_cast<std::size_t>(std::ranges::find(known_, key) - known_.begin())];
  }
  [[nodiscard]] JsonValue require(std::string_view key) const;

  /// Reads `key` with `read(value, place)` into `target` if it is there; `target` keeps its default
  /// if not.
  template <class Target, class Read>
  void read(std::string_view key, Target& target, Read&& read) const {
    if (const auto value = find(key)) target = read(*value, Place(place_, key));
  }
  template <class Read>
  [[nodiscard]] auto read_required(std::string_view key, Read&& read) const {
    return read(require(key), Place(place_, key));
  }

 private:
  const Place& place_;
  std::span<const std::string_view> known_;
  std::vector<std::optional<JsonValue>> values_;
};

std::string read_string(JsonValue value, const Place& place);
std::string read_id(JsonValue value, const Place& place);
double read_number(JsonValue value, const Place& place);
std::size_t read_count(JsonValue value, const Place& place);
bool read_flag(JsonValue value, const Place& place);

template <class Read>
auto read_array(JsonValue value, const Place& place, std::string_view wanted, Read&& read) {
  if (!value.is(JsonKind::Array)) fail_type(place, value, wanted);
  std::vector<decltype(read(value, place))> elements;
  value.for_each(
      [&](JsonValue element) { elements.push_back(read(element, Place(place, elements.size()))); });
  return elements;
}

/// The members of an object whose keys are names of the user's own; comments are left out.
template <class Read>
auto read_by_name(JsonValue value, const Place& place, std::string_view wanted, Read&& read) {
  if (!value.is(JsonKind::Object)) fail_type(place, value, wanted);
  std::map<std::string, decltype(read(value, place))> values;
  value.for_each([&](JsonValue member) {
    if (is_comment(member)) return;
    values.emplace(std::string(member.key()), read(member, Place(place, member.key())));
  });
  return values;
}

/// The numbers of an array that must have `size` of them.
std::vector<double> read_numbers(JsonValue value, const Place& place, std::size_t size);

template <std::size_t N>
std::array<double, N> read_point(JsonValue value, const Place& place) {
  const std::vector<double> numbers = read_numbers(value, place, N);
  std::array<double, N> point{};
  std::ranges::copy(numbers, point.begin());
  return point;
}

}  // namespace orasp::detail
