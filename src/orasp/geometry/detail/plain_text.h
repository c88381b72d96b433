#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

/// What is done to names of files and parts; inline, since the modules that read models do not link
/// the library.
namespace orasp::detail {

/// Without blanks at both ends.
[[nodiscard]] inline std::string trimmed(const std::string& text) {
  constexpr const char* kBlank = " \t\r\n\v\f";
  const std::size_t begin = text.find_first_not_of(kBlank);
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

/// Letters of ASCII in lower case.
[[nodiscard]] inline std::string lower(std::string_view text) {
  std::string small(text);
  std::ranges::transform(small, small.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return small;
}

}  // namespace orasp::detail
