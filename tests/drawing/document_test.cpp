#include "orasp/drawing/document.h"

#include <string>

#include <gtest/gtest.h>

namespace orasp {
namespace {

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

constexpr const char* kSvg =
    "<?xml version=\"1.0\"?>\n<!DOCTYPE svg>\n<svg xmlns=\"http://www.w3.org/2000/svg\">"
    "<g id=\"a\"/><use xlink:href='#a'/><g clip-path=\"url(#a)\"/></svg>\n";

TEST(Document, TheSameBlocksBecomeHtmlAndMarkdown) {
  Document page("A title");
  page.heading("Sizes");
  page.paragraph("Made by `orasp graph`.");
  page.table({"problem", "states", "note"}, {{"lattice", "1,296", "small"}, {"iss", "-", ""}});
  page.figures({{"g.svg", "A graph", kSvg, 40}});
  const std::string html = page.html();
  EXPECT_TRUE(holds(html, "<title>A title</title>"));
  EXPECT_TRUE(holds(html, "<h2>Sizes</h2>"));
  EXPECT_TRUE(holds(html, "Made by <code>orasp graph</code>."));
  EXPECT_TRUE(holds(html, "<td>lattice</td><td class=\"r\">1,296</td><td>small</td>")) << html;
  EXPECT_TRUE(holds(html, "width:calc(40% - 1rem)"));
  EXPECT_TRUE(holds(html, "<figcaption>A graph</figcaption>"));
  const std::string markdown = page.markdown("figures");
  EXPECT_TRUE(holds(markdown, "# A title\n\n## Sizes\n\nMade by `orasp graph`.\n"));
  EXPECT_TRUE(
      holds(markdown, "| problem | states | note |\n|---|---:|---|\n| lattice | 1,296 | small |\n"))
      << markdown;
  EXPECT_TRUE(holds(markdown, "![A graph](figures/g.svg)"));
  ASSERT_EQ(page.pictures().size(), 1U);
  EXPECT_EQ(page.pictures()[0]->name, "g.svg");
}

TEST(Document, TextIsNeverMarkup) {
  Document page("<b>&\"title\"");
  page.paragraph("<script>alert('x')</script> [a](b) *c* | d");
  page.table({"a|b"}, {{"`<i>|` *x*"}});
  const std::string html = page.html();
  EXPECT_TRUE(holds(html, "<title>&lt;b&gt;&amp;&quot;title&quot;</title>"));
  EXPECT_FALSE(holds(html, "<script"));
  EXPECT_TRUE(holds(html, "<code>&lt;i&gt;|</code> *x*"));
  const std::string markdown = page.markdown("figures");
  EXPECT_TRUE(holds(markdown, R"(\<script\>alert('x')\</script\> \[a\](b) \*c\* \| d)"))
      << markdown;
  EXPECT_TRUE(holds(markdown, R"(| `<i>\|` \*x\* |)")) << markdown;
}

TEST(Document, PicturesOnOnePageDoNotShareIds) {
  EXPECT_EQ(inline_svg(kSvg, "f1-"),
            "<svg xmlns=\"http://www.w3.org/2000/svg\"><g id=\"f1-a\"/><use xlink:href='#f1-a'/>"
            "<g clip-path=\"url(#f1-a)\"/></svg>\n");
  EXPECT_EQ(inline_svg("no picture", "f1-"), "");
}

TEST(Document, AQuoteAloneIsNoCode) {
  Document page("x");
  page.paragraph("a ` b");
  EXPECT_TRUE(holds(page.html(), "<p>a ` b</p>"));
}

}  // namespace
}  // namespace orasp
