#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace orasp::cli {

/// A whole number with commas: "4,980,736". The second takes decimal digits of any length.
[[nodiscard]] std::string grouped(std::uint64_t number);
[[nodiscard]] std::string grouped(std::string_view digits);

/// A number for people: at most six decimals, no trailing zeros: "-0.9902", "2881", "1.5e-07".
[[nodiscard]] std::string number_text(double number);
/// The same for a column: all with as many decimals as the one that needs most.
[[nodiscard]] std::vector<std::string> aligned_numbers(std::span<const double> numbers);

/// Three significant digits of a time in seconds and of a size in bytes: "0.00412 s", "96 MiB".
[[nodiscard]] std::string seconds_text(double seconds);
[[nodiscard]] std::string bytes_text(std::uint64_t bytes);

/// "1 part", "3 parts", "12,096 states": `noun` takes an s unless `number` is 1.
[[nodiscard]] std::string counted(std::uint64_t number, std::string_view noun);
[[nodiscard]] std::string counted(std::string_view digits, std::string_view noun);

/// The pieces between the commas of a list such as "a-star,beam"; one empty piece for an empty
/// text.
[[nodiscard]] std::vector<std::string> comma_separated(const std::string& list);

/// Text from outside made safe for a terminal: each control character becomes '?'.
[[nodiscard]] std::string printable(std::string_view text);
/// Printable text in double quotes, cut after 60 columns: for error messages.
[[nodiscard]] std::string in_quotes(std::string_view text);
/// Columns that UTF-8 text takes on a terminal, counting one for each code point.
[[nodiscard]] std::size_t display_width(std::string_view text);

/// Items joined by ", " and broken into lines of at most `width` columns (one item may be longer),
/// each line indented by `indent` spaces. Ends with a newline.
[[nodiscard]] std::string wrapped_list(std::span<const std::string> items, std::size_t indent,
                                       std::size_t width);
/// Items joined by ", ", cut to `width` columns: "1, 2, 3, ... (12 in all)".
[[nodiscard]] std::string capped_list(std::span<const std::string> items, std::size_t width);

/// The candidate that `word` is most likely a misspelling of; empty where none is near.
/// Reference. Damerau-Levenshtein distance, adjacent transpositions only; near: at most one change
/// in three letters.
[[nodiscard]] std::optional<std::string> nearest(std::string_view word,
                                                 std::span<const std::string> candidates);
/// `; did you mean "solve"?`, or nothing.
[[nodiscard]] std::string suggestion(std::string_view word,
                                     std::span<const std::string> candidates);

/// Columns of text, padded to their widest cell, two spaces between them.
class TextTable {
 public:
  enum class Align { Left, Right };

  void add_column(std::string title, Align align);
  /// As many cells as columns. Cells are made printable.
  void add_row(std::vector<std::string> cells);
  [[nodiscard]] bool empty() const { return rows_.empty(); }

  /// For a terminal; `bold` sets the titles in bold.
  [[nodiscard]] std::string text(bool bold) const;
  [[nodiscard]] std::string markdown() const;

 private:
  struct Column {
    std::string title;
    Align align;
    std::size_t width;
  };
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace orasp::cli
