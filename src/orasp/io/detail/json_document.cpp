#include "orasp/io/detail/json_document.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"

namespace orasp::detail {
namespace {

/// "line 3, column 7" of a byte; columns count characters.
std::string text_position(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, byte);
  const auto line = std::ranges::count(before, '\n') + 1;
  const std::size_t line_begin =
      before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
  const auto characters = std::ranges::count_if(before.substr(line_begin), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
  });
  return fmt::format("line {}, column {}", line, characters + 1);
}

[[noreturn]] void fail_at(std::string_view text, std::size_t byte, std::string_view message) {
  throw InputError(at(text_position(text, byte), message));
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t i = text.find(from); i != std::string::npos;
       i = text.find(from, i + to.size())) {
    text.replace(i, from.size(), to);
  }
}

/// The word that begins at a byte (letters, digits, signs), or the one character there.
std::string_view word_at(std::string_view text, std::size_t byte) {
  const auto is_part = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '+' ||
           c == '-' || c == '.' || c == '_' || static_cast<unsigned char>(c) >= 0x80;
  };
  std::size_t end = byte;
  while (end < text.size() && is_part(text[end])) ++end;
  return text.substr(byte, std::max(end, byte + 1) - byte);
}

/// Where the literal begins that the parser gave up on when it had read `byte`: it reads on as long
/// as the text could become true, false or null.
std::size_t literal_begin(std::string_view text, std::size_t byte) {
  for (const std::string_view literal : {"true", "false", "null"}) {
    for (std::size_t length = std::min(literal.size() - 1, byte); length > 0; --length) {
      if (text.substr(byte - length, length) == literal.substr(0, length)) return byte - length;
    }
  }
  return byte;
}

/// Throws the parser's message about the byte at `position` (from 1), said in words of ours.
[[noreturn]] void rethrow(std::string_view text, std::size_t position, std::string message) {
  // "[json.exception...] parse error at line 1, column 5: syntax error while parsing object key -
  // unexpected ..."
  const bool in_key = message.find("while parsing object key") != std::string::npos;
  const std::size_t byte = std::min(position, text.size()) - std::min<std::size_t>(position, 1);
  if (message.find("unexpected end of input") != std::string::npos) {
    fail_at(text, text.size(), "the text ends too early");
  }
  const bool is_literal = message.find("invalid literal") != std::string::npos;
  const bool overflows = message.find("number overflow") != std::string::npos;
  if (is_literal || overflows) {
    std::size_t begin = literal_begin(text, byte);
    if (overflows) begin = text.find_last_of(" \t\r\n[,:", byte) + 1;  // npos + 1 is 0
    const std::string_view word = word_at(text, begin);
    std::string sentence = in_quotes(word);
    if (overflows) {
      sentence = "the number " + sentence + " is too large";
    } else if (word == "/" || word == "#") {
      sentence += " is not JSON, which has no comments; use the key \"note\"";
    } else if (word == "'") {
      sentence += " is not JSON; strings stand in double quotes";
    } else if (in_key) {
      sentence += " is not a key; keys stand in double quotes";
    } else if (word == "NaN" || word == "Infinity") {
      sentence += " is not JSON, which has finite numbers only";
    } else {
      sentence += " is not a JSON value";
    }
    fail_at(text, begin, sentence);
  }
  const std::size_t dash = message.find(" - ");
  if (dash != std::string::npos) message.erase(0, dash + 3);
  message.erase(std::min(message.find("; last read: "), message.size()));
  for (const auto& [from, to] : {
           std::pair<std::string_view, std::string_view>{"expected string literal",
                                                         "expected a key in quotes"},
           {"unexpected a key in quotes", "unexpected string"},
           {"expected end of input", "expected nothing more"},
           {"; expected '}'", "; expected ',' or '}'"},
           {"; expected ']'", "; expected ',' or ']'"},
           {"'[', '{', or a literal", "a value"},
           {" literal", ""},
       }) {
    replace_all(message, from, to);
  }
  fail_at(text, byte, message);
}

}  // namespace

/// Receives nlohmann's parser events and lays the values out.
class JsonBuilder {
 public:
  JsonBuilder(JsonDocument& document, std::string_view text,
              std::span<const JsonDocument::ArrayLimit> limits)
      : document_(document), source_(text), limits_(limits) {}

  bool null() { return add(JsonKind::Null), true; }
  bool boolean(bool value) { return add(JsonKind::Boolean).number = value ? 1 : 0, true; }
  bool number_integer(std::int64_t value) {
    return add(JsonKind::Number).number = static_cast<double>(value), true;
  }
  bool number_unsigned(std::uint64_t value) {
    return add(JsonKind::Number).number = static_cast<double>(value), true;
  }
  bool number_float(double value, const std::string&) {
    return add(JsonKind::Number).number = value, true;
  }
  bool string(std::string& value) {
    const JsonDocument::Slice slice = stored(value);
    add(JsonKind::String).string = slice;
    return true;
  }
  static bool binary(nlohmann::json::binary_t&) { return false; }  // never in a JSON text
  bool start_object(std::size_t) { return open(JsonKind::Object); }
  bool start_array(std::size_t) { return open(JsonKind::Array); }
  bool key(std::string& value) {
    key_ = stored(value);
    return true;
  }
  bool end_object() {
    require_distinct_keys();
    return close();
  }
  bool end_array() { return close(); }
  bool parse_error(std::size_t position, const std::string&,
                   const nlohmann::json::exception& error) {
    rethrow(source_, position, error.what());
  }

 private:
  struct Frame {
    std::size_t node;
    std::size_t size;
    std::size_t most;  ///< elements
  };

  JsonDocument::Slice stored(const std::string& value) {
    const JsonDocument::Slice slice{static_cast<std::uint32_t>(document_.text_.size()),
                                    static_cast<std::uint32_t>(value.size())};
    document_.text_ += value;
    return slice;
  }

  JsonDocument::Node& add(JsonKind kind) {
    auto& nodes = document_.nodes_;
    if (nodes.size() == kMaxJsonValues) {
      throw InputError(fmt::format("the file holds more than {} values", kMaxJsonValues));
    }
    if (!frames_.empty() && ++frames_.back().size > frames_.back().most) {
      const std::string_view list = document_.text(nodes[frames_.back().node].key);
      throw InputError(fmt::format("{0}: more than {1} {0}, the most a problem may have", list,
                                   frames_.back().most));
    }
    JsonDocument::Node& node = nodes.emplace_back();
    node.kind = kind;
    node.key = std::exchange(key_, {});
    node.next = static_cast<std::uint32_t>(nodes.size());
    return node;
  }

  bool open(JsonKind kind) {
    if (frames_.size() == kMaxJsonDepth) {
      throw InputError(
          fmt::format("arrays and objects are nested more than {} deep", kMaxJsonDepth));
    }
    const JsonDocument::Slice key = key_;
    add(kind);
    std::size_t most = kMaxJsonValues;
    if (frames_.size() == 1 && kind == JsonKind::Array) {
      const auto limit =
          std::ranges::find(limits_, document_.text(key), &JsonDocument::ArrayLimit::key);
      if (limit != limits_.end()) most = limit->most;
    }
    frames_.push_back({document_.nodes_.size() - 1, 0, most});
    return true;
  }

  bool close() {
    document_.nodes_[frames_.back().node].next =
        static_cast<std::uint32_t>(document_.nodes_.size());
    frames_.pop_back();
    return true;
  }

  void require_distinct_keys() {
    keys_.clear();
    const std::size_t end = document_.nodes_.size();
    for (std::size_t child = frames_.back().node + 1; child < end;
         child = document_.nodes_[child].next) {
      keys_.push_back(document_.text(document_.nodes_[child].key));
    }
    std::ranges::sort(keys_);
    const auto twice = std::ranges::adjacent_find(keys_);
    if (twice != keys_.end()) {
      throw InputError(at(place(), fmt::format("the key {} appears twice", in_quotes(*twice))));
    }
  }

  /// Where the innermost open container stands, as "connections[3].parts".
  [[nodiscard]] std::string place() const {
    std::string text;
    for (std::size_t i = 1; i < frames_.size(); ++i) {
      if (document_.nodes_[frames_[i - 1].node].kind == JsonKind::Array) {
        text += fmt::format("[{}]", frames_[i - 1].size - 1);
      } else {
        if (!text.empty()) text += '.';
        text += key_text(document_.text(document_.nodes_[frames_[i].node].key));
      }
    }
    return text;
  }

  JsonDocument& document_;
  std::string_view source_;
  std::span<const JsonDocument::ArrayLimit> limits_;
  std::vector<Frame> frames_;
  std::vector<std::string_view> keys_;
  JsonDocument::Slice key_;
};

JsonDocument JsonDocument::parse(std::string_view text, std::span<const ArrayLimit> limits) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  if (text.size() > kMaxJsonBytes) throw InputError("the text is larger than 256 MiB");
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos)
    throw InputError("the file is empty");
  if (const auto byte = ill_formed_utf8(text)) {
    fail_at(text, *byte,
            fmt::format("the byte 0x{:02x} is not valid UTF-8",
                        static_cast<unsigned char>(text[*byte])));
  }
  if (const std::size_t byte = text.find('\0'); byte != std::string_view::npos) {
    fail_at(text, byte, "a NUL byte is not allowed");
  }
  JsonDocument document;
  JsonBuilder builder(document, text, limits);
  (void)nlohmann::json::sax_parse(text.begin(), text.end(), &builder);
  return document;
}

JsonKind JsonValue::kind() const {
  return document_->nodes_[node_].kind;
}
double JsonValue::number() const {
  return document_->nodes_[node_].number;
}
bool JsonValue::boolean() const {
  return document_->nodes_[node_].number != 0;
}
std::string_view JsonValue::string() const {
  return document_->text(document_->nodes_[node_].string);
}
std::string_view JsonValue::key() const {
  return document_->text(document_->nodes_[node_].key);
}

std::size_t JsonValue::size() const {
  std::size_t children = 0;
  for_each([&children](JsonValue) { ++children; });
  return children;
}

std::string JsonValue::description() const {
  switch (kind()) {
    case JsonKind::Null: return "null";
    case JsonKind::Boolean: return boolean() ? "true" : "false";
    case JsonKind::Number: return "the number " + number_text(number());
    case JsonKind::String: return "the string " + in_quotes(string());
    case JsonKind::Array: return size() == 0 ? "an empty array" : "an array";
    case JsonKind::Object: break;
  }
  return "an object";
}

}  // namespace orasp::detail
