#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

namespace orasp::cli {

/// The values of options, from their texts. `option` ("--seed") stands in front of error messages.
/// @throws InputError with a sentence that says what was allowed.
[[nodiscard]] std::uint64_t whole_number(
    std::string_view option, std::string_view text, std::uint64_t least,
    std::uint64_t greatest = std::numeric_limits<std::uint64_t>::max());

enum class Sign { Any, NotNegative, Positive };
/// A finite number.
[[nodiscard]] double number(std::string_view option, std::string_view text, Sign sign);

}  // namespace orasp::cli
