#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace orasp {

/// A picture of a document: the SVG and its name as a file.
struct DocumentFigure {
  std::string name;  ///< of the file, such as "growth.svg"
  std::string caption;
  std::string svg;
  int width = 50;  ///< of the page, in hundredths
};

/// A page of headings, paragraphs, tables and figures that can be written as HTML and as Markdown.
/// All text is data: what would be markup is escaped, but for `code` between backquotes. Numbers in
/// tables stand right.
///
///     Document page("Results");
///     page.heading("Sizes");
///     page.table({"problem", "states"}, {{"lattice", "1,296"}});
///     write_file("page.html", page.html());
class Document {
 public:
  explicit Document(std::string title) : title_(std::move(title)) {}

  void heading(std::string text) { blocks_.emplace_back(Heading{std::move(text)}); }
  void paragraph(std::string text) { blocks_.emplace_back(Paragraph{std::move(text)}); }
  /// Each row has as many cells as `head`.
  void table(std::vector<std::string> head, std::vector<std::vector<std::string>> rows);
  /// Pictures side by side where there is room.
  void figures(std::vector<DocumentFigure> figures) {
    blocks_.emplace_back(Row{std::move(figures)});
  }

  /// All pictures, in their order.
  [[nodiscard]] std::vector<const DocumentFigure*> pictures() const;
  /// One page that needs nothing else: pictures inside, no script, light or dark as the reader has
  /// it, fit to be printed.
  [[nodiscard]] std::string html() const;
  /// GitHub's Markdown; pictures are links to files in `folder`, relative to the text.
  [[nodiscard]] std::string markdown(std::string_view folder) const;

 private:
  struct Heading {
    std::string text;
  };
  struct Paragraph {
    std::string text;
  };
  struct Table {
    std::vector<std::string> head;
    std::vector<std::vector<std::string>> rows;
    std::vector<bool> right;  ///< by column
  };
  struct Row {
    std::vector<DocumentFigure> figures;
  };
  using Block = std::variant<Heading, Paragraph, Table, Row>;

  std::string title_;
  std::vector<Block> blocks_;
};

/// An SVG file as an element of an HTML page: without what stands before `<svg>`, its ids with
/// `prefix` before them, so that several on one page do not mistake each other's.
[[nodiscard]] std::string inline_svg(std::string_view svg, std::string_view prefix);

}  // namespace orasp
