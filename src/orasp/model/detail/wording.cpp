#include "orasp/model/detail/wording.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>
#include <vector>

namespace orasp::detail {
namespace {

constexpr std::size_t kLongestQuote = 60;  // characters

bool is_continuation(unsigned char byte) {
  return (byte & 0xC0U) == 0x80U;
}

std::string escaped_byte(unsigned char byte) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  return {'\\', 'x', kDigits[byte >> 4U], kDigits[byte & 0xFU]};
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

}  // namespace

std::size_t character_length(std::string_view text) {
  const auto byte = [text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if (!is_continuation(byte(i))) return 0;
  }
  const unsigned char second = byte(1);
  if (first == 0xE0 && second < 0xA0) return 0;  // overlong
  if (first == 0xED && second > 0x9F) return 0;  // surrogates
  if (first == 0xF0 && second < 0x90) return 0;  // overlong
  if (first == 0xF4 && second > 0x8F) return 0;  // beyond U+10FFFF
  return length;
}

std::string in_quotes(std::string_view text) {
  std::string result = "\"";
  for (std::size_t characters = 0; !text.empty(); ++characters) {
    if (characters == kLongestQuote) {
      result += "...";
      break;
    }
    const auto byte = static_cast<unsigned char>(text[0]);
    const std::size_t length = character_length(text);
    if (byte == '"' || byte == '\\') {
      result += '\\';
      result += text[0];
    } else if (length == 0 || byte < 0x20 || byte == 0x7F) {
      result += escaped_byte(byte);
    } else {
      result += text.substr(0, length);
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return result + '"';
}

std::string key_text(std::string_view key) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  };
  const bool is_word =
      !key.empty() && key.size() <= kLongestQuote && std::ranges::all_of(key, is_plain);
  return is_word ? std::string(key) : in_quotes(key);
}

std::string number_text(double number) {
  if (std::isnan(number)) return "NaN";
  if (std::isinf(number)) return number > 0 ? "infinity" : "-infinity";
  // The shorter of 1000000 and 1e+06 is harder to read.
  const double size = std::abs(number);
  const auto form =
      size >= 1e-4 && size < 1e15 ? std::chars_format::fixed : std::chars_format::general;
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number, form).ptr;
  return {buffer.data(), end};
}

std::string rounded_text(double number) {
  // The digits behind the point of a number below the least with one digit less.
  const double size = std::abs(number);
  const int digits = size >= 100 ? 0 : size >= 10 ? 1 : 2;
  std::array<char, 400> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number,
                                 std::chars_format::fixed, digits)
                       .ptr;
  std::string text(buffer.data(), end);
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

std::string at(std::string_view place, std::string_view message) {
  std::string text(place);
  if (!place.empty()) text += ": ";
  return text.append(message);
}

std::optional<std::string_view> nearest(std::string_view name,
                                        std::span<const std::string_view> candidates) {
  constexpr std::size_t kFarthest = 2;
  std::optional<std::string_view> best;
  std::size_t least = std::min(kFarthest + 1, name.size());
  for (const std::string_view candidate : candidates) {
    if (candidate.size() > name.size() + kFarthest || name.size() > candidate.size() + kFarthest)
      continue;
    const std::size_t distance = edit_distance(name, candidate);
    if (distance < least) {
      least = distance;
      best = candidate;
    }
  }
  return best;
}

std::string suggestion(std::string_view name, std::span<const std::string_view> candidates) {
  const auto best = nearest(name, candidates);
  return best ? "; did you mean " + in_quotes(*best) + "?" : "";
}

std::string listed_in_short(std::span<const std::string_view> names) {
  constexpr std::size_t kMost = 12;
  if (names.size() <= kMost) return listed(names);
  return listed(names.first(kMost)) + " and " + std::to_string(names.size() - kMost) + " more";
}

std::string listed(std::span<const std::string_view> names) {
  std::string result;
  for (const std::string_view name : names) {
    if (!result.empty()) result += ", ";
    result += name;
  }
  return result;
}

std::string listed(std::span<const std::string_view> names, std::string_view last) {
  if (names.size() < 2) return listed(names);
  return listed(names.first(names.size() - 1)) + " " + std::string(last) + " " +
         std::string(names.back());
}

std::string quoted_list(std::span<const std::string> ids, std::string_view last) {
  std::string text;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (i > 0) text += i + 1 == ids.size() ? " " + std::string(last) + " " : ", ";
    text += in_quotes(ids[i]);
  }
  return text;
}

std::optional<std::string> id_fault(const std::string& id) {
  if (id.empty()) return "an id must not be empty";
  if (ill_formed_utf8(id)) return in_quotes(id) + " is not valid UTF-8";
  const auto control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
  if (std::ranges::any_of(id, control))
    return in_quotes(id) + " is not an id; ids hold no control characters";
  if (id.front() == ' ' || id.back() == ' ')
    return in_quotes(id) + " is not an id; ids do not begin or end with a space";
  return std::nullopt;
}

std::optional<std::size_t> ill_formed_utf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = character_length(text.substr(i));
    if (length == 0) return i;
    i += length;
  }
  return std::nullopt;
}

}  // namespace orasp::detail
