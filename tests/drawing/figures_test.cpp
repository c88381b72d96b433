#include "orasp/drawing/figures.h"

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/drawing/drawing_process.h"
#include "orasp/drawing/graphviz.h"
#include "orasp/io/scenarios.h"
#include "orasp/planners/value_iteration.h"
#include "tests/fault.h"
#include "tests/files.h"
#include "tests/instances.h"

namespace orasp {
namespace {

constexpr const char* kGreen = "#1a7f37";
/// Everything that could end a string of a language on the way to a picture, or begin a command of
/// one.
constexpr const char* kHostile = "<script>'\"\\`touch x`\n@x {a}_b &é";
/// The same as the text of an SVG, between the parts that programs escape in their own ways.
constexpr const char* kHarmless = "&lt;script";

std::size_t occurrences(const std::string& text, const std::string& word) {
  std::size_t found = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
    ++found;
  return found;
}

/// What is wrong with the XML of a picture by the judgement of Python's parser; empty if nothing
/// is.
std::string xml_fault(const std::string& svg) {
  const std::vector<std::string> arguments = {
      "-c",
      "import sys, xml.dom.minidom as d; print(d.parse(sys.stdin.buffer).documentElement.tagName)"};
  const std::optional<ProgramRun> run = run_program("python3", arguments, svg);
  if (!run) return "python3 is missing";
  return run->exit_code == 0 && run->output == "svg\n" ? std::string() : run->errors + run->output;
}

/// H of a problem with its best plan, kept together with what it refers to.
struct Solved {
  explicit Solved(Problem from) : problem(std::move(from)) {
    plan = value_iteration(graph, {}, {}).sequence;
  }
  Problem problem;
  TransitionSystem system{problem};
  StateGraph graph = StateGraph::build(system, {});
  std::vector<ConnectionIndex> plan;
};

Problem hostile() {
  ProblemSpec spec = instances::assembly(3, {{1, 2}, {2, 3}});
  spec.name = kHostile;
  std::string id = kHostile;
  id[id.find('\n')] = ' ';  // ids hold no control characters
  spec.parts[0].id = id;
  spec.parts[0].name = kHostile;
  spec.connections[0].parts[0] = id;
  spec.connections[0].id = id;
  return Problem(spec);
}

TEST(Figures, AStructureHasACircleAPartAndALineAConnection) {
  for (const char* name : {"4brick", "lattice", "jwst"}) {
    const Problem problem = load_scenario(name);
    const std::string svg = structure_svg(problem);
    EXPECT_EQ(occurrences(svg, "class=\"node\""), problem.num_parts()) << name;
    EXPECT_EQ(occurrences(svg, "class=\"edge\""), problem.num_connections()) << name;
    EXPECT_EQ(xml_fault(svg), "") << name;
  }
}

TEST(Figures, AFewConnectionsHaveColoursManyAreGrey) {
  const Problem few = load_scenario("4piece");
  ASSERT_EQ(connection_colours(few).size(), 8U);
  for (std::size_t c = 0; c < 4; ++c) {
    const std::string colour(connection_colours(few)[c]);
    EXPECT_EQ(occurrences(structure_svg(few), "stroke=\"" + colour + "\""), 1U) << colour;
  }
  EXPECT_TRUE(connection_colours(load_scenario("lattice")).empty());
}

TEST(Figures, AStructureIsLaidOutWithoutCrossingsWhereThereIsAWay) {
  // 1-2-3-4-1 drawn as a square: no two of the parts that are not neighbours lie nearer than
  // neighbours do.
  const Problem ring = load_scenario("4piece");
  std::vector<Place> places =
      places_of(assembly_dot(ring, {.colours = {}, .places = {}, .start = "regular"}), 4);
  ASSERT_EQ(places.size(), 4U);
  const auto distance = [&](std::size_t a, std::size_t b) {
    return std::hypot(places[a].x - places[b].x, places[a].y - places[b].y);
  };
  EXPECT_GT(distance(0, 2), distance(0, 1));
  EXPECT_GT(distance(1, 3), distance(1, 2));
}

TEST(Figures, PartsStandWhereTheProblemSaysTheyAre) {
  // A grid has positions: three columns, two rows.
  const std::string dot = assembly_dot(load_scenario("grid:2x3"));
  EXPECT_EQ(occurrences(dot, "pos="), 6U);
  EXPECT_NE(dot.find("layout=nop"), std::string::npos);
  EXPECT_EQ(occurrences(structure_svg(load_scenario("grid:2x3")), "class=\"edge\""), 7U);
}

TEST(Figures, HHasANodeAStateAnEdgeAnActionAndThePathInGreen) {
  for (const char* name : {"4piece", "2x3", "lattice"}) {
    const Solved solved(load_scenario(name));
    const std::string svg = state_graph_svg(solved.graph, {.path = solved.plan});
    EXPECT_EQ(occurrences(svg, "class=\"node\""), solved.graph.num_states()) << name;
    EXPECT_EQ(occurrences(svg, "class=\"edge\""), solved.graph.num_actions()) << name;
    const std::size_t steps = solved.plan.size();
    EXPECT_EQ(occurrences(svg, std::string("fill=\"none\" stroke=\"") + kGreen), steps) << name;
    EXPECT_EQ(xml_fault(svg), "") << name;
  }
}

TEST(Figures, WhatAConstraintTakesFromHIsDashed) {
  // 1-2-3-4 in a ring; 2-3 before 1-2 leaves 12 of 16 states and 20 of 32 actions.
  const Solved whole(load_scenario("4piece"));
  ProblemSpec spec = whole.problem.spec();
  spec.precedence = {{"1-2", {"2-3"}, {}}};
  const Solved bound{Problem(spec)};
  ASSERT_EQ(bound.graph.num_states(), 12U);
  const std::string svg = state_graph_svg(bound.graph, {.path = bound.plan, .whole = &whole.graph});
  EXPECT_EQ(occurrences(svg, "class=\"node\""), 16U);
  EXPECT_EQ(occurrences(svg, "class=\"edge\""), 32U);
  EXPECT_EQ(occurrences(svg, "stroke-dasharray"),
            (16 - bound.graph.num_states()) + (32 - bound.graph.num_actions()));
}

TEST(Figures, ATreeHasANodeForEveryOrder) {
  // 3 connections in any order: 1 + 3 + 6 + 6 nodes, and an edge into each but the root.
  const Solved solved(load_scenario("4brick"));
  const std::string svg = tree_svg(solved.system, solved.plan);
  EXPECT_EQ(occurrences(svg, "class=\"node\""), 16U);
  EXPECT_EQ(occurrences(svg, "class=\"edge\""), 15U);
  EXPECT_EQ(occurrences(svg, std::string("fill=\"none\" stroke=\"") + kGreen), 3U);
  EXPECT_EQ(xml_fault(svg), "");
  const Problem chain = load_scenario("chain:8");
  const TransitionSystem system(chain);
  EXPECT_EQ(fault_of([&] { return tree_svg(system); }),
            "H~ has more than 400 nodes, and its drawing cannot be read");
}

TEST(Figures, EachStepIsASmallStructureWithWhatMovesInGreen) {
  const Solved solved(load_scenario("4brick"));  // in the middle first: two, then one and one part
  const std::string svg = steps_svg(solved.system, solved.plan);
  EXPECT_EQ(occurrences(svg, "class=\"node\""), 3U * 4U + 3U);  // parts and titles
  EXPECT_EQ(occurrences(svg, "class=\"edge\""), 3U + 2U + 1U);
  EXPECT_EQ(occurrences(svg, "stroke-dasharray"), 3U);
  EXPECT_EQ(occurrences(svg, std::string("fill=\"") + kGreen + "\" stroke=\"" + kGreen),
            2U + 1U + 1U);
  EXPECT_NE(svg.find("1. remove 2&#45;3"), std::string::npos) << svg;
}

TEST(Figures, AssemblyStepsShowWhatIsMade) {
  const Solved solved(load_scenario("4brick").with_direction(Direction::Assembly));
  const std::string svg = steps_svg(solved.system, solved.plan);
  EXPECT_EQ(occurrences(svg, "class=\"edge\""), 1U + 2U + 3U);
  EXPECT_EQ(occurrences(svg, "stroke-dasharray"), 0U);
  EXPECT_NE(svg.find("1. make "), std::string::npos);
}

TEST(Figures, LongPlansAreDrawnByTwelveOfTheirSteps) {
  const Problem problem = load_scenario("chain:70");
  const TransitionSystem system(problem);
  std::vector<ConnectionIndex> plan(69);
  for (ConnectionIndex c = 0; c < 69; ++c) plan[c] = c;
  const std::string svg = steps_svg(system, plan);
  EXPECT_EQ(occurrences(svg, ". remove "), 12U);
  EXPECT_NE(svg.find(">1. remove 1&#45;2<"), std::string::npos);
  EXPECT_NE(svg.find(">69. remove 69&#45;70<"), std::string::npos);
}

TEST(Figures, ADistributionShowsItsMeanAndItsMarks) {
  const std::vector<double> rewards = {-1, -2, -2, -3};
  const std::vector<Mark> marks = {{"optimum", -0.5, Mark::Kind::Best},
                                   {"learned", -0.75, Mark::Kind::Plan},
                                   {kHostile, -4, Mark::Kind::Other}};
  const std::string svg = distribution_svg({rewards, marks});
  EXPECT_NE(svg.find("4 random, mean -2<"), std::string::npos) << svg;
  EXPECT_NE(svg.find("optimum -0.5<"), std::string::npos);
  EXPECT_NE(svg.find("learned -0.75<"), std::string::npos);
  EXPECT_NE(svg.find(kHarmless), std::string::npos);
  EXPECT_EQ(svg.find("<script"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists("x"));
  EXPECT_EQ(xml_fault(svg), "");
}

TEST(Figures, EqualRewardsAndASingleOneAreDrawnToo) {
  EXPECT_EQ(xml_fault(distribution_svg({std::vector<double>(100, 0.7785), {}})), "");
  EXPECT_EQ(xml_fault(distribution_svg({std::vector<double>{0}, {}})), "");
  EXPECT_EQ(fault_of([] { return distribution_svg({}); }),
            "a distribution needs at least one reward");
}

TEST(Figures, GrowthHasItsPointsAndFormulas) {
  EXPECT_EQ(states_of(10), 1024);
  EXPECT_EQ(actions_of(10), 5120);
  EXPECT_EQ(tree_nodes_of(3), 16);  // 1 + 3 + 6 + 6
  const std::vector<GrowthSeries> series = {
      {"chains", {{1, 2, 1, 2}, {2, 4, 4, 5}, {3, 8, 12, 16}}}, {kHostile, {{3, 6, 7, 0}}}};
  const std::string svg = growth_svg(series);
  EXPECT_EQ(xml_fault(svg), "");
  EXPECT_NE(svg.find("chains"), std::string::npos);
  EXPECT_EQ(svg.find("<script"), std::string::npos);
}

TEST(Figures, GrowthAlongAPlanCountsHOfWhatIsLeft) {
  const Solved solved(load_scenario("lattice"));
  const GrowthSeries series = growth_along(solved.problem, solved.plan, 1e6, {});
  ASSERT_EQ(series.points.size(), 12U);
  EXPECT_EQ(series.points.front().states, 2);
  EXPECT_EQ(series.points.back().states, 1296);
  EXPECT_EQ(series.points.back().actions, 6048);
  EXPECT_LT(growth_along(solved.problem, solved.plan, 100, {}).points.back().states, 101);
}

TEST(Figures, NamesAreTextInEveryFigure) {
  const Solved solved(hostile());
  for (const std::string& svg :
       {structure_svg(solved.problem), state_graph_svg(solved.graph, {.path = solved.plan}),
        tree_svg(solved.system, solved.plan), steps_svg(solved.system, solved.plan)}) {
    EXPECT_EQ(xml_fault(svg), "") << svg;
    EXPECT_NE(svg.find(kHarmless), std::string::npos) << svg;
    EXPECT_EQ(svg.find("<script"), std::string::npos) << svg;
  }
  EXPECT_FALSE(std::filesystem::exists("x"));
}

TEST(Figures, AllAreWrittenIntoAFolder) {
  const TemporaryFolder folder;
  const Solved solved(load_scenario("4piece"));
  const std::vector<double> sample = {0.545, 0.557, 0.55};
  const std::vector<FigureFile> files =
      write_figures(solved.problem, {.plan = solved.plan, .sample = sample, .marks = {}},
                    folder.path() / "a" / "b", {});
  std::vector<std::string> names;
  for (const FigureFile& file : files) {
    names.push_back(file.name);
    EXPECT_EQ(xml_fault(bytes_of(folder.path() / "a" / "b" / file.name)), "") << file.name;
  }
  EXPECT_EQ(names, (std::vector<std::string>{"structure.svg", "steps.svg", "state-graph.svg",
                                             "tree.svg", "distribution.svg", "growth.svg"}));
  // Without a plan and a sample; H of 12,096 states is not drawn.
  EXPECT_EQ(write_figures(load_scenario("hubble"), {}, folder.path(), {}).size(), 1U);
}

TEST(Figures, AFileInThePlaceOfTheFolderIsRefused) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.file("taken", "");
  EXPECT_NE(fault_of([&] {
              return write_figures(load_scenario("3piece"), {}, file, {});
            }).find("cannot make the folder"),
            std::string::npos);
}

TEST(Figures, TheSmallestProblemsAreDrawn) {
  for (const ProblemSpec& spec :
       {instances::nothing(), instances::one_part(), instances::self_connection()}) {
    const TemporaryFolder folder;
    const Solved solved{Problem(spec)};
    EXPECT_GE(write_figures(solved.problem, {.plan = solved.plan}, folder.path(), {}).size(), 3U);
  }
}

TEST(Program, AMissingProgramIsNamedWithItsPackage) {
  EXPECT_EQ(fault_of([] { return drawn_by("no-such-program", "its-package", {}, ""); }),
            "cannot draw: the program no-such-program is missing; it is in the Debian package "
            "its-package");
}

TEST(Program, ArgumentsAndInputArriveAsTheyAre) {
  const std::vector<std::string> arguments = {"-c", "cat; printf '%s' \"$1\" >&2; exit 3", "sh",
                                              "a b'\"$x"};
  const std::optional<ProgramRun> run = run_program("sh", arguments, "line\nline");
  ASSERT_TRUE(run);
  EXPECT_EQ(run->output, "line\nline");
  EXPECT_EQ(run->errors, "a b'\"$x");
  EXPECT_EQ(run->exit_code, 3);
  EXPECT_EQ(run->signal, 0);
  EXPECT_GE(run->seconds, 0);
  EXPECT_FALSE(run_program("no-such-program", {}));
  const std::vector<std::string> suicide = {"-c", "kill -9 $$"};
  EXPECT_EQ(run_program("sh", suicide)->signal, 9);
}

// Ctrl-C reaches every process of a terminal's group, also one that has only just been started.
TEST(Program, IsNotEndedByWhatAsksItsCallerToStop) {
  const std::vector<std::string> asked = {"-c", "kill -INT $$; kill -TERM $$; echo whole"};
  const std::optional<ProgramRun> run = run_program("sh", asked);
  ASSERT_TRUE(run);
  EXPECT_EQ(run->signal, 0);
  EXPECT_EQ(run->output, "whole\n");
}

}  // namespace
}  // namespace orasp
