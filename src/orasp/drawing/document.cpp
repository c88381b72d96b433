#include "orasp/drawing/document.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace orasp {
namespace {

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};

constexpr std::string_view kStyle =
    R"(
:root { color-scheme: light dark; --ink: #1f2328; --soft: #59636e; --line: #d1d9e0; --ground: )"
    R"(#fff; --shade: #f6f8fa }
@media (prefers-color-scheme: dark) { :root { --ink: #e6edf3; --soft: #9198a1; --line: #3d444d; )"
    R"(--ground: #0d1117; --shade: #151b23 } }
body { margin: 0 auto; padding: 1.5rem 1rem 4rem; max-width: 62rem; color: var(--ink); )"
    R"(background: var(--ground); font: 16px/1.5 system-ui, Helvetica, Arial, sans-serif }
h1 { font-size: 1.7rem; line-height: 1.25 } h2 { margin-top: 2.5rem; font-size: 1.25rem; )"
    R"(border-bottom: 1px solid var(--line) }
code { font-size: .9em; background: var(--shade); border-radius: .25em; padding: .1em .3em }
.table { overflow-x: auto } table { border-collapse: collapse; font-size: .85rem; )"
    R"(font-variant-numeric: tabular-nums }
th, td { padding: .25rem .6rem; border-bottom: 1px solid var(--line); text-align: left; )"
    R"(vertical-align: bottom }
td { white-space: nowrap }
th { color: var(--soft); font-weight: 600; border-bottom-width: 2px } .r { text-align: right }
.row { display: flex; flex-wrap: wrap; gap: 1rem; margin: 1rem 0; align-items: end }
figure { margin: 0; flex: 0 1 auto; min-width: min(8rem, 100%) }
figure > svg { display: block; width: 100%; height: auto; background: #fff; border-radius: .4rem }
figcaption { color: var(--soft); font-size: .85rem; margin-top: .3rem }
@media (max-width: 40rem) { figure { width: 100% !important } }
@media print { body { max-width: none; font-size: 10pt } figure, tr { break-inside: avoid } h2 )"
    R"({ break-after: avoid } }
)";

std::string html_text(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&': result += "&amp;"; break;
      case '<': result += "&lt;"; break;
      case '>': result += "&gt;"; break;
      case '"': result += "&quot;"; break;
      case '\'': result += "&#39;"; break;
      default: result += static_cast<unsigned char>(c) < 0x20 && c != '\n' ? '?' : c;
    }
  }
  return result;
}

/// Calls text(piece) and code(piece) for what stands outside and inside backquotes. A last one
/// alone is text.
template <class Text, class Code>
std::string with_code(std::string_view all, Text text, Code code) {
  std::string result;
  while (true) {
    const std::size_t begin = all.find('`');
    const std::size_t end = begin == std::string_view::npos ? begin : all.find('`', begin + 1);
    if (end == std::string_view::npos) return result + text(all);
    result += text(all.substr(0, begin));
    result += code(all.substr(begin + 1, end - begin - 1));
    all.remove_prefix(end + 1);
  }
}

std::string html_line(std::string_view text) {
  return with_code(text, html_text,
                   [](std::string_view code) { return "<code>" + html_text(code) + "</code>"; });
}

/// Markdown in which nothing of `text` is markup.
std::string markdown_text(std::string_view text) {
  constexpr std::string_view kMarkup = "\\*_[]<>|#~&$";
  std::string result;
  for (const char c : text) {
    if (kMarkup.find(c) != std::string_view::npos) result += '\\';
    result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return result;
}

std::string markdown_line(std::string_view text) {
  return with_code(text, markdown_text, [](std::string_view code) {
    std::string result = "`";
    for (const char c : code) result += c == '|' ? "\\|" : std::string(1, c);
    return result + '`';
  });
}

/// A number, with commas, a sign or an exponent; or a sign for none.
bool is_number(const std::string& cell) {
  return cell.empty() || cell == "-" ||
         (cell.find_first_not_of("0123456789.,+-e") == std::string::npos &&
          cell.find_first_of("0123456789") != std::string::npos);
}

}  // namespace

void Document::table(std::vector<std::string> head, std::vector<std::vector<std::string>> rows) {
  std::vector<bool> right(head.size());
  for (std::size_t column = 1; column < head.size(); ++column) {
    right[column] = std::ranges::all_of(
        rows, [&](const std::vector<std::string>& row) { return is_number(row[column]); });
  }
  blocks_.emplace_back(Table{std::move(head), std::move(rows), std::move(right)});
}

std::vector<const DocumentFigure*> Document::pictures() const {
  std::vector<const DocumentFigure*> all;
  for (const Block& block : blocks_) {
    if (const auto* const row = std::get_if<Row>(&block)) {
      for (const DocumentFigure& figure : row->figures) all.push_back(&figure);
    }
  }
  return all;
}

std::string Document::html() const {
  std::string page = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{0}</title>\n<style>{1}</style>\n</head>\n<body>\n<h1>{0}</h1>\n",
      html_text(title_), kStyle);
  std::size_t pictures = 0;
  const auto table_row = [](const std::vector<std::string>& cells, const std::vector<bool>& right,
                            std::string_view element) {
    std::string text = "<tr>";
    for (std::size_t i = 0; i < cells.size(); ++i) {
      text += fmt::format("<{0}{1}>{2}</{0}>", element, right[i] ? " class=\"r\"" : "",
                          html_line(cells[i]));
    }
    return text + "</tr>\n";
  };
  const Overloaded write = {
      [&](const Heading& block) { page += "<h2>" + html_line(block.text) + "</h2>\n"; },
      [&](const Paragraph& block) { page += "<p>" + html_line(block.text) + "</p>\n"; },
      [&](const Table& block) {
        page += "<div class=\"table\"><table>\n<thead>" + table_row(block.head, block.right, "th") +
                "</thead>\n<tbody>\n";
        for (const auto& row : block.rows) page += table_row(row, block.right, "td");
        page += "</tbody></table></div>\n";
      },
      [&](const Row& block) {
        page += "<div class=\"row\">\n";
        for (const DocumentFigure& figure : block.figures) {
          page += fmt::format(
              "<figure style=\"width:calc({}% - 1rem)\">{}<figcaption>{}</figcaption></figure>\n",
              figure.width, inline_svg(figure.svg, fmt::format("f{}-", ++pictures)),
              html_line(figure.caption));
        }
        page += "</div>\n";
      }};
  for (const Block& block : blocks_) std::visit(write, block);
  return page + "</body>\n</html>\n";
}

std::string Document::markdown(std::string_view folder) const {
  std::string text = "# " + markdown_text(title_) + "\n";
  const auto line = [](const std::vector<std::string>& cells) {
    std::string row = "|";
    for (const std::string& cell : cells) row += ' ' + markdown_line(cell) + " |";
    return row + '\n';
  };
  const Overloaded write = {
      [&](const Heading& block) { text += "\n## " + markdown_line(block.text) + '\n'; },
      [&](const Paragraph& block) { text += '\n' + markdown_line(block.text) + '\n'; },
      [&](const Table& block) {
        text += '\n' + line(block.head) + '|';
        for (const bool right : block.right) text += right ? "---:|" : "---|";
        text += '\n';
        for (const auto& row : block.rows) text += line(row);
      },
      [&](const Row& block) {
        for (const DocumentFigure& figure : block.figures) {
          text += fmt::format("\n![{0}]({1}/{2})\n\n*{0}*\n", markdown_text(figure.caption), folder,
                              figure.name);
        }
      }};
  for (const Block& block : blocks_) std::visit(write, block);
  return text;
}

std::string inline_svg(std::string_view svg, std::string_view prefix) {
  const std::size_t begin = svg.find("<svg");
  if (begin == std::string_view::npos) return {};
  svg.remove_prefix(begin);
  constexpr std::array<std::string_view, 5> kBeforeIds = {" id=\"", " id='", "href=\"#", "href='#",
                                                          "url(#"};
  std::string result;
  std::size_t at = 0;
  while (at < svg.size()) {
    const auto found = std::ranges::find_if(
        kBeforeIds, [&](std::string_view mark) { return svg.substr(at).starts_with(mark); });
    if (found == kBeforeIds.end()) {
      result += svg[at++];
      continue;
    }
    result.append(*found).append(prefix);
    at += found->size();
  }
  return result;
}

}  // namespace orasp
