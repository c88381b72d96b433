#include "orasp/io/formats.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "orasp/catalogue.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/random.h"
#include "tests/fault.h"
#include "tests/files.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"
#include "tests/wide_problems.h"

namespace orasp {
namespace {

using nlohmann::json;

std::string example(const std::string& name) {
  return bytes_of(source_folder() / "examples/formats" / name);
}

Problem read(const std::string& text, const std::string& format) {
  return Problem(read_format(text, format).problem);
}

std::string fault(const std::string& text, const std::string& format) {
  return fault_of([&] { return read_format(text, format); });
}

std::vector<std::string> connection_ids(const Problem& problem) {
  std::vector<std::string> ids;
  for (const Connection& connection : problem.connections()) ids.push_back(connection.id);
  return ids;
}

PlanFile plan_of(std::vector<std::string> sequence) {
  PlanFile plan;
  plan.sequence = std::move(sequence);
  return plan;
}

const std::string kHead = "<graphml xmlns=\"http://graphml.graphdrawing.org/xmlns\">";

std::string graphml(const std::string& keys, const std::string& graph) {
  return kHead + keys + "<graph edgedefault=\"undirected\">" + graph + "</graph></graphml>";
}

// -------------------------------------------------------------------------------------------------
// the table

TEST(Formats, HaveNamesOfTheirOwnAndReadOrWrite) {
  std::set<std::string_view> names;
  for (const Format& format : formats()) {
    EXPECT_TRUE(names.insert(format.name).second) << format.name;
    EXPECT_TRUE(format.read != nullptr || format.write != nullptr) << format.name;
    EXPECT_FALSE(format.summary.empty() || format.limits.empty()) << format.name;
    EXPECT_EQ(&find_format(format.name), &format);
    EXPECT_FALSE(format.of_plan && format.read != nullptr) << format.name;
  }
  EXPECT_EQ(fault_of([] { return find_format("graphlm"); }).substr(0, 32),
            "unknown format \"graphlm\"; known:");
}

TEST(Formats, AreToldByEndingAndContent) {
  const std::vector<std::array<std::string, 3>> cases = {
      {"a.json", R"({"format": "orasp-problem/1"})", "orasp"},
      {"a.json", R"({"nodes": [], "links": []})", "node-link"},
      {"a.json", R"({"parts": {}, "joints": {}})", "pycaalp"},
      {"a.json", R"({"parts": [], "connections": []})", "orasp"},
      {"-", R"( {"nodes": []})", "node-link"},
      {"dir.x/A.IN2", "3\n", "in2"},
      {"a.graphml", "whatever", "graphml"},
      {"a.xml", "<?xml version='1.0'?><!-- <mujoco> --><graphml/>", "graphml"},
      {"a.xml", "<mujoco model='x'/>", "mjcf"},
      {"-", "<!DOCTYPE g><g:graphml xmlns:g='x'/>", "graphml"},
      {"a.csv", "contact,1\n1,0\n", "matrices"}};
  for (const auto& [file, text, format] : cases)
    EXPECT_EQ(format_of_input(file, text).name, format) << file << ": " << text;
  for (const auto& [file, text] : std::vector<std::array<std::string, 2>>{
           {"a.txt", "3\n"}, {"a.xml", "<robot/>"}, {"a.json", "{}"}, {"-", ""}, {"a.xml", "<"}}) {
    EXPECT_NE(fault_of([&] { return format_of_input(file, text); }).find("--from says which it is"),
              std::string::npos)
        << file;
  }
  EXPECT_EQ(format_of_output("a.graphml").name, "graphml");
  EXPECT_EQ(format_of_output("a.json").name, "orasp");
  EXPECT_EQ(format_of_output("a.GV").name, "dot");
  EXPECT_EQ(fault_of([] { return format_of_output("a.xml"); }),
            "the ending of \"a.xml\" is that of several formats; --to says which to write: "
            "behavior-tree, behavior-tree-parallel");
  EXPECT_NE(fault_of([] { return format_of_output("a"); }).find("tells no format"),
            std::string::npos);
}

TEST(Formats, RefuseWhatTheyDoNotDo) {
  const Problem problem = load_scenario("4brick");
  EXPECT_NE(fault("x", "dot").find("dot is written, not read; what is read is orasp, graphml"),
            std::string::npos);
  EXPECT_NE(fault_of([&] { return write_format(problem, "in2"); }).find("in2 is read, not written"),
            std::string::npos);
  EXPECT_EQ(fault_of([&] { return write_format(problem, "task-graph"); }),
            "task-graph is a format of plans, and there is no plan");
  EXPECT_NE(fault_of([&] {
              return write_format(problem, "task-graph", plan_of({"1-2"}));
            }).find("the plan breaks a rule at step 2: "),
            std::string::npos);
  EXPECT_NE(fault_of([&] {
              return write_format(load_scenario("fleet-lattice"), "steps-csv", PlanFile{});
            }),
            "no fault");
}

TEST(Formats, SayWhereTextsAreNoTexts) {
  for (const Format& format : formats()) {
    if (format.read == nullptr || format.endings == ".json") continue;
    const std::string name(format.name);
    EXPECT_EQ(fault("", name), "the file is empty") << name;
    EXPECT_EQ(fault("\xEF\xBB\xBF \n", name), "the file is empty") << name;
    EXPECT_EQ(fault("a\nb\xff", name), "line 2: the byte 0xff is not valid UTF-8") << name;
    EXPECT_EQ(fault(std::string("a\n\0", 3), name), "line 2: a zero byte stands in no text file")
        << name;
  }
  for (const char* name : {"orasp", "node-link", "pycaalp"})
    EXPECT_EQ(fault("", name), "the file is empty") << name;
}

TEST(Formats, SayHowManyCommentsOfAProblemFileAreLeftOut) {
  const std::string text = R"({"format": "orasp-problem/1", "note": "kept", "x-a": {"note": "b"},
    "parts": [{"id": "1", "note": "n", "numbers": {"note": 3}}], "connections": []})";
  const Converted converted = read_format(text, "orasp");
  EXPECT_EQ(converted.problem.note, "kept");
  EXPECT_EQ(converted.notes,
            std::vector<std::string>{
                "comments are left out (2 notes, sources or x- keys inside of the file)"});
  EXPECT_TRUE(read_format(problem_text(load_scenario("hubble")), "orasp").notes.empty());
}

// -------------------------------------------------------------------------------------------------
// GraphML

void expect_same_after_graphml(const ProblemSpec& spec, const std::string& what) {
  const Problem problem(spec);
  const Written written = write_format(problem, "graphml");
  EXPECT_TRUE(written.notes.empty()) << what;
  const Problem again = read(written.text, "graphml");
  EXPECT_EQ(problem_digest(again), problem_digest(problem)) << what;
  EXPECT_EQ(again.name(), problem.name());
  EXPECT_EQ(problem_text(again), problem_text(problem)) << what;
  EXPECT_EQ(write_format(again, "graphml").text, written.text) << what;
}

TEST(Graphml, BringsBackEveryBuiltInProblem) {
  for (const ScenarioInfo& scenario : scenarios()) {
    if (!scenario.generator)
      expect_same_after_graphml(load_scenario(scenario.name).spec(), scenario.name);
  }
}

TEST(Graphml, BringsBackRandomProblems) {
  int compared = 0;
  for (std::uint64_t seed = 0; seed < some_of<std::uint64_t>(300); ++seed) {
    const ProblemSpec spec = make_uncertain(random_problem(seed), seed);
    if (spec.parts.empty()) continue;  // a graph without nodes is refused
    bool has_code = false;
    try {
      (void)problem_text(Problem(spec));
    } catch (const InputError&) {
      has_code = true;  // an objective that is code
    }
    if (has_code) continue;
    expect_same_after_graphml(spec, std::to_string(seed));
    ++compared;
  }
  EXPECT_GT(compared, least_of(150));
}

TEST(Graphml, BringsBackRandomProblemsOfTheWiderWorld) {
  for (std::uint64_t seed = 0; seed < some_of<std::uint64_t>(200); ++seed)
    expect_same_after_graphml(wide_random_problem(seed), std::to_string(seed));
}

TEST(Graphml, BringsBackWhatNodesAndEdgesHaveNoPlaceFor) {
  const Problem problem = parse_problem(R"({"format": "orasp-problem/1", "name": "a \"b\" <c> & d",
    "note": "two\nlines", "source": "x",
    "parts": [{"id": "a<&>\"'", "name": " \tn ", "position": [0, 0.1, -0],
               "numbers": {"value": 1e-300}},
              {"id": "b"}, {"id": "ü", "mass": 0}],
    "connections": [{"parts": ["a<&>\"'", "b"], "attributes": {"tool": " ", "e": ""},
                     "numbers": {"w": 0.1}},
                    {"id": "2", "parts": ["b", "ü"], "position": [1, 2, 3], "duration": 0},
                    {"id": "loop", "parts": ["b", "b"]}],
    "precedence": [{"connection": "2", "after_any": ["loop"]}],
    "blocking": {"directions": ["+x", "-x", {"id": "s", "vector": [1, 1, 0]}],
                 "blocked": [{"part": "b", "by": "ü", "directions": ["-s"]}]},
    "limits": {"max_moved_parts": 2, "grounded": true}, "base": ["b"],
    "objective": {"type": "sum", "terms": [{"type": "changeover", "attribute": "tool",
                                             "weight": 2}]},
    "geometry": {"file": "x.glb"}, "goal": {"free": ["ü"]}})");
  expect_same_after_graphml(problem.spec(), "all keys");
}

TEST(Graphml, RefusesOwnNamesThatAreKeys) {
  const auto written = [](const std::string& connection) {
    const Problem problem = parse_problem(
        R"({"format": "orasp-problem/1", "parts": [{"id": "1"}, {"id": "2"}], "connections": [)" +
        connection + "]}");
    return fault_of([&] { return write_format(problem, "graphml"); });
  };
  EXPECT_EQ(
      written(R"({"parts": ["1", "2"], "attributes": {"axis": "left"}})"),
      "graphml cannot carry the name \"axis\" of an attribute of the connection \"1-2\", which "
      "is that of a key");
  EXPECT_EQ(written(R"({"parts": ["1", "2"], "attributes": {"w": "a"}, "numbers": {"w": 1}})"),
            "graphml cannot carry \"w\" both as a number of the connection \"1-2\" and as an "
            "attribute of \"1-2\"");
}

TEST(Graphml, ReadsWhatNetworkxAndYedWrite) {
  const Problem lamp = read(example("lamp.graphml"), "graphml");
  EXPECT_EQ(lamp.name(), "Desk lamp");
  EXPECT_EQ(connection_ids(lamp),
            (std::vector<std::string>{"base-arm", "arm-shade", "arm-bulb", "shade-bulb"}));
  EXPECT_EQ(lamp.parts()[2].position, (Vector3{0.1, 0, 0.4}));
  EXPECT_EQ(lamp.connections()[0].duration, 40);
  EXPECT_EQ(lamp.connections()[2].attributes.at("tool"), "hand");

  // networkx numbers parallel edges from 0 for each pair anew: those are no ids.
  const Problem bench = read(example("bench_multigraph.graphml"), "graphml");
  EXPECT_EQ(connection_ids(bench),
            (std::vector<std::string>{"seat-left leg", "seat-left leg 2", "seat-right leg",
                                      "seat-right leg 2"}));

  const Converted gearbox = read_format(example("gearbox_yed.graphml"), "graphml");
  EXPECT_EQ(gearbox.problem.parts[1].name, "shaft");
  EXPECT_EQ(gearbox.problem.connections[0].duration, 20);  // the default of its key
  EXPECT_EQ(gearbox.problem.connections[1].duration, 35);
  EXPECT_EQ(gearbox.problem.connections[1].id, "e1");
  EXPECT_EQ(gearbox.problem.connections[1].attributes.at("label"), "press fit");
  ASSERT_EQ(gearbox.notes.size(), 2U);
  EXPECT_EQ(gearbox.notes[1],
            "\"description\" is left out (1 part): parts have numbers of their own, but no words");
}

TEST(Graphml, LeavesOutNamesThatFormulasHaveAlready) {
  const Converted read_back = read_format(
      graphml(
          R"(<key id="k" for="node" attr.name="mass 2" attr.type="int"/>)"
          R"(<key id="l" for="edge" attr.name="direction" attr.type="string"/>)"
          R"(<key id="m" for="edge" attr.name="before" attr.type="int"/>)"
          R"(<key id="n" for="all" attr.name="sin" attr.type="int"/>)",
          R"(<node id="1"><data key="k">2</data></node><node id="2"><data key="n">1</data></node>)"
          R"(<edge source="1" target="2"><data key="l">up</data><data key="m">1</data></edge>)"),
      "graphml");
  EXPECT_TRUE(read_back.problem.parts[0].numbers.empty());
  EXPECT_TRUE(read_back.problem.parts[1].numbers.empty());
  EXPECT_TRUE(read_back.problem.connections[0].numbers.empty());
  EXPECT_TRUE(read_back.problem.connections[0].attributes.empty());
  EXPECT_EQ(read_back.notes.size(), 4U);
}

TEST(Graphml, SaysNothingOfDescriptionsThatAreEmpty) {
  const std::string keys = R"(<key id="g" for="graph" attr.name="Description" attr.type="string"/>)"
                           R"(<key id="n" for="node" attr.name="url" attr.type="string"/>)";
  const std::string text =
      graphml(keys, R"(<data key="g"/><node id="1"><data key="n" xml:space="preserve"/></node>)");
  EXPECT_TRUE(read_format(text, "graphml").notes.empty());
}

TEST(Graphml, ReadsEdgesThatJoinANodeToItselfAndDirectedGraphs) {
  const Converted loop = read_format(
      kHead + R"(<graph edgedefault="directed"><node id="1"/><edge source="1" target="1"/></graph>)"
              "</graphml>",
      "graphml");
  EXPECT_EQ(loop.problem.connections[0].id, "1-1");
  EXPECT_EQ(loop.notes.size(), 2U);  // it is directed; it separates nothing
}

TEST(Graphml, SaysInWhichLineAFaultStands) {
  const std::vector<std::array<std::string, 2>> cases = {
      {"<graphml>\n<graph>\n<node id='1'/>\n<node id='1'/></graph></graphml>",
       "line 4: node \"1\" is there already, at line 3"},
      {"<graphml>\n<graph>\n<node/></graph></graphml>", "line 3: <node> has no \"id\""},
      {"<graphml><graph/></graphml>", "the graph has no nodes, so there are no parts"},
      {"<graphml/>", "there is no <graph> in it"},
      {"<graphml>\n<graph><node id='1'/></graph>\n<graph/></graphml>",
       "line 3: a second <graph>; a problem is made of one"},
      {"<robot/>", "line 1: the outermost element of GraphML is <graphml>, not <robot>"},
      {"<graphml>\n<graph>", "line 2: it is not well-formed XML: start-end tags mismatch"},
      {"text", "line 1: it is not well-formed XML: no document element found"},
      {"<graphml><graph><node id='1'/><edge source='1'/></graph></graphml>",
       "line 1: <edge> has no \"target\""},
      {"<graphml><graph><node id='1'>\n<graph/></node></graph></graphml>",
       "line 2: a graph inside of a node is not read; take the groups apart"},
      {"<graphml><graph><node id='1'/>\n<hyperedge/></graph></graphml>",
       "line 2: a <hyperedge> joins any number of nodes, and a connection joins two parts"},
      {"<graphml><graph><node id='1'>\n<data key='k'>1</data></node></graph></graphml>",
       "line 2: there is no <key> with the id \"k\""},
      {"<graphml><graph><node id='1 '/></graph></graphml>", "line 1: node \"1 \": the id "}};
  for (const auto& [text, sentence] : cases)
    EXPECT_EQ(fault(text, "graphml").substr(0, sentence.size()), sentence) << text;
  const auto with_mass = [](const std::string& type, const std::string& value) {
    return fault(graphml("<key id='m' for='node' attr.name='mass' attr.type='" + type + "'/>",
                         "\n<node id='1'>\n<data key='m'>" + value + "</data></node>"),
                 "graphml");
  };
  EXPECT_EQ(with_mass("double", "NaN"),
            "line 3: \"NaN\" is not a finite number, which \"mass\" is by its key");
  EXPECT_EQ(with_mass("double", "1e999"),
            "line 3: \"1e999\" is not a finite number, which \"mass\" is by its key");
  EXPECT_EQ(with_mass("string", "heavy"),
            "line 2: node \"1\": \"heavy\" is not a number, which \"mass\" must be");
  EXPECT_EQ(with_mass("string", " 2.5 "), "no fault");
  EXPECT_EQ(with_mass("double", "-1"), "parts[0].mass: -1 is not allowed; it must be 0 or more");
}

TEST(Graphml, FollowsNoEntities) {
  const std::string bomb =
      "<?xml version=\"1.0\"?>\n<!DOCTYPE graphml [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b "
      "\"&a;&a;&a;&a;&a;&a;&a;\">]>\n<graphml><graph><node id=\"&b;\"/></graph></graphml>";
  EXPECT_EQ(fault(bomb, "graphml"),
            "line 2: a document type with declarations of its own is not read; take the <!DOCTYPE "
            "...> out");
  // A type without declarations is passed over; the file that it names is not read.
  EXPECT_EQ(read("<!DOCTYPE graphml SYSTEM \"file:///etc/passwd\"><graphml><graph><node "
                 "id=\"&b;\"/></graph></graphml>",
                 "graphml")
                .part_id(0),
            "&b;");
}

TEST(Graphml, RefusesARestThatIsNone) {
  const auto with_rest = [](const std::string& rest) {
    return fault(graphml("<key id='o' for='graph' attr.name='orasp' attr.type='string'/>",
                         "<data key='o'>" + rest + "</data><node id='1'/>"),
                 "graphml");
  };
  EXPECT_EQ(with_rest("{"),
            "the value \"orasp\" of the graph: line 1, column 2: the text ends too early");
  EXPECT_EQ(
      with_rest(R"({"format": "orasp-problem/1", "parts": [{"id": "1"}], "connections": []})"),
      "the value \"orasp\" of the graph: parts and connections are the nodes and edges, and "
      "do not stand here");
  EXPECT_EQ(
      with_rest(R"({"format": "orasp-problem/1", "parts": [], "connections": [], "base": ["2"]})"),
      "base[0]: no part \"2\"; the only part is \"1\"");
}

TEST(Graphml, ReadsADeepFileWithoutRecursion) {
  std::string deep = kHead + "<graph><node id='1'>";
  for (int i = 0; i < 200'000; ++i) deep += "<data>";
  EXPECT_NE(fault(deep, "graphml").find("not well-formed"), std::string::npos);
}

TEST(Graphml, StopsAtTheMostPartsThatAProblemHas) {
  std::string nodes;
  for (std::size_t i = 0; i <= kMaxParts; ++i) nodes += "<node id='" + std::to_string(i) + "'/>";
  EXPECT_EQ(fault(graphml("", nodes), "graphml"),
            "more than 16384 nodes, the most parts that a problem may have");
}

// -------------------------------------------------------------------------------------------------
// node-link

TEST(NodeLink, SaysWhatItsGraphmlSays) {
  for (const auto& [node_link, graphml] : std::vector<std::array<std::string, 2>>{
           {"lamp_node_link.json", "lamp.graphml"},
           {"bench_node_link.json", "bench_multigraph.graphml"}}) {
    EXPECT_EQ(problem_digest(read(example(node_link), "node-link")),
              problem_digest(read(example(graphml), "graphml")));
  }
}

TEST(NodeLink, TakesNumbersAsIdsAndListsAsPositions) {
  const Problem tiles = read(example("tiles_node_link.json"), "node-link");
  EXPECT_EQ(tiles.part_id(4), "4");
  EXPECT_EQ(tiles.parts()[4].position, (Vector3{0.1, 0.1, 0}));
  EXPECT_EQ(tiles.parts()[4].numbers.at("value"), 4.5);
  EXPECT_EQ(tiles.num_connections(), 7U);
}

TEST(NodeLink, SaysWhereAFaultStands) {
  const std::vector<std::array<std::string, 2>> cases = {
      {"[]", "the file: expected an object, found an empty array"},
      {R"({"nodes": []})", "the key \"links\" or \"edges\" is missing"},
      {R"({"links": []})", "the key \"nodes\" is missing"},
      {R"({"nodes": [], "links": []})", "the graph has no nodes, so there are no parts"},
      {R"({"nodes": [], "links": [], "edges": []})",
       "\"links\" and \"edges\" both stand there; one of them is needed"},
      {R"({"nodes": 3, "links": []})", "nodes: expected an array, found the number 3"},
      {R"({"nodes": [{"id": [1, 2]}], "links": []})",
       "nodes[0].id: expected an id, which is a string or a whole number, found an array"},
      {R"({"nodes": [{"id": 1.5}], "links": []})",
       "nodes[0].id: expected an id, which is a string or a whole number, found the number 1.5"},
      {R"({"nodes": [{}], "links": []})", "nodes[0]: the key \"id\" is missing"},
      {R"({"nodes": [3], "links": []})", "nodes[0]: expected an object, found the number 3"},
      {R"({"nodes": [{"id": 1}, {"id": "1"}], "links": []})",
       "nodes[1]: node \"1\" is there already, at nodes[0]"},
      {R"({"nodes": [{"id": 1}], "edges": [{"source": 1, "target": 2}]})",
       "edges[0]: edge 1: there is no node \"2\""},
      {R"({"nodes": [{"id": 1}], "edges": [{"source": 1}]})",
       "edges[0]: the key \"target\" is missing"},
      {R"({"nodes": [{"id": 1, "mass": NaN}], "edges": []})",
       "line 1, column 30: \"NaN\" is not JSON, which has finite numbers only"},
      {R"({"nodes": [{"id": 1, "mass": [1]}], "edges": []})",
       "nodes[0]: node \"1\": \"an array\" is not a number, which \"mass\" must be"}};
  for (const auto& [text, sentence] : cases) EXPECT_EQ(fault(text, "node-link"), sentence);
}

// -------------------------------------------------------------------------------------------------
// .IN2

TEST(In2, MakesTasksConnectionsToOneBase) {
  const Problem mertens = read(example("MERTENS.IN2"), "in2");
  EXPECT_EQ(mertens.num_parts(), 8U);
  EXPECT_EQ(connection_ids(mertens),
            (std::vector<std::string>{"t1", "t2", "t3", "t4", "t5", "t6", "t7"}));
  double total = 0;
  for (const Connection& task : mertens.connections()) total += task.duration;
  EXPECT_EQ(total, 29);
  EXPECT_EQ(mertens.precedence().size(), 6U);
  // Whatever the order, the tasks take 29 s.
  EXPECT_EQ(solve(mertens, "value-iteration").reward, -29);
}

TEST(In2, NeedsNoEndMarkAndTakesLinesOfDos) {
  const Converted station = read_format(example("cover_station.in2"), "in2");
  ASSERT_EQ(station.problem.precedence.size(), 2U);
  EXPECT_EQ(station.problem.precedence[0].after, (std::vector<std::string>{"t1", "t2"}));
  EXPECT_EQ(read_format("2\n1\n1\n1,2\n1 , 2\n-1,-1\n\x1A", "in2").problem.precedence.size(), 1U);
  EXPECT_EQ(
      read_format("1\n1\n-1,-1\nmore", "in2").notes,
      std::vector<std::string>{"what stands behind the end mark is left out, from line 4 on"});
}

TEST(In2, SaysInWhichLineAFaultStands) {
  const std::vector<std::array<std::string, 2>> cases = {
      {"\n\x1A", "the file is empty"},
      {"0\n", "line 1: \"0\" is not a number of tasks, a whole number from 1 to 16383"},
      {"x\n", "line 1: \"x\" is not a number of tasks, a whole number from 1 to 16383"},
      {"99999\n", "line 1: \"99999\" is not a number of tasks, a whole number from 1 to 16383"},
      {"2\n1\n", "line 2: the file ends after the times of 1 of 2 tasks"},
      {"2\n1\nx\n", "line 3: \"x\" is not the time of task 2, a number of 0 or more"},
      {"2\n1\nnan\n", "line 3: \"nan\" is not the time of task 2, a number of 0 or more"},
      {"2\n1\n-1\n", "line 3: \"-1\" is not the time of task 2, a number of 0 or more"},
      {"2\n1\n1\n\n12\n", "line 5: \"12\" is not a precedence relation, which is \"i,j\""},
      {"2\n1\n1\n1,3\n", "line 4: \"3\" is not a task, a whole number from 1 to 2"},
      {"2\n1\n1\n0,1\n", "line 4: \"0\" is not a task, a whole number from 1 to 2"},
      {"2\n1\n1\n2,2\n", "line 4: task 2 cannot come before itself"},
      {"2\n1\n1\n1,2,3\n", "line 4: \"2,3\" is not a task, a whole number from 1 to 2"}};
  for (const auto& [text, sentence] : cases) EXPECT_EQ(fault(text, "in2"), sentence);
}

// -------------------------------------------------------------------------------------------------
// PyCAALP

TEST(Pycaalp, MakesJointsOneAtATimeAndCountsChangesOfTechnology) {
  const Problem frame = read(example("frame_pycaalp.json"), "pycaalp");
  EXPECT_EQ(frame.direction(), Direction::Assembly);
  EXPECT_EQ(frame.limits().max_subassemblies, 1U);
  EXPECT_EQ(frame.parts()[3].mass, 2);
  EXPECT_EQ(frame.parts()[3].numbers.at("handling"), 2);
  EXPECT_EQ(frame.connections()[1].duration, 20);
  EXPECT_EQ(frame.connections()[1].numbers.at("tolerance"), 3);
  // tl and bl by MAG, then tr and br as rivets: one change, and only one piece at a time.
  EXPECT_EQ(solve(frame, "value-iteration").reward, -1);
  EXPECT_EQ(read(example("pair_pycaalp.json"), "pycaalp").objective().type, "time");
  // Names are anything, also what is a comment in a problem file.
  EXPECT_EQ(read(
                R"({"parts": {"x-rail": {}, "note": {}},
                     "joints": {"x-j": {"parts": ["x-rail", "note"]}}})",
                "pycaalp")
                .connection_id(0),
            "x-j");
}

TEST(Pycaalp, SaysWhereAFaultStands) {
  const std::vector<std::array<std::string, 2>> cases = {
      {"{}", "the key \"parts\" is missing"},
      {R"({"parts": {}, "joints": {}})", "parts: there are no parts"},
      {R"({"parts": {"A": {}}})", "the key \"joints\" is missing"},
      {R"({"parts": {"A": {"weight": "x"}}, "joints": {}})",
       "parts.A.weight: expected a number, found the string \"x\""},
      {R"({"parts": {"A": {"wieght": 1}}, "joints": {}})",
       "parts.A: unknown key \"wieght\"; known keys are weight, handling; did you mean "
       "\"weight\"?"},
      {R"({"parts": {"A": {}}, "joints": {"j": {"parts": ["A", "B"]}}})",
       "joints.j.parts: there is no part \"B\""},
      {R"({"parts": {"A": {}}, "joints": {"j": {"time": 1}}})",
       "joints.j: the key \"parts\" is missing"},
      {R"({"joint1": {"dfm": {}}})", "unknown key \"joint1\"; known keys are parts, joints"}};
  for (const auto& [text, sentence] : cases)
    EXPECT_EQ(fault(text, "pycaalp").substr(0, sentence.size()), sentence);
}

// -------------------------------------------------------------------------------------------------
// matrices

TEST(Matrices, MakeConnectionsAndBlocking) {
  const Problem stack = read(example("stack_matrices.csv"), "matrices");
  EXPECT_EQ(connection_ids(stack), (std::vector<std::string>{"base-ring", "base-lid", "ring-lid"}));
  EXPECT_EQ(stack.directions().size(), 2U);  // -z is the transpose of +z
  const PlanFile plan = plan_of({"base-ring", "base-lid", "ring-lid"});
  // The ring and the lid come off the base upward together, then the lid off the ring.
  const Evaluation evaluation = replayed(stack, plan);
  EXPECT_TRUE(evaluation.valid);
  EXPECT_EQ(evaluation.steps[1].free_directions.size(), 1U);

  const Problem ring = read(example("ring_contacts.csv"), "matrices");
  EXPECT_EQ(ring.part_id(0), "bolt, long");
  EXPECT_TRUE(ring.directions().empty());
}

TEST(Matrices, TakeLinesAndColumnsInAnyOrder) {
  const Problem problem =
      read("contact,a,b,c\nc,0,1,0\na,0,1,0\nb,1,0,1\n+x,c,a,b\na,0,0,1\nb,0,0,0\nc,0,0,0\n",
           "matrices");
  EXPECT_EQ(connection_ids(problem), (std::vector<std::string>{"a-b", "b-c"}));
  ASSERT_EQ(problem.spec().blocking->blocked.size(), 1U);
  EXPECT_EQ(problem.spec().blocking->blocked[0].part, "a");
  EXPECT_EQ(problem.spec().blocking->blocked[0].by, "b");
}

TEST(Matrices, NoteWhereOppositeDirectionsDisagree) {
  const Converted read_back = read_format(
      "contact,a,b\na,0,1\nb,1,0\n+x,a,b\na,0,1\nb,0,0\n-x,a,b\na,0,0\nb,0,0\n", "matrices");
  ASSERT_EQ(read_back.notes.size(), 1U);
  EXPECT_EQ(
      read_back.notes[0],
      "the matrices +x and -x are not the transposes of each other (1 pair, such as \"a\" and "
      "\"b\"); what either says to be blocked is blocked");
}

TEST(Matrices, SayInWhichLineAFaultStands) {
  const std::vector<std::array<std::string, 2>> cases = {
      {"+x,a,b\na,0,1\nb,0,0\n", "there is no matrix \"contact\", which says what is connected"},
      {"touch,a\na,0\n",
       "line 1: \"touch\" is not the name of a matrix; those are contact, +x, -x, +y, -y, +z and "
       "-z"},
      {"contact\n", "line 1: there are no parts; their ids stand behind the name of the matrix"},
      {"contact,a,a\n", "line 1: column 3: the part \"a\" is there already"},
      {"contact,a,b\na,0,1\n",
       "the file ends inside of the matrix \"contact\", which begins at line 1"},
      {"contact,a,b\na,0,1\nc,1,0\n", "line 3: the first matrix has no part \"c\""},
      {"contact,a,b\na,0,1\na,1,0\n", "line 3: the line of \"a\" is there already, at line 2"},
      {"contact,a,b\na,0\nb,1,0\n", "line 2: 1 cells behind the id, and there are 2 parts"},
      {"contact,a,b\na,0,2\nb,1,0\n", "line 2: column 3: \"2\" is neither 0 nor 1"},
      {"contact,a,b\na,0,\nb,1,0\n", "line 2: 1 cells behind the id, and there are 2 parts"},
      {"contact,a,b\na,0,nan\nb,1,0\n", "line 2: column 3: \"nan\" is neither 0 nor 1"},
      {"contact,a,b\na,1,0\nb,0,0\n", "line 2: \"a\" has a 1 with itself"},
      {"contact,a,b\na,0,1\nb,0,0\n",
       "line 3: contact is not symmetric: \"a\" touches \"b\" in one line and not in the other"},
      {"contact,a\na,0\ncontact,a\na,0\n",
       "line 3: the matrix \"contact\" is there already, at line 1"},
      {"contact,a\na,0\n+x,a,b\na,0,0\n", "line 3: 2 parts, and the first matrix has 1"},
      {"contact,\"a\n", "line 1: a quote is opened and never closed"},
      {"contact,\"a\"b\n", "line 1: a cell goes on behind its closing quote"}};
  for (const auto& [text, sentence] : cases) EXPECT_EQ(fault(text, "matrices"), sentence) << text;
}

// -------------------------------------------------------------------------------------------------
// MJCF

TEST(Mjcf, MakesBodiesPartsAndWeldsConnections) {
  const Converted stool = read_format(example("stool_mjcf.xml"), "mjcf");
  EXPECT_EQ(stool.problem.name, "stool");
  ASSERT_EQ(stool.problem.parts.size(), 4U);
  // pi * 0.02^2 * 0.4 m^3 of 600 kg/m^3; the mesh of the seat has no density.
  EXPECT_NEAR(stool.problem.parts[0].mass, 3.14159265 * 0.0004 * 0.4 * 600, 1e-8);
  EXPECT_NEAR(stool.problem.parts[3].mass, 3.14159265 * 0.0225 * 0.03 * 600, 1e-8);
  EXPECT_EQ(connection_ids(Problem(stool.problem)),
            (std::vector<std::string>{"leg_a-seat", "leg_b-seat", "leg_c-seat"}));
  EXPECT_EQ(stool.notes, std::vector<std::string>{
                             "1 weld repeats a pair of bodies: each pair is one connection"});

  const Converted shelf = read_format(example("shelf_mjcf.xml"), "mjcf");
  std::vector<std::string> ids;
  for (const Part& part : shelf.problem.parts) ids.push_back(part.id);
  EXPECT_EQ(ids, (std::vector<std::string>{"left", "right", "board 1", "board 2"}));
  EXPECT_NEAR(shelf.problem.parts[2].mass, 1.52, 1e-12);  // with the clip that hangs on it
  EXPECT_EQ(shelf.problem.connections[1].parts, (std::array<std::string, 2>{"right", "board 1"}));
  EXPECT_EQ(shelf.notes.size(), 3U);

  const Converted blocks = read_format(example("blocks_mjcf.xml"), "mjcf");
  EXPECT_EQ(blocks.problem.parts[0].mass, 1);
  EXPECT_EQ(blocks.notes,
            std::vector<std::string>{
                "masses are left out, so each part has 1 kg: line 3 does not tell its own"});
}

TEST(Mjcf, WorksOutTheMassesOfSimpleShapes) {
  const auto mass = [](const std::string& geom) {
    const Converted read_back =
        read_format("<mujoco><worldbody><body>" + geom + "</body></worldbody></mujoco>", "mjcf");
    return read_back.problem.parts[0].mass;
  };
  constexpr double kPi = 3.14159265358979;
  EXPECT_NEAR(mass(R"(<geom size="0.1"/>)"), 4.0 / 3 * kPi, 1e-9);  // water, by MuJoCo's default
  EXPECT_NEAR(mass(R"(<geom type="box" size="0.1 0.2 0.3" density="10"/>)"), 0.48, 1e-12);
  EXPECT_NEAR(mass(R"(<geom type="capsule" size="0.1 0.5"/>)"), kPi * 10 + 4.0 / 3 * kPi, 1e-9);
  EXPECT_NEAR(mass(R"(<geom type="ellipsoid" size="0.1 0.1 0.2"/>)"), 8.0 / 3 * kPi, 1e-9);
  EXPECT_EQ(mass(R"(<geom type="mesh" mass="2"/><geom type="box" size="1 1 1" mass="0.5"/>)"), 2.5);
  EXPECT_EQ(mass(R"(<inertial mass="7"/><geom size="0.1"/>)"), 7);
}

TEST(Mjcf, SaysInWhichLineAFaultStands) {
  const auto in_world = [](const std::string& world, const std::string& equality = "") {
    return fault("<mujoco>\n<worldbody>" + world + "</worldbody>\n<equality>" + equality +
                     "</equality></mujoco>",
                 "mjcf");
  };
  EXPECT_EQ(fault("<graphml/>", "mjcf"),
            "line 1: the outermost element of MJCF is <mujoco>, not <graphml>");
  EXPECT_EQ(in_world(""), "there is no <body> in a <worldbody>, so there are no parts");
  EXPECT_EQ(in_world("\n<body name='a'/>\n<body name='a'/>"),
            "line 4: the body \"a\" is there already");
  EXPECT_EQ(in_world("<body name='a'/>", "<weld body1='a' body2='b'/>"),
            "line 3: there is no body \"b\"");
  EXPECT_EQ(in_world("<body name='a'/>", "<weld site1='s' body2='a'/>"),
            "line 3: there is no site \"s\"");
  EXPECT_EQ(in_world("<body><composite/></body>"),
            "line 2: <composite> is not followed; let MuJoCo write the whole model out first "
            "(mj_saveLastXML)");
  EXPECT_EQ(fault("<mujoco>\n<include file='x.xml'/></mujoco>", "mjcf").substr(0, 34),
            "line 2: <include> is not followed;");
}

TEST(Mjcf, ReadsADeepFileWithoutRecursion) {
  std::string deep = "<mujoco><worldbody>";
  for (int i = 0; i < 100'000; ++i) deep += "<body>";
  for (int i = 0; i < 100'000; ++i) deep += "</body>";
  EXPECT_EQ(read_format(deep + "</worldbody></mujoco>", "mjcf").problem.parts.size(), 1U);
}

// -------------------------------------------------------------------------------------------------
// broken examples

TEST(Formats, SayWhatIsWrongWithTheBrokenExamples) {
  const std::map<std::string, std::array<std::string, 2>> sentences = {
      {"unknown_node.graphml", {"graphml", "line 6: edge 1: there is no node \"ild\""}},
      {"twice_node_link.json",
       {"node-link", "nodes[2]: node \"base\" is there already, at nodes[0]"}},
      {"unknown_task.in2", {"in2", "line 6: \"4\" is not a task, a whole number from 1 to 3"}},
      {"three_parts_pycaalp.json",
       {"pycaalp", "joints.seam.parts: expected two names of parts, found 3"}},
      {"not_symmetric.csv",
       {"matrices",
        "line 3: contact is not symmetric: \"base\" touches \"lid\" in one line and not in the "
        "other"}},
      {"unknown_body_mjcf.xml", {"mjcf", "line 3: there is no body \"seet\""}}};
  std::size_t files = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(source_folder() / "examples/formats/broken")) {
    const std::string name = entry.path().filename().string();
    ASSERT_TRUE(sentences.contains(name)) << name;
    const std::string text = bytes_of(entry.path());
    EXPECT_EQ(format_of_input(name, text).name, sentences.at(name)[0]);
    EXPECT_EQ(fault(text, sentences.at(name)[0]), sentences.at(name)[1]);
    ++files;
  }
  EXPECT_EQ(files, sentences.size());
}

// -------------------------------------------------------------------------------------------------
// PDDL

TEST(Pddl, RefusesWhatItCannotSay) {
  const auto refused = [](const std::string& more) {
    const Problem problem = parse_problem(
        R"({"format": "orasp-problem/1", "parts": [{"id": "1"}, {"id": "2"}], "connections": )"
        R"([{"parts": ["1", "2"]}], )" +
        more + "}");
    return fault_of([&] { return write_format(problem, "pddl-domain"); });
  };
  EXPECT_EQ(
      refused(R"("limits": {"max_moved_parts": 1})"),
      "pddl cannot say it: the limits of the problem look at the pieces that a step makes, not "
      "at what was done");
  EXPECT_EQ(refused(R"("blocking": {"directions": ["+x", "-x"], "blocked": [{"part": "1", "by": "2",
                       "directions": ["+x"]}]})"),
            "pddl cannot say it: blocking looks at the pieces that a step makes, not at what was "
            "done");
  EXPECT_EQ(refused(R"("blocking": {"directions": ["+x", "-x"], "blocked": []})"), "no fault");
  EXPECT_EQ(refused(R"("action": "part")"),
            "pddl cannot say it: steps take parts off, not single connections");
  EXPECT_NE(fault_of([] { return write_format(load_scenario("fleet-lattice"), "pddl-problem"); }),
            "no fault");
}

// -------------------------------------------------------------------------------------------------
// plans

/// Some order of the tasks of a task graph in which each comes after those that it waits for.
std::vector<std::size_t> some_order(const json& tasks, SplitMix64& random) {
  std::vector<bool> done(tasks.size(), false);
  std::vector<std::size_t> order;
  while (order.size() < tasks.size()) {
    std::vector<std::size_t> ready;
    for (std::size_t t = 0; t < tasks.size(); ++t) {
      const bool waits = std::ranges::any_of(tasks[t]["after"], [&](const json& early) {
        return !done[early.get<std::size_t>() - 1];
      });
      if (!done[t] && !waits) ready.push_back(t);
    }
    const std::size_t t = ready.at(random.below(ready.size()));
    done[t] = true;
    order.push_back(t);
  }
  return order;
}

/// The parts that hang together with `part` over the connections of `present`.
std::set<std::string> piece_of(const Problem& problem, const std::set<std::string>& present,
                               const std::string& part) {
  std::set<std::string> piece = {part};
  for (bool grows = true; grows;) {
    grows = false;
    for (const Connection& connection : problem.connections()) {
      if (!present.contains(connection.id)) continue;
      const bool first = piece.contains(connection.parts[0]);
      if (first == piece.contains(connection.parts[1])) continue;
      piece.insert(connection.parts[first ? 1 : 0]);
      grows = true;
    }
  }
  return piece;
}

bool holds_base(const Problem& problem, const std::set<std::string>& piece) {
  return std::ranges::any_of(problem.spec().base,
                             [&](const std::string& part) { return piece.contains(part); });
}

/// Whatever the order in which the tasks are done that allow it: the plan stays legal, each task
/// takes off (or brings) just the piece that it names, and what only loosens takes nothing off.
/// Pieces are found by walking the connections.
void expect_tasks_hold(const Problem& problem, const PlanFile& plan, std::uint64_t seed,
                       std::size_t& reordered) {
  const json graph = json::parse(write_format(problem, "task-graph", plan).text);
  const json& tasks = graph["tasks"];
  const bool assembly = problem.direction() == Direction::Assembly;
  SplitMix64 random(seed);
  for (int round = 0; round < 5; ++round) {
    PlanFile other;
    std::vector<std::pair<json, json>> steps;  // of each its task, and itself
    for (const std::size_t t : some_order(tasks, random)) {
      for (const json& step : tasks[t]["steps"]) {
        steps.emplace_back(tasks[t], step);
        other.sequence.push_back(step["connections"][0]);
      }
    }
    EXPECT_TRUE(replayed(problem, other).valid) << seed;
    reordered += other.sequence != plan.sequence;
    if (assembly) std::ranges::reverse(steps);
    std::set<std::string> present;
    for (const Connection& connection : problem.connections()) present.insert(connection.id);
    for (const auto& [task, step] : steps) {
      const std::string id = step["connections"][0];
      present.erase(id);
      const auto connection = std::ranges::find(problem.connections(), id, &Connection::id);
      const std::set<std::string> a = piece_of(problem, present, connection->parts[0]);
      const std::set<std::string> b = piece_of(problem, present, connection->parts[1]);
      if (step["act"] == "take_off" || step["act"] == "bring") {
        const auto moved = task["moved"].get<std::set<std::string>>();
        EXPECT_TRUE(moved == a || moved == b) << seed << ": " << id;
        EXPECT_NE(a, b) << seed << ": " << id;
      } else if (a != b) {
        EXPECT_TRUE(holds_base(problem, a) && holds_base(problem, b)) << seed << ": " << id;
      }
    }
  }
}

TEST(TaskGraph, KeepsPlansLegalAndWhatTheyMoveInEveryOrderThatItAllows) {
  std::size_t reordered = 0;
  int plans = 0;
  for (std::uint64_t seed = 0; seed < some_of<std::uint64_t>(300); ++seed) {
    // Half of them with a fixed part, which moves nothing that holds it.
    ProblemSpec spec = random_problem(seed);
    if (seed % 2 == 0 && !spec.parts.empty()) spec.base = {spec.parts[seed % spec.parts.size()].id};
    const Problem problem(std::move(spec));
    const Result result = solve(problem, "auto");
    if (!result.has_plan()) continue;
    PlanFile plan;
    for (const ConnectionIndex c : result.sequence)
      plan.sequence.push_back(problem.connection_id(c));
    expect_tasks_hold(problem, plan, seed, reordered);
    ++plans;
  }
  EXPECT_GT(plans, least_of(100));
  EXPECT_GT(reordered, least_of<std::size_t>(100));
}

TEST(TaskGraph, SaysTheWayInWhichPiecesGo) {
  const Problem stack = read(example("stack_matrices.csv"), "matrices");
  const PlanFile plan = plan_of({"base-ring", "base-lid", "ring-lid"});
  const json apart = json::parse(write_format(stack, "task-graph", plan).text);
  // The base is lighter than ring and lid together, and leaves downward.
  EXPECT_EQ(apart["tasks"][0]["direction"], "-z");
  EXPECT_EQ(apart["tasks"][0]["motion"], json({0.0, 0.0, -1.0}));
  const Problem together = stack.with_direction(Direction::Assembly);
  const PlanFile back = plan_of({"ring-lid", "base-lid", "base-ring"});
  const json made = json::parse(write_format(together, "task-graph", back).text);
  EXPECT_EQ(made["direction"], "assembly");
  ASSERT_EQ(made["tasks"].size(), 2U);
  EXPECT_EQ(made["tasks"][1]["direction"],
            "-z");  // as a plan states it: the way in which it leaves
  EXPECT_EQ(made["tasks"][1]["motion"], json({0.0, 0.0, 1.0}));
  EXPECT_EQ(made["tasks"][1]["steps"][0]["act"], "bring");
  EXPECT_EQ(made["tasks"][1]["steps"][1]["act"], "fasten");
  EXPECT_EQ(made["tasks"][1]["after"], json({1}));
}

TEST(TaskGraph, WaitsStepByStepWhereTheOrderIsNotKnown) {
  const Problem problem = parse_problem(R"({"format": "orasp-problem/1", "action": "part",
    "parts": [{"id": "a"}, {"id": "b"}, {"id": "c"}, {"id": "d"}],
    "connections": [{"parts": ["a", "b"]}, {"parts": ["b", "c"]}, {"parts": ["a", "d"]}]})");
  const Result result = solve(problem, "auto");
  const PlanFile plan = parse_plan(plan_text(problem, result, {}), problem.direction());
  const Written written = write_format(problem, "task-graph", plan);
  EXPECT_EQ(written.notes.size(), 1U);
  const json graph = json::parse(written.text);
  for (std::size_t t = 1; t < graph["tasks"].size(); ++t)
    EXPECT_EQ(graph["tasks"][t]["after"], json({t}));
}

TEST(BehaviorTree, RefusesIdsThatMeanSomethingElseInAPort) {
  const auto written = [](const std::string& id) {
    ProblemSpec spec;
    spec.parts = {{.id = "1"}, {.id = "2"}};
    spec.connections = {{.id = id, .parts = {"1", "2"}}};
    const Problem problem(std::move(spec));
    return fault_of([&] { return write_format(problem, "behavior-tree", plan_of({id})); });
  };
  EXPECT_EQ(written("a;b"),
            "behavior-tree: ids are listed with \";\" between them, and the id \"a;b\" holds one");
  EXPECT_NE(written("{a}").find("means something else in a port"), std::string::npos);
  EXPECT_EQ(written("a}"), "no fault");
}

TEST(Tables, WriteALineForEachPartConnectionAndStep) {
  const Problem problem =
      parse_problem(R"({"format": "orasp-problem/1", "name": "n", "base": ["a,1"],
    "parts": [{"id": "a,1", "name": "say \"a\"", "position": [0, 1, 2]},
              {"id": "b", "numbers": {"v": 2.5}}],
    "connections": [{"parts": ["a,1", "b"], "duration": 3, "attributes": {"tool": "M4"}}],
    "precedence": [], "objective": {"type": "time", "transfer": 0}})");
  EXPECT_EQ(
      write_format(problem, "parts-csv").text,
      "id,name,mass,x,y,z,base,number:v\n\"a,1\",\"say \"\"a\"\"\",1,0,1,2,1,\nb,,1,,,,0,2.5\n");
  EXPECT_EQ(write_format(problem, "connections-csv").text,
            "id,part_a,part_b,duration,success,axis,x,y,z,attribute:tool\n"
            "\"a,1-b\",\"a,1\",b,3,1,,,,,M4\n");
  EXPECT_EQ(write_format(problem, "steps-csv", plan_of({"a,1-b"})).text,
            "step,operation,act,connections,moved,direction,duration,reward,total\n"
            "1,1,take off,\"a,1-b\",b,,3,-3,-3\n");
  EXPECT_EQ(write_format(problem, "connections-csv").notes[0],
            "left out of what the problem says: base and objective");
}

}  // namespace
}  // namespace orasp
