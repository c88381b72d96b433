#include "cli/output/text.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace orasp::cli {
namespace {

constexpr int kDecimals = 6;

/// Outside this range decimals say little, and powers of ten are used.
bool fits_decimals(double number) {
  const double magnitude = std::abs(number);
  return number == 0 || (magnitude >= 1e-4 && magnitude < 1e12);
}

std::string fixed(double number, int decimals) {
  std::string text = fmt::format("{:.{}f}", number, decimals);
  if (text.find_first_not_of("-0.") == std::string::npos && text.front() == '-')
    text.erase(0, 1);  // no "-0"
  return text;
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last(b.size() + 1);
  std::vector<std::size_t> last(b.size() + 1);
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = a[i - 1] == b[j - 1] ? 0 : 1;
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + change});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
    std::swap(before_last, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

void pad(std::string& text, std::size_t columns) {
  text.append(columns, ' ');
}

}  // namespace

std::string grouped(std::string_view digits) {
  std::string text;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += ',';
    text += digits[i];
  }
  return text;
}

std::string grouped(std::uint64_t number) {
  return grouped(std::string_view(fmt::to_string(number)));
}

std::vector<std::string> comma_separated(const std::string& list) {
  std::vector<std::string> pieces;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    pieces.push_back(list.substr(begin, end - begin));
    begin = end + 1;
  }
  return pieces;
}

std::string number_text(double number) {
  if (!std::isfinite(number) || !fits_decimals(number)) return fmt::format("{:.6g}", number);
  std::string text = fixed(number, kDecimals);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

std::vector<std::string> aligned_numbers(std::span<const double> numbers) {
  std::size_t decimals = 0;
  for (const double number : numbers) {
    const std::string text = number_text(number);
    const std::size_t point = text.find('.');
    if (point != std::string::npos && fits_decimals(number))
      decimals = std::max(decimals, text.size() - point - 1);
  }
  std::vector<std::string> texts;
  texts.reserve(numbers.size());
  for (const double number : numbers) {
    const bool plain = std::isfinite(number) && fits_decimals(number);
    texts.push_back(plain ? fixed(number, static_cast<int>(decimals)) : number_text(number));
  }
  return texts;
}

std::string seconds_text(double seconds) {
  if (seconds >= 100) return fmt::format("{:.0f} s", seconds);
  if (seconds < 1e-6) return "0 s";
  const int digits_before = static_cast<int>(std::floor(std::log10(seconds))) + 1;
  return fmt::format("{:.{}f} s", seconds, std::min(3 - digits_before, kDecimals));
}

std::string bytes_text(std::uint64_t bytes) {
  constexpr double kStep = 1024;
  auto size = static_cast<double>(bytes);
  const char* unit = "bytes";
  for (const char* larger : {"KiB", "MiB", "GiB", "TiB"}) {
    if (size < kStep) break;
    size /= kStep;
    unit = larger;
  }
  return size < 10 && bytes >= 1024 ? fmt::format("{:.1f} {}", size, unit)
                                    : fmt::format("{:.0f} {}", size, unit);
}

std::string counted(std::string_view digits, std::string_view noun) {
  return fmt::format("{} {}{}", grouped(digits), noun, digits == "1" ? "" : "s");
}

std::string counted(std::uint64_t number, std::string_view noun) {
  return counted(std::string_view(fmt::to_string(number)), noun);
}

std::string printable(std::string_view text) {
  std::string safe(text);
  for (std::size_t i = 0; i < safe.size(); ++i) {
    const auto byte = static_cast<unsigned char>(safe[i]);
    if (byte < 0x20 || byte == 0x7f) safe[i] = '?';
    // U+0080 to U+009F are control characters too; in UTF-8 they are C2 80 to C2 9F.
    const bool second_of_c1 = byte >= 0x80 && byte <= 0x9f && i > 0 && safe[i - 1] == '\xc2';
    if (second_of_c1) safe.replace(--i, 2, "?");
  }
  return safe;
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  std::string safe = printable(text);
  std::size_t columns = 0;
  for (std::size_t i = 0; i < safe.size(); ++i) {
    const bool starts_character = (static_cast<unsigned char>(safe[i]) & 0xc0U) != 0x80U;
    if (starts_character && columns++ == kLongest) {
      safe.resize(i);
      safe += "...";
      break;
    }
  }
  return '"' + safe + '"';
}

std::size_t display_width(std::string_view text) {
  const auto is_ascii = [](char c) { return static_cast<unsigned char>(c) < 0x80U; };
  if (std::ranges::all_of(text, is_ascii)) return text.size();
  // fmt knows which characters take two columns: it is asked how much it would add to fill a width.
  const std::size_t most = 2 * text.size();
  return most - (fmt::formatted_size("{:<{}}", text, most) - text.size());
}

std::string wrapped_list(std::span<const std::string> items, std::size_t indent,
                         std::size_t width) {
  std::string text;
  std::size_t column = 0;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::string item = printable(items[i]) + (i + 1 < items.size() ? "," : "");
    const std::size_t needed = display_width(item) + 1;
    if (column > 0 && column + needed > width) {
      text += '\n';
      column = 0;
    }
    if (column == 0) {
      pad(text, indent);
      column = indent + needed - 1;
    } else {
      text += ' ';
      column += needed;
    }
    text += item;
  }
  return text + '\n';
}

std::string capped_list(std::span<const std::string> items, std::size_t width) {
  std::string all;
  for (const std::string& item : items) all += (all.empty() ? "" : ", ") + printable(item);
  if (display_width(all) <= width) return all;
  const std::string end = fmt::format("... ({} in all)", items.size());
  std::string text;
  for (const std::string& item : items) {
    const std::string next = printable(item) + ", ";
    if (display_width(text) + display_width(next) + end.size() > width) break;
    text += next;
  }
  return text + end;
}

std::optional<std::string> nearest(std::string_view word, std::span<const std::string> candidates) {
  std::optional<std::string> best;
  std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < least) {
      least = distance;
      best = candidate;
    }
  }
  return best;
}

std::string suggestion(std::string_view word, std::span<const std::string> candidates) {
  const std::optional<std::string> best = nearest(word, candidates);
  return best ? fmt::format("; did you mean {}?", in_quotes(*best)) : std::string();
}

void TextTable::add_column(std::string title, Align align) {
  const std::size_t width = display_width(title);
  columns_.push_back({std::move(title), align, width});
}

void TextTable::add_row(std::vector<std::string> cells) {
  for (std::size_t c = 0; c < cells.size(); ++c) {
    cells[c] = printable(cells[c]);
    columns_[c].width = std::max(columns_[c].width, display_width(cells[c]));
  }
  rows_.push_back(std::move(cells));
}

std::string TextTable::text(bool bold) const {
  std::string text;
  const auto add_line = [&](const auto& cell) {
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const std::string& value = cell(c);
      const std::size_t space = columns_[c].width - display_width(value);
      if (c > 0) pad(text, 2);
      if (columns_[c].align == Align::Right) pad(text, space);
      text += value;
      if (columns_[c].align == Align::Left && c + 1 < columns_.size()) pad(text, space);
    }
    text.erase(text.find_last_not_of(' ') + 1);
  };
  text += bold ? "\x1b[1m" : "";
  add_line([&](std::size_t c) -> const std::string& { return columns_[c].title; });
  text += bold ? "\x1b[0m\n" : "\n";
  for (const auto& row : rows_) {
    add_line([&](std::size_t c) -> const std::string& { return row[c]; });
    text += '\n';
  }
  return text;
}

std::string TextTable::markdown() const {
  std::string text = "|";
  for (const Column& column : columns_) text += fmt::format(" {} |", column.title);
  text += "\n|";
  for (const Column& column : columns_) text += column.align == Align::Right ? " ---: |" : " --- |";
  text += '\n';
  for (const auto& row : rows_) {
    text += '|';
    for (const std::string& cell : row) {
      text += ' ';
      for (const char c : cell) text += c == '|' ? std::string("\\|") : std::string(1, c);
      text += " |";
    }
    text += '\n';
  }
  return text;
}

}  // namespace orasp::cli
