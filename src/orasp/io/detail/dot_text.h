#pragma once

#include <string>
#include <string_view>

namespace orasp::detail {

/// A string of the DOT language, quotes and all. Line breaks become "\n" of labels; other control
/// characters, which XML does not allow, become '?'.
[[nodiscard]] std::string dot_string(std::string_view text);

/// At most four decimals, no trailing zeros.
[[nodiscard]] std::string short_number(double number);

}  // namespace orasp::detail
