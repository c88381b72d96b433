#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/model/vector3.h"

/// What the readers of plain formats share.
namespace orasp::detail {

/// Refuses a text that is empty, is not UTF-8 or holds a zero byte; a byte order mark at the front
/// is skipped. @returns the text behind it. @throws InputError.
[[nodiscard]] std::string_view checked_text(std::string_view text);

/// The line of a byte, from 1. O(position).
[[nodiscard]] std::size_t line_of(std::string_view text, std::size_t position);

/// The text without spaces, tabs and carriage returns at its ends.
[[nodiscard]] std::string_view trimmed(std::string_view text);

/// The whole text as a finite number; nothing where it is none. Spaces around it are skipped.
[[nodiscard]] std::optional<double> number_in(std::string_view text);

/// Three numbers with commas or spaces between them, in square brackets or not.
[[nodiscard]] std::optional<Vector3> point_in(std::string_view text);

/// Ids in one text with ';' between them, as lists stand in cells and ports.
/// @throws InputError where an id holds one: `format` cannot tell them apart then.
[[nodiscard]] std::string joined_ids(const std::vector<std::string>& ids, std::string_view format);

}  // namespace orasp::detail
