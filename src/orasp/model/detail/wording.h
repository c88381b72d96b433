#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace orasp::detail {

/// The pieces that error sentences are made of, so that all of them read alike.

/// `text` in double quotes, fit for a terminal and for JSON: control characters and bytes that are
/// not UTF-8 are escaped, and what goes on beyond 60 characters becomes "...".
[[nodiscard]] std::string in_quotes(std::string_view text);

/// A key as it stands in a place: as it is if it is a short word, else in_quotes.
[[nodiscard]] std::string key_text(std::string_view key);

/// The shortest decimal text that reads back as the same number; "NaN", "infinity", "-infinity".
[[nodiscard]] std::string number_text(double number);

/// For people: a whole number, or no more than two digits behind the point: "0.19", "12.5", "340".
[[nodiscard]] std::string rounded_text(double number);

/// `place: message`, or the message alone where the place is empty.
[[nodiscard]] std::string at(std::string_view place, std::string_view message);

/// The candidate nearest to `name` if its edit distance (Levenshtein 1966) is at most 2 and less
/// than the length of `name`; on a tie the first.
[[nodiscard]] std::optional<std::string_view> nearest(std::string_view name,
                                                      std::span<const std::string_view> candidates);

/// `; did you mean "connections"?` or nothing.
[[nodiscard]] std::string suggestion(std::string_view name,
                                     std::span<const std::string_view> candidates);

/// The names joined by ", "; beyond twelve only how many more there are.
[[nodiscard]] std::string listed_in_short(std::span<const std::string_view> names);
/// The names joined by ", ".
[[nodiscard]] std::string listed(std::span<const std::string_view> names);
/// The same with the last two joined by the word `last`: a, b and c.
[[nodiscard]] std::string listed(std::span<const std::string_view> names, std::string_view last);

/// The ids in quotes, joined by ", ", and the last two by the word `last`: "a", "b" and "c".
[[nodiscard]] std::string quoted_list(std::span<const std::string> ids, std::string_view last);

/// What is wrong with an id: it is empty, not UTF-8, holds a control character or begins or ends
/// with a space. Ids stand in plans, one a line too: they must be readable there and come back
/// unchanged.
[[nodiscard]] std::optional<std::string> id_fault(const std::string& id);

/// Bytes of the well-formed character at the front of `text`, which is not empty; 0 if it is
/// ill-formed.
[[nodiscard]] std::size_t character_length(std::string_view text);

/// The position of the first byte that is not part of well-formed UTF-8 (RFC 3629), if there is
/// one.
[[nodiscard]] std::optional<std::size_t> ill_formed_utf8(std::string_view text);

}  // namespace orasp::detail
