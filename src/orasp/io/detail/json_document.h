#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace orasp::detail {

/// The largest text, number of values and depth that is read: a hostile file must not take the
/// machine's memory.
inline constexpr std::size_t kMaxJsonBytes = std::size_t{256} << 20U;
inline constexpr std::size_t kMaxJsonValues = 16'000'000;
inline constexpr std::size_t kMaxJsonDepth = 64;

enum class JsonKind : std::uint8_t { Null, Boolean, Number, String, Array, Object };

class JsonDocument;

/// One value of a document: a cheap view, valid as long as the document.
class JsonValue {
 public:
  [[nodiscard]] JsonKind kind() const;
  [[nodiscard]] bool is(JsonKind wanted) const { return kind() == wanted; }
  [[nodiscard]] double number() const;            ///< of a number; the nearest double
  [[nodiscard]] bool boolean() const;             ///< of a boolean
  [[nodiscard]] std::string_view string() const;  ///< of a string
  [[nodiscard]] std::string_view key() const;     ///< where the value is a member of an object
  [[nodiscard]] std::size_t size() const;         ///< elements of an array, members of an object
  /// What stands there, for messages: `the string "abc"`, `the number 3`, `an array`.
  [[nodiscard]] std::string description() const;

  /// Calls `visit(JsonValue)` for each element or member, in the order of the text.
  template <class Visit>
  void for_each(Visit&& visit) const;

 private:
  friend class JsonDocument;
  JsonValue(const JsonDocument& document, std::size_t node) : document_(&document), node_(node) {}

  const JsonDocument* document_;
  std::size_t node_;
};

/// A parsed JSON text as one flat array of values in the order of the text, each knowing where its
/// successor begins. Nothing is nested in memory, so no input can make it recurse; 32 bytes a
/// value. Owns copies of all strings.
///
/// Stricter than JSON where a second reading would be a guess: a key that appears twice in an
/// object is an error, so is a NUL byte. A byte order mark at the front is skipped.
class JsonDocument {
 public:
  /// The array under key `key` of the outermost object may have at most `most` elements; checked
  /// while reading.
  struct ArrayLimit {
    std::string_view key;
    std::size_t most;
  };

  /// @throws InputError with one sentence; for malformed JSON it begins with "line L, column C: ".
  [[nodiscard]] static JsonDocument parse(std::string_view text,
                                          std::span<const ArrayLimit> limits = {});

  [[nodiscard]] JsonValue root() const { return {*this, 0}; }

 private:
  friend class JsonValue;
  friend class JsonBuilder;

  /// A piece of text_.
  struct Slice {
    std::uint32_t begin = 0;
    std::uint32_t length = 0;
  };
  struct Node {
    double number = 0;       ///< numbers; 0 or 1 of booleans
    Slice key;               ///< members of objects
    Slice string;            ///< strings
    std::uint32_t next = 0;  ///< the first node behind this value and all that it holds
    JsonKind kind = JsonKind::Null;
  };

  [[nodiscard]] std::string_view text(Slice slice) const {
    return std::string_view(text_).substr(slice.begin, slice.length);
  }

  std::vector<Node> nodes_;
  std::string text_;
};

template <class Visit>
void JsonValue::for_each(Visit&& visit) const {
  const std::size_t end = document_->nodes_[node_].next;
  for (std::size_t child = node_ + 1; child < end; child = document_->nodes_[child].next) {
    visit(JsonValue(*document_, child));
  }
}

}  // namespace orasp::detail
