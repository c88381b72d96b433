#include "orasp/io/formats/detail/csv_text.h"

#include <algorithm>

#include <fmt/format.h>

#include "orasp/io/formats/detail/text_checks.h"
#include "orasp/model/error.h"

namespace orasp::detail {
namespace {

char separator_of(std::string_view text) {
  bool quoted = false;
  for (const char c : text) {
    if (c == '"') quoted = !quoted;
    if (!quoted && (c == ',' || c == ';' || c == '\t')) return c;
  }
  return ',';
}

}  // namespace

bool CsvRow::blank() const {
  return std::ranges::all_of(cells, [](const std::string& cell) { return cell.empty(); });
}

std::vector<CsvRow> csv_rows(std::string_view text) {
  const char separator = separator_of(text);
  std::vector<CsvRow> rows;
  std::size_t line = 1;
  std::size_t at = 0;
  while (at < text.size()) {
    CsvRow row{.line = line};
    for (bool more = true; more;) {
      std::string cell;
      while (at < text.size() && text[at] == ' ') ++at;
      if (at < text.size() && text[at] == '"') {
        const std::size_t begin = line;
        for (++at;; ++at) {
          if (at >= text.size()) {
            throw InputError(fmt::format("line {}: a quote is opened and never closed", begin));
          }
          if (text[at] == '"' && (at + 1 == text.size() || text[at + 1] != '"')) break;
          if (text[at] == '"') ++at;
          if (text[at] == '\n') ++line;
          cell += text[at];
        }
        ++at;
        const std::size_t end =
            std::min(text.find_first_of(std::string{separator, '\n'}, at), text.size());
        if (!trimmed(text.substr(at, end - at)).empty()) {
          throw InputError(fmt::format("line {}: a cell goes on behind its closing quote", line));
        }
        at = end;
      } else {
        const std::size_t end =
            std::min(text.find_first_of(std::string{separator, '\n'}, at), text.size());
        cell = trimmed(text.substr(at, end - at));
        at = end;
      }
      row.cells.push_back(std::move(cell));
      more = at < text.size() && text[at] == separator;
      if (at < text.size()) {
        if (text[at] == '\n') ++line;
        ++at;
      }
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string csv_line(const std::vector<std::string>& cells) {
  std::string text;
  for (const std::string& cell : cells) {
    if (&cell != &cells.front()) text += ',';
    const bool quoted = cell.find_first_of("\",;\t\r\n") != std::string::npos ||
                        cell.starts_with(' ') || cell.ends_with(' ');
    if (!quoted) {
      text += cell;
      continue;
    }
    text += '"';
    for (const char c : cell) {
      if (c == '"') text += '"';
      text += c;
    }
    text += '"';
  }
  return text + '\n';
}

}  // namespace orasp::detail
