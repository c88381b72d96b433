#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace orasp::cli {

/// The values of options, from their texts. `option` ("--seed") stands in front of error messages.
/// @throws InputError with a sentence that says what was allowed.
[[nodiscard]] std::uint64_t whole_number(
    std::string_view option, std::string_view text, std::uint64_t least,
    std::uint64_t greatest = std::numeric_limits<std::uint64_t>::max());

/// Whole numbers, separated by commas.
[[nodiscard]] std::vector<std::size_t> whole_numbers(std::string_view option, std::string_view text,
                                                     std::uint64_t least, std::uint64_t greatest);

/// Share: from 0 to 1.
enum class Sign { Any, NotNegative, Positive, Share };
/// A finite number.
[[nodiscard]] double number(std::string_view option, std::string_view text, Sign sign);

}  // namespace orasp::cli
