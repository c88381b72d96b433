#include "orasp/drawing/graphviz.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/scenarios.h"
#include "orasp/planners/value_iteration.h"
#include "tests/fault.h"
#include "tests/files.h"
#include "tests/instances.h"

namespace orasp {
namespace {

std::size_t occurrences(const std::string& text, const std::string& word) {
  std::size_t found = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
    ++found;
  return found;
}

/// H of a problem, kept together with what it refers to.
struct Drawn {
  explicit Drawn(Problem from) : problem(std::move(from)) {}
  Problem problem;
  TransitionSystem system{problem};
  StateGraph graph = StateGraph::build(system, {});
};

constexpr const char* kGreen = "#1a7f37";
constexpr const char* kRed = "#cf222e";

TEST(Graphviz, EveryStateAndActionIsDrawnOnce) {
  const Drawn drawn(load_scenario("4piece"));  // 16 states, 32 actions
  const std::string dot = state_graph_dot(drawn.graph);
  EXPECT_EQ(occurrences(dot, " -> "), 32U);
  EXPECT_EQ(occurrences(dot, "tooltip="), 16U);
  EXPECT_EQ(occurrences(dot, kGreen), 0U);
  EXPECT_NE(dot.find("[label=\"1-2 2-3 3-4 1-4\""), std::string::npos) << dot;
}

TEST(Graphviz, ThePathIsGreenWithItsStates) {
  const Drawn drawn(load_scenario("4piece"));
  const Result best = value_iteration(drawn.graph, {}, {});
  const std::string dot = state_graph_dot(drawn.graph, best.sequence);
  EXPECT_EQ(occurrences(dot, std::string("color=\"") + kGreen + "\", fillcolor"), 5U);  // states
  EXPECT_EQ(occurrences(dot, std::string("fontcolor=\"") + kGreen), 4U);                // actions
}

TEST(Graphviz, DeadEndsAreRedAndTheGoalIsNot) {
  // 2-3 and 3-4 wait for each other: after 1-2 nothing is legal.
  ProblemSpec spec = instances::greedy_trap();
  spec.precedence = {{"2-3", {"3-4"}, {}}, {"3-4", {"2-3"}, {}}};
  const Drawn drawn{Problem(spec)};
  const std::string dot = state_graph_dot(drawn.graph);
  EXPECT_FALSE(drawn.graph.goal());
  EXPECT_EQ(occurrences(dot, std::string("color=\"") + kRed), 1U);
  EXPECT_EQ(occurrences(state_graph_dot(Drawn(load_scenario("4brick")).graph), kRed), 0U);
}

TEST(Graphviz, AStateShowsWhatIsPresentInEitherDirection) {
  const Drawn assembly(load_scenario("4brick").with_direction(Direction::Assembly));
  const std::string dot = state_graph_dot(assembly.graph);
  EXPECT_NE(dot.find("s0 [label=\"\xe2\x88\x85\""), std::string::npos) << dot;  // the empty set
  EXPECT_NE(dot.find("s7 [label=\"1-2 2-3 3-4\""), std::string::npos) << dot;
}

TEST(Graphviz, LargeGraphsLoseTheirLabelsAndAreLaidOutHere) {
  const std::string middle = state_graph_dot(Drawn(load_scenario("2x3")).graph);  // 96 states
  EXPECT_EQ(occurrences(middle, "[label="), 96U);
  EXPECT_EQ(occurrences(middle, "pos="), 0U);
  const std::string large = state_graph_dot(Drawn(load_scenario("lattice")).graph);  // 1,296
  EXPECT_EQ(occurrences(large, "pos="), 1296U);
  EXPECT_NE(large.find("layout=nop2"), std::string::npos);
}

TEST(Graphviz, NamesAreQuotedWhateverTheyHold) {
  ProblemSpec spec = instances::one_connection();
  spec.connections[0].id = R"(a"b\n<i>&é)";
  const Drawn drawn{Problem(spec)};
  const std::string dot = state_graph_dot(drawn.graph);
  EXPECT_NE(dot.find(R"(label="a\"b\\n<i>&é")"), std::string::npos) << dot;
  const std::string svg = svg_text(dot);
  EXPECT_NE(svg.find("a&quot;b\\n&lt;i&gt;&amp;é"), std::string::npos) << svg;
}

TEST(Graphviz, APathThatIsNotInHIsRefused) {
  const Drawn drawn(load_scenario("2x3"));
  const std::vector<ConnectionIndex> twice = {0, 0};
  EXPECT_EQ(
      fault_of([&] { return state_graph_dot(drawn.graph, twice); }),
      "the path to highlight is not in H: after 1 step it handles connection 0, which is not a "
      "legal action there");
}

TEST(Graphviz, AssemblyGraphsShowParallelConnectionsAndLoops) {
  ProblemSpec spec = instances::assembly(2, {{1, 2}, {1, 2}, {1, 1}});
  spec.connections[1].id = "second";
  const std::string dot = assembly_dot(Problem(spec));
  EXPECT_EQ(occurrences(dot, "p0 -- p1"), 2U);
  EXPECT_EQ(occurrences(dot, "p0 -- p0"), 1U);
  EXPECT_EQ(occurrences(svg_text(dot), "class=\"edge\""), 3U);
}

TEST(Graphviz, TooManyStatesAreNotDrawn) {
  const Drawn drawn(load_scenario("hubble"));  // 12,096
  EXPECT_EQ(
      fault_of([&] { return require_drawable(drawn.graph), 0; }),
      "H has 12096 states, and a drawing of more than 5000 cannot be read; its text in the DOT "
      "language is written up to 200000");
  EXPECT_EQ(occurrences(state_graph_dot(drawn.graph), " -> "), 67'824U);
}

TEST(Graphviz, TheSmallestGraphsAreDrawn) {
  for (const ProblemSpec& spec :
       {instances::nothing(), instances::one_part(), instances::self_connection()}) {
    const Drawn drawn{Problem(spec)};
    EXPECT_NE(svg_text(state_graph_dot(drawn.graph)).find("</svg>"), std::string::npos);
    EXPECT_NE(svg_text(assembly_dot(drawn.problem)).find("</svg>"), std::string::npos);
  }
}

TEST(Graphviz, ASvgFileIsWrittenWholeOrNotAtAll) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "g.svg";
  EXPECT_NE(fault_of([&] { return write_svg("digraph {", file), 0; }).find("dot failed"),
            std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(file));
  write_svg("digraph { a -> b }", file);
  EXPECT_NE(bytes_of(file).find("</svg>"), std::string::npos);
}

}  // namespace
}  // namespace orasp
