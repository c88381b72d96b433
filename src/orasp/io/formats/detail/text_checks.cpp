#include "orasp/io/formats/detail/text_checks.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"

namespace orasp::detail {

std::string_view checked_text(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  if (text.starts_with(kMark)) text.remove_prefix(kMark.size());
  if (trimmed(text).find_first_not_of('\n') == std::string_view::npos)
    throw InputError("the file is empty");
  if (const auto byte = ill_formed_utf8(text)) {
    throw InputError(fmt::format("line {}: the byte 0x{:02x} is not valid UTF-8",
                                 line_of(text, *byte), static_cast<unsigned char>(text[*byte])));
  }
  if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos)
    throw InputError(
        fmt::format("line {}: a zero byte stands in no text file", line_of(text, zero)));
  return text;
}

std::size_t line_of(std::string_view text, std::size_t position) {
  return 1 + static_cast<std::size_t>(std::ranges::count(text.substr(0, position), '\n'));
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  text.remove_prefix(std::min(text.find_first_not_of(kBlank), text.size()));
  return text.substr(0, text.find_last_not_of(kBlank) + 1);
}

std::optional<double> number_in(std::string_view text) {
  constexpr std::string_view kBlank = " \n\t\r";
  text.remove_prefix(std::min(text.find_first_not_of(kBlank), text.size()));
  text = text.substr(0, text.find_last_not_of(kBlank) + 1);
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double number = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (fault != std::errc() || end != text.data() + text.size() || !std::isfinite(number))
    return std::nullopt;
  return number;
}

std::optional<Vector3> point_in(std::string_view text) {
  std::string plain(text);
  std::ranges::replace_if(
      plain, [](char c) { return c == ',' || c == '[' || c == ']' || c == '\n' || c == '\t'; },
      ' ');
  Vector3 point{};
  std::string_view rest = trimmed(plain);
  for (std::size_t i = 0; i < point.size(); ++i) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    const auto number = number_in(rest.substr(0, end));
    if (!number) return std::nullopt;
    point[i] = *number;
    rest = trimmed(rest.substr(end));
  }
  return rest.empty() ? std::optional(point) : std::nullopt;
}

std::string joined_ids(const std::vector<std::string>& ids, std::string_view format) {
  std::string text;
  for (const std::string& id : ids) {
    if (id.find(';') != std::string::npos) {
      throw InputError(
          fmt::format("{}: ids are listed with \";\" between them, and the id {} "
                      "holds one",
                      format, in_quotes(id)));
    }
    if (!text.empty()) text += ';';
    text += id;
  }
  return text;
}

}  // namespace orasp::detail
