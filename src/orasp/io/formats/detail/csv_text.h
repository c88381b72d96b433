#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace orasp::detail {

/// One line of a table, with the number of the line on which it begins, from 1.
struct CsvRow {
  std::size_t line = 0;
  std::vector<std::string> cells{};
  /// Whether there is nothing but spaces in it.
  [[nodiscard]] bool blank() const;
};

/// Cuts a text into cells (RFC 4180): quotes around what holds separators, doubled inside. The
/// separator is the first of ',', ';' and tab outside of quotes. Spaces around cells without quotes
/// are taken off. @throws InputError with the line.
[[nodiscard]] std::vector<CsvRow> csv_rows(std::string_view text);

/// A line of a table, with commas, quotes where they are needed, and a line feed.
[[nodiscard]] std::string csv_line(const std::vector<std::string>& cells);

}  // namespace orasp::detail
