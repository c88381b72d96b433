#include "orasp/io/problem_json.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "orasp/io/digest.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/transition_system.h"
#include "tests/fault.h"
#include "tests/files.h"

namespace orasp {
namespace {

const std::string kParts = R"("parts": [{"id": "1"}, {"id": "2"}, {"id": "3"}])";
const std::string kConnections = R"("connections": [{"parts": ["1", "2"]}, {"parts": ["2", "3"]}])";

/// A problem file of these members beside "format".
std::string file_of(const std::vector<std::string>& members) {
  std::string text = R"({"format": "orasp-problem/1")";
  for (const std::string& member : members) text += ", " + member;
  return text + "}";
}

/// A small problem with one more member.
std::string with(const std::string& member) {
  return file_of({kParts, kConnections, member});
}
std::string with_part(const std::string& part) {
  return file_of({R"("parts": [)" + part + "]", R"("connections": [])"});
}
std::string with_connection(const std::string& connection) {
  return file_of({kParts, R"("connections": [)" + connection + "]"});
}

std::string fault(const std::string& text) {
  return fault_of([&] { return parse_problem(text); });
}

std::string digest(const std::string& text) {
  return problem_digest(parse_problem(text));
}

/// Every key of the format, none at its default.
const char* const kEverything =
    R"({
  "format": "orasp-problem/1",
  "name": "Everything \"quoted\" é",
  "note": "a note",
  "source": "a source",
  "parts": [
    {"id": "a", "name": "corner", "product": "nut", "mass": 2.5, "position": [0.1, -2.0, 3e-05]},
    {"id": "b", "position": [1.0, 0.0, 0.0]},
    {"id": "c d", "mass": 0.0, "position": [1.0, 1.0, 0.0]}
  ],
  "connections": [
    {"id": "hinge", "parts": ["a", "b"], "duration": 0.30000000000000004, "success": 0.9, )"
    R"("axis": "+x"},
    {"parts": ["b", "c d"]},
    {"id": "second", "parts": ["b", "c d"]}
  ],
  "precedence": [
    {"connection": "hinge", "after": ["b-c d"]},
    {"connection": "second", "after_any": ["hinge", "b-c d"]}
  ],
  "blocking": {
    "directions": ["+x", "-x"],
    "blocked": [
      {"part": "a", "by": "b", "directions": ["+x"]}
    ]
  },
  "limits": {"max_subassemblies": 4, "max_moved_parts": 3, "max_moved_mass": 20.5},
  "objective": {"type": "sum", "terms": [{"weight": 0.5, "type": "time", "depot": [1.0, 2.0, )"
    R"(3.0], "speed": 2.0, "transfer": 0.0}, {"type": "expression", "formula": "-k * duration", )"
    R"("constants": {"k": 3.0}, "depot": [0.0, 0.0, 1.0]}]},
  "direction": "assembly"
}
)";

TEST(ProblemJson, ReadsEveryKey) {
  const Problem problem = parse_problem(kEverything);
  const ProblemSpec& spec = problem.spec();
  EXPECT_EQ(spec.name, "Everything \"quoted\" é");
  EXPECT_EQ(spec.note, "a note");
  EXPECT_EQ(spec.source, "a source");
  EXPECT_EQ(spec.parts[0].name, "corner");
  EXPECT_EQ(spec.parts[0].product, "nut");
  EXPECT_EQ(spec.parts[1].product, "");
  EXPECT_EQ(spec.parts[0].mass, 2.5);
  EXPECT_EQ(spec.parts[0].position, (Vector3{0.1, -2, 3e-5}));
  EXPECT_EQ(spec.parts[1].mass, 1);
  EXPECT_EQ(spec.connections[0].id, "hinge");
  EXPECT_EQ(spec.connections[0].duration, 0.1 + 0.2);
  EXPECT_EQ(spec.connections[0].success, 0.9);
  EXPECT_EQ(spec.connections[0].axis, "+x");
  EXPECT_EQ(spec.connections[1].id, "b-c d");
  EXPECT_EQ(spec.precedence[1].after_any, (std::vector<std::string>{"hinge", "b-c d"}));
  EXPECT_EQ(problem.direction_mask(), 0b11U);
  EXPECT_EQ(spec.limits.max_subassemblies, 4U);
  EXPECT_EQ(spec.limits.max_moved_parts, 3U);
  EXPECT_EQ(spec.limits.max_moved_mass, 20.5);
  EXPECT_EQ(spec.direction, Direction::Assembly);
  const auto& terms = std::get<WeightedSum>(spec.objective.parameters).terms;
  EXPECT_EQ(terms[0].weight, 0.5);
  EXPECT_EQ(std::get<TimeObjective>(terms[0].objective.parameters).depot, (Vector3{1, 2, 3}));
  EXPECT_EQ(terms[1].weight, 1);
  EXPECT_EQ(std::get<Expression>(terms[1].objective.parameters).constants.at("k"), 3);
}

TEST(ProblemJson, ReadsAndWritesAFleet) {
  const std::string fleet =
      R"("fleet": {"robots": 4, "depot": [0.0, 1.0], "sites": [[1.0, 0.0], [-1.0, -2.0]]})";
  const Problem problem = parse_problem(with(fleet));
  const ProblemSpec& spec = problem.spec();
  EXPECT_EQ(spec.fleet->robots, 4U);
  EXPECT_EQ(spec.fleet->sites[1], (std::array<double, 2>{-1, -2}));
  EXPECT_EQ(spec.objective.type, "makespan");  // what a fleet means that states nothing
  EXPECT_NE(problem_text(problem).find(fleet), std::string::npos) << problem_text(problem);
  EXPECT_EQ(
      parse_problem(with(fleet + R"(, "objective": {"type": "fleet_travel"})")).objective().type,
      "fleet_travel");
  EXPECT_EQ(
      fault(with(fleet + R"(, "objective": {"type": "time"})")),
      "objective.type: \"time\" judges plans of one robot, and a problem with \"fleet\" has "
      "an objective of several, makespan or fleet_travel; without \"fleet\" it is planned for "
      "one");
}

TEST(ProblemJson, WritesWhatItRead) {
  EXPECT_EQ(problem_text(parse_problem(kEverything)), kEverything);
}

TEST(ProblemJson, UnderstandsEscapes) {
  EXPECT_EQ(parse_problem(with(R"("name": "\u00e9\ud83d\ude00\/")")).name(), "é😀/");
}

TEST(ProblemJson, FillsInDefaults) {
  const Problem problem = parse_problem(file_of({kParts, kConnections}));
  EXPECT_EQ(problem.objective().type, "cubesat");
  EXPECT_EQ(problem.direction(), Direction::Disassembly);
  EXPECT_EQ(problem.parts()[0].mass, 1);
  EXPECT_FALSE(problem.parts()[0].position);
  EXPECT_EQ(problem.connections()[0].duration, 1);
  EXPECT_EQ(problem.connections()[0].success, 1);
  EXPECT_FALSE(problem.limits().max_subassemblies);
}

TEST(ProblemJson, LeavesOutDefaultsWhenWriting) {
  EXPECT_EQ(problem_text(parse_problem(file_of({kParts, kConnections}))), R"({
  "format": "orasp-problem/1",
  "parts": [
    {"id": "1"},
    {"id": "2"},
    {"id": "3"}
  ],
  "connections": [
    {"parts": ["1", "2"]},
    {"parts": ["2", "3"]}
  ],
  "objective": {"type": "cubesat"}
}
)");
  EXPECT_EQ(problem_text(parse_problem(file_of({R"("parts": [])", R"("connections": [])"}))), R"({
  "format": "orasp-problem/1",
  "parts": [],
  "connections": [],
  "objective": {"type": "cubesat"}
}
)");
}

TEST(ProblemJson, WritesEveryObjectiveSoThatItReadsBack) {
  for (const std::string objective : {
           R"({"type": "piece_cost"})",
           R"({"type": "piece_cost", "operation": 0.5, "pieces": {"1": 1.0, "12": -2.0}, )"
           R"("completion": 3.0})",
           R"({"type": "cubesat"})",
           R"({"type": "cubesat_zone"})",
           R"({"type": "custom"})",
           R"({"type": "indexed"})",
           R"({"type": "time"})",
           R"({"type": "fuel", "dry_mass": 5.0, "delta_v": 31.0, "isp": 210.0})",
           R"({"type": "completion", "join": 1.0, "step": 2.0, "bonus": 3.0})",
           R"({"type": "expression", "formula": "before"})",
           R"({"type": "sum", "terms": [{"type": "sum", "terms": [{"weight": -1.0, "type": )"
           R"("fuel"}]}]})",
       }) {
    const Problem problem = parse_problem(with(R"("objective": )" + objective));
    const std::string text = problem_text(problem);
    EXPECT_NE(text.find("\"objective\": " + objective + "\n"), std::string::npos) << text;
    EXPECT_EQ(problem_digest(parse_problem(text)), problem_digest(problem)) << objective;
  }
}

TEST(ProblemJson, RoundTripsItsOwnScenarios) {
  const auto files = json_files(source_folder() / "data" / "scenarios");
  EXPECT_GE(files.size(), 12U);
  for (const auto& file : files) {
    const Problem problem = read_problem(file);
    const std::string text = problem_text(problem);
    EXPECT_EQ(problem_digest(parse_problem(text)), problem_digest(problem)) << file;
    EXPECT_EQ(problem_text(parse_problem(text)), text) << file;
  }
}

TEST(ProblemJson, RoundTripsThePublishedProblems) {
  const auto folder = shared_folder() / "problems";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const auto files = json_files(folder);
  EXPECT_FALSE(files.empty());
  for (const auto& file : files) {
    const Problem problem = read_problem(file);
    EXPECT_EQ(problem_digest(parse_problem(problem_text(problem))), problem_digest(problem))
        << file;
  }
}

TEST(ProblemJson, CannotWriteACallable) {
  Callable callable;
  callable.reward = [](const Step&) { return 0.0; };
  const Problem problem =
      load_scenario("4brick").with_objective({"sum", WeightedSum{{{1, {"callable", callable}}}}});
  EXPECT_EQ(fault_of([&] { return problem_text(problem); }),
            "objective: a callable is code and cannot be written to a file; use \"expression\"");
  EXPECT_EQ(problem_digest(problem).size(), 64U);
}

TEST(ProblemJson, IgnoresNotesAndKeysOfOthers) {
  EXPECT_EQ(fault(with(R"("x-tool": {"deep": [1, {"a": null}]}, "note": "n", "source": "s")")),
            "no fault");
  EXPECT_EQ(fault(with_part(R"({"id": "1", "note": "n", "x-colour": 3})")), "no fault");
  EXPECT_EQ(fault(with(R"("objective": {"type": "cubesat", "note": "n", "x-a": 1})")), "no fault");
  EXPECT_EQ(
      fault(with(
          R"("objective": {"type": "piece_cost", "pieces": {"1": 2, "note": "n", "x-a": 1}})")),
      "no fault");
  EXPECT_EQ(fault(with(R"("note": 3)")), "note: expected a string, found the number 3");
}

TEST(ProblemJson, NamesAnUnknownKeyItsPlaceAndTheNearest) {
  EXPECT_EQ(
      fault(with(R"("presedence": [])")),
      "unknown key \"presedence\"; known keys are format, name, note, source, parts, "
      "connections, precedence, "
      "blocking, limits, base, goal, action, objective, direction, fleet, geometry; did you mean "
      "\"precedence\"?");
  EXPECT_EQ(fault(with_part(R"({"id": "1", "weight": 2})")),
            "parts[0]: unknown key \"weight\"; known keys are id, name, product, mass, "
            "position, numbers");
  EXPECT_EQ(
      fault(with(R"("limits": {"max_moved_part": 2})")),
      "limits: unknown key \"max_moved_part\"; known keys are max_subassemblies, max_moved_parts, "
      "max_moved_mass, grounded; did you mean \"max_moved_parts\"?");
  EXPECT_EQ(fault(with(R"("objective": {"type": "time", "weight": 2})")),
            "objective: unknown key \"weight\"; known keys are type, depot, speed, transfer");
}

TEST(ProblemJson, NamesAMissingKey) {
  EXPECT_EQ(fault(R"({"parts": [], "connections": []})"), "the key \"format\" is missing");
  EXPECT_EQ(fault(file_of({kConnections})), "the key \"parts\" is missing");
  EXPECT_EQ(fault(file_of({kParts})), "the key \"connections\" is missing");
  EXPECT_EQ(fault(with_part("{}")), "parts[0]: the key \"id\" is missing");
  EXPECT_EQ(fault(with_connection(R"({"id": "x"})")),
            "connections[0]: the key \"parts\" is missing");
  EXPECT_EQ(
      fault(with(R"("precedence": [{"connection": "1-2"}])")),
      "precedence[0]: \"after\", \"after_any\", \"made_after\" or \"made_after_any\" is missing, "
      "one is needed");
  EXPECT_EQ(fault(with(R"("objective": {})")), "objective: the key \"type\" is missing");
  EXPECT_EQ(fault(with(R"("objective": {"type": "expression"})")),
            "objective: the key \"formula\" is missing");
  EXPECT_EQ(fault(with(R"("fleet": {})")), "fleet: the key \"robots\" is missing");
}

TEST(ProblemJson, SaysWhatItFoundInsteadOfWhatItWanted) {
  EXPECT_EQ(fault("[]"), "expected a problem, which is an object, found an empty array");
  EXPECT_EQ(fault(R"({"format": 1})"), "format: expected a string, found the number 1");
  EXPECT_EQ(fault(R"({"format": "orasp-plan/1"})"),
            "format: \"orasp-plan/1\" is not the format of a problem; that is \"orasp-problem/1\"");
  EXPECT_EQ(fault(with_part(R"({"id": 1})")),
            "parts[0].id: expected an id, which is a string, found the number 1; write \"1\"");
  EXPECT_EQ(fault(with_part(R"({"id": "1", "mass": "heavy"})")),
            "parts[0].mass: expected a number, found the string \"heavy\"");
  EXPECT_EQ(fault(with_part(R"({"id": "1", "position": [1, 2]})")),
            "parts[0].position: expected an array of 3 numbers, found 2");
  EXPECT_EQ(fault(with_part(R"({"id": "1", "position": [1, 2, null]})")),
            "parts[0].position[2]: expected a number, found null");
  EXPECT_EQ(fault(with_connection(R"({"parts": ["1"]})")),
            "connections[0].parts: expected two part ids, found 1");
  EXPECT_EQ(fault(with_connection(R"({"id": "", "parts": ["1", "2"]})")),
            "connections[0].id: an id must not be empty");
  EXPECT_EQ(
      fault(with(R"("limits": {"max_moved_parts": 1.5})")),
      "limits.max_moved_parts: expected a whole number from 0 to 2^53 - 1, found the number 1.5");
  EXPECT_EQ(
      fault(with(R"("limits": {"max_moved_parts": -1})")),
      "limits.max_moved_parts: expected a whole number from 0 to 2^53 - 1, found the number -1");
  EXPECT_EQ(fault(with(R"("limits": null)")), "limits: expected an object, found null");
  EXPECT_EQ(fault(with(R"("objective": "cubesat")")),
            "objective: expected an object such as {\"type\": \"cubesat\"}, found the string "
            "\"cubesat\"");
  EXPECT_EQ(fault(with(R"("direction": "forward")")),
            "direction: \"forward\" is not a direction of planning; those are \"disassembly\" and "
            "\"assembly\"");
}

TEST(ProblemJson, AllowsALimitOfZero) {
  EXPECT_EQ(
      fault(
          with(R"("limits": {"max_subassemblies": 0, "max_moved_parts": 0, "max_moved_mass": 0})")),
      "no fault");
}

TEST(ProblemJson, RefusesAnEmptyAfterAnyOnly) {
  EXPECT_EQ(fault(with(R"("precedence": [{"connection": "1-2", "after": []}])")), "no fault");
  EXPECT_EQ(
      fault(with(R"("precedence": [{"connection": "1-2", "after": ["2-3"], "after_any": []}])")),
      "precedence[0].after_any: an empty list could never be met; leave the key out");
  EXPECT_EQ(fault(with(R"("precedence": [{"connection": "1-2", "made_after": []}])")), "no fault");
  EXPECT_EQ(fault(with(R"("precedence": [{"connection": "1-2", "made_after_any": []}])")),
            "precedence[0].made_after_any: an empty list could never be met; leave the key out");
  EXPECT_EQ(
      fault(with(R"("precedence": [{"connection": "1-2", "made_after": ["2-3", "9"]}])")),
      "precedence[0].made_after[1]: no connection \"9\"; connections are \"1-2\" and \"2-3\"");
}

TEST(ProblemJson, ReadsAndWritesHowAProductIsMade) {
  const Problem problem = parse_problem(with(
      R"("precedence": [{"connection": "1-2", "made_after": ["2-3"],
                                         "made_after_any": ["2-3"]}])"));
  const Precedence& rule = problem.spec().precedence.front();
  EXPECT_EQ(rule.made_after, std::vector<std::string>{"2-3"});
  EXPECT_EQ(rule.made_after_any, std::vector<std::string>{"2-3"});
  EXPECT_EQ(problem_digest(parse_problem(problem_text(problem))), problem_digest(problem));
  // 2-3 is removed only after 1-2: the same rule.
  EXPECT_EQ(digest(with(R"("precedence": [{"connection": "1-2", "made_after": ["2-3"]}])")),
            digest(with(R"("precedence": [{"connection": "2-3", "after": ["1-2"]}])")));
}

TEST(ProblemJson, ReportsWhatTheConstructorFinds) {
  EXPECT_EQ(fault(with_connection(R"({"parts": ["1", "17"]})")),
            "connections[0].parts[1]: no part \"17\"; parts are \"1\", \"2\" and \"3\"");
  EXPECT_EQ(
      fault(with(
          R"("objective": {"type": "sum", "terms": [{"type": "expression", "formula": "2 +"}]})")),
      "objective.terms[0].formula: the formula ends too early");
}

TEST(ProblemJson, NamesTheLineAndColumnOfMalformedJson) {
  EXPECT_EQ(fault(""), "the file is empty");
  EXPECT_EQ(fault(" \n"), "the file is empty");
  EXPECT_EQ(fault("{\n\n  \"format\": @ }"), "line 3, column 13: \"@\" is not a JSON value");
  EXPECT_EQ(fault("{\n  \"a\": tru\n}"), "line 2, column 8: \"tru\" is not a JSON value");
  EXPECT_EQ(fault("{\"\u00e9\": nul}"),
            "line 1, column 7: \"nul\" is not a JSON value");  // characters, not bytes
  EXPECT_EQ(fault("{\"a\": 1,}"), "line 1, column 9: unexpected '}'; expected a key in quotes");
  EXPECT_EQ(fault("{\"a\": [1 2]}"), "line 1, column 10: unexpected number; expected ',' or ']'");
  EXPECT_EQ(fault("{\"a\" 1}"), "line 1, column 6: unexpected number; expected ':'");
  EXPECT_EQ(fault("{\"a\": }"), "line 1, column 7: unexpected '}'; expected a value");
  EXPECT_EQ(fault("{a: 1}"), "line 1, column 2: \"a\" is not a key; keys stand in double quotes");
  EXPECT_EQ(fault("{'a': 1}"),
            "line 1, column 2: \"'\" is not JSON; strings stand in double quotes");
  EXPECT_EQ(fault("{} {}"), "line 1, column 4: unexpected '{'; expected nothing more");
  EXPECT_EQ(fault("{\"a\": [1, 2"), "line 1, column 12: the text ends too early");
  EXPECT_EQ(fault("// hello\n{}"),
            "line 1, column 1: \"/\" is not JSON, which has no comments; use the key \"note\"");
  EXPECT_EQ(fault("{\"a\": NaN}"),
            "line 1, column 7: \"NaN\" is not JSON, which has finite numbers only");
  EXPECT_EQ(fault("{\"a\": [-1e999]}"), "line 1, column 8: the number \"-1e999\" is too large");
}

TEST(ProblemJson, RefusesBytesThatAreNotText) {
  EXPECT_EQ(fault("{\"a\": \"\xff\"}"), "line 1, column 8: the byte 0xff is not valid UTF-8");
  EXPECT_EQ(fault("{\"a\": \"\xed\xa0\x80\"}"),
            "line 1, column 8: the byte 0xed is not valid UTF-8");
  EXPECT_EQ(fault(file_of({kParts, kConnections}) + std::string("\0{", 2)).find("line 1, column "),
            0U);
}

TEST(ProblemJson, SkipsAByteOrderMark) {
  EXPECT_EQ(fault("\xEF\xBB\xBF" + file_of({kParts, kConnections})), "no fault");
}

TEST(ProblemJson, RefusesAKeyThatAppearsTwice) {
  EXPECT_EQ(fault(with_part(R"({"id": "1", "id": "2"})")),
            "parts[0]: the key \"id\" appears twice");
  EXPECT_EQ(fault(with(R"("note": "a", "note": "b")")), "the key \"note\" appears twice");
  EXPECT_EQ(fault(with(R"("x-a": {"b": [0, {"c": 1, "d": 2, "c": 3}]})")),
            "x-a.b[1]: the key \"c\" appears twice");
}

TEST(ProblemJson, SurvivesDeepNesting) {
  for (const std::string open : {"[", "{\"a\":"}) {
    std::string text;
    for (int i = 0; i < 100'000; ++i) text += open;
    EXPECT_EQ(fault(text), "arrays and objects are nested more than 64 deep");
  }
}

TEST(ProblemJson, StopsReadingALongListEarly) {
  std::string list;
  for (int i = 0; i < 20'000; ++i) list += "{},";
  // The list is not even closed: nothing behind the 16,385th element is looked at.
  EXPECT_EQ(fault(file_of({kParts, "\"connections\": [" + list})),
            "connections: more than 16384 connections, the most a problem may have");
  EXPECT_EQ(fault(file_of({"\"parts\": [" + list})),
            "parts: more than 16384 parts, the most a problem may have");
}

TEST(ReadProblem, NamesTheFile) {
  const TemporaryFolder folder;
  const std::string file =
      folder.file("shelf.json", with_connection(R"({"parts": ["1", "9"]})")).string();
  EXPECT_EQ(fault_of([&] { return read_problem(file); }),
            file + ": connections[0].parts[1]: no part \"9\"; parts are \"1\", \"2\" and \"3\"");
  EXPECT_EQ(fault_of([&] { return read_problem(folder.path()); }),
            folder.path().string() + ": it is a directory, not a file");
  EXPECT_EQ(fault_of([&] { return read_problem(folder.path() / "none.json"); }),
            (folder.path() / "none.json").string() + ": No such file or directory");
  EXPECT_EQ(fault_of([&] { return read_problem(folder.file("empty.json", "")); }),
            (folder.path() / "empty.json").string() + ": the file is empty");
}

TEST(ReadProblem, RefusesAFileThatIsTooLarge) {
  const TemporaryFolder folder;
  const auto file = folder.file("large.json", "{");
  std::filesystem::resize_file(
      file, (std::uintmax_t{256} << 20U) + 1);  // a hole: takes no room on the disk
  EXPECT_EQ(fault_of([&] { return read_problem(file); }),
            file.string() + ": it is larger than 256 MiB");
}

TEST(ParseObjective, PutsThePlaceInFront) {
  EXPECT_EQ(
      fault_of([] { return parse_objective(R"({"type": "time", "speed": 0})", "--objective"); }),
      "--objective.speed: 0 is not allowed; it must be above 0");
  EXPECT_EQ(fault_of([] {
              return parse_objective(R"({"type": "tme"})", "tug.json");
            }).find("tug.json.type: "),
            0U);
  EXPECT_EQ(fault_of([] { return parse_objective("{", "tug.json"); }),
            "tug.json: line 1, column 2: the text ends too early");
  EXPECT_EQ(parse_objective(R"({"type": "fuel", "isp": 300})", "--objective").type, "fuel");
}

// docs/format.md, section "Digest", writes this text out.
TEST(ProblemDigest, IsThatOfTheCanonicalText) {
  EXPECT_EQ(
      problem_digest(load_scenario("4brick")),
      detail::sha256_hex(
          R"({"format":"orasp-problem/1",)"
          R"("parts":[["1",1.0,null],["2",1.0,null],["3",1.0,null],["4",1.0,null]],)"
          R"("connections":[["1-2",[0,1],1.0,1.0,null],["2-3",[1,2],1.0,1.0,null],)"
          R"(["3-4",[2,3],1.0,1.0,null]],)"
          R"("precedence":[],"blocking":null,)"
          R"("limits":{"max_subassemblies":null,"max_moved_parts":null,"max_moved_mass":null},)"
          R"("objective":{"type":"piece_cost","operation":0.0,)"
          R"("pieces":{"1":0.0967,"2":0.1248,"3":0.1368},)"
          R"("completion":1.0},"direction":"disassembly","fleet":null})"));
}

TEST(ProblemDigest, IgnoresWhatPlanningIgnores) {
  const std::string plain = digest(file_of({kParts, kConnections}));
  EXPECT_EQ(digest(with(R"("name": "N", "note": "n", "source": "s", "x-y": 1)")), plain);
  EXPECT_EQ(
      digest(with(R"("direction": "disassembly", "objective": {"type": "cubesat"}, "limits": {})")),
      plain);
  EXPECT_EQ(digest(with(R"("precedence": [{"connection": "1-2", "after": []}])")), plain);
  EXPECT_EQ(digest(with(R"("blocking": {"directions": ["+x", "-x"], "blocked": []})")), plain);
  EXPECT_EQ(
      digest(file_of(
          {R"("parts": [{"id": "1", "mass": 1, "name": "n", "product": "p"}, {"id": "2"}, )"
           R"({"id": "3"}])",
           R"("connections": [{"id": "1-2", "parts": ["1", "2"], "duration": 1e0, "success": 1},
                                               {"parts": ["2", "3"]}])"})),
      plain);
}

std::string blocked_with(const std::string& width, const std::string& tolerance) {
  return with(R"("blocking": {"directions": ["+x", "-x"], "x-tolerance": )" + tolerance +
              R"(, "blocked": [{"part": "1", "by": "2", "directions": ["+x"], "x-width": )" +
              width + "}]}");
}

TEST(ProblemJson, KeepsTheWidthsOfFacts) {
  const Problem problem = parse_problem(blocked_with("[0.00025]", "1e-4"));
  const Blocking& blocking = *problem.spec().blocking;
  EXPECT_EQ(blocking.blocked[0].widths, std::vector<double>{0.00025});
  EXPECT_EQ(blocking.tolerance, 1e-4);
  const Problem again = parse_problem(problem_text(problem));
  EXPECT_EQ(again.spec().blocking->blocked[0].widths, blocking.blocked[0].widths);
  EXPECT_EQ(again.spec().blocking->tolerance, blocking.tolerance);
  EXPECT_EQ(problem_digest(problem), digest(blocked_with("[1]", "2")));
}

TEST(ProblemJson, ANoteThatIsNoWidthIsNoFault) {
  for (const char* width :
       {"[]", "[0.1, 0.2]", "\"wide\"", "[\"wide\"]", "[-1]", "[0]", "null", "{}"}) {
    const Problem problem = parse_problem(blocked_with(width, width));
    EXPECT_TRUE(problem.spec().blocking->blocked[0].widths.empty()) << width;
    EXPECT_EQ(problem.spec().blocking->tolerance, 0) << width;
  }
}

TEST(ProblemDigest, IgnoresTheOrderOfConstraints) {
  EXPECT_EQ(digest(with(R"("precedence": [{"connection": "1-2", "after": ["2-3", "1-2"]}])")),
            digest(with(R"("precedence": [{"connection": "1-2", "after": ["1-2"]},
                                          {"connection": "1-2", "after": ["2-3", "2-3"]}])")));
  EXPECT_EQ(digest(with(R"("blocking": {"directions": ["+x", "-x"],
                                        "blocked": [{"part": "1", "by": "2", "directions": )"
                        R"(["+x"]}]})")),
            digest(with(R"("blocking": {"directions": ["-x", "+x"],
                                        "blocked": [{"part": "2", "by": "1", "directions": )"
                        R"(["-x"]}]})")));
}

std::string named(const std::string& directions, const std::string& blocked = R"("slant")") {
  return with(R"("blocking": {"directions": [)" + directions +
              R"(], "blocked": [{"part": "1", "by": "2", "directions": [)" + blocked + "]}]}");
}

TEST(ProblemJson, ReadsAndWritesNamedDirections) {
  const std::string text =
      named(R"("+z", {"id": "slant", "vector": [3, 0, 4.0], "note": "n", "x-y": 1}, "-z")",
            R"("-slant")");
  const Problem problem = parse_problem(text);
  ASSERT_TRUE(problem.spec().blocking);
  const auto& directions = problem.spec().blocking->directions;
  ASSERT_EQ(directions.size(), 3U);
  EXPECT_EQ(directions[0].vector, std::nullopt);
  EXPECT_EQ(directions[1].id, "slant");
  EXPECT_EQ(directions[1].vector, (Vector3{3, 0, 4}));
  const std::string written = problem_text(problem);
  EXPECT_NE(
      written.find(R"("directions": ["+z", {"id": "slant", "vector": [3.0, 0.0, 4.0]}, "-z"])"),
      std::string::npos)
      << written;
  EXPECT_EQ(problem_text(parse_problem(written)), written);
  EXPECT_EQ(digest(written), digest(text));
}

TEST(ProblemJson, RefusesNamedDirectionsThatAreNone) {
  EXPECT_EQ(fault(named(R"({"id": "slant"})")),
            "blocking.directions[0]: the key \"vector\" is missing");
  EXPECT_EQ(fault(named(R"({"id": "slant", "vector": [1, 2]})")),
            "blocking.directions[0].vector: expected an array of 3 numbers, found 2");
  EXPECT_EQ(fault(named(R"({"id": "slant", "vector": [0, 0, 0]})")),
            "blocking.directions[0].vector: a vector of length 0 points nowhere");
  EXPECT_EQ(
      fault(named(R"({"id": "slant", "vektor": [0, 0, 1]})")),
      "blocking.directions[0]: unknown key \"vektor\"; known keys are id, vector; did you mean "
      "\"vector\"?");
  EXPECT_EQ(fault(named(R"("+x", 3)")),
            "blocking.directions[1]: expected an axis, such as \"+x\", or {\"id\": ..., "
            "\"vector\": [x, y, z]}, found the number 3");
}

// The text is that of docs/format.md: the axes, then the named pairs by id, with vectors of length
// 1.
TEST(ProblemDigest, HoldsNamedDirectionsWithTheirVectors) {
  const std::string slant = R"({"id": "slant", "vector": [0.6, 0, 0.8]})";
  const std::string b = R"({"id": "b", "vector": [0, 2, 0]})";
  const std::string text = digest(named(R"("+z", "-z", )" + slant + ", " + b, R"("slant", "+z")"));
  EXPECT_EQ(digest(named(slant + R"(, "-z", )" + b + R"(, "+z")", R"("+z", "slant")")), text);
  EXPECT_EQ(digest(named(R"("+z", "-z", {"id": "slant", "vector": [3e9, -0.0, 4e9]}, )" + b,
                         R"("slant", "+z")")),
            text);
  EXPECT_NE(digest(named(R"("+z", "-z", {"id": "slant", "vector": [0.6, 0, 0.7]}, )" + b,
                         R"("slant", "+z")")),
            text);
  EXPECT_NE(digest(named(R"("+z", "-z", )" + slant, R"("slant", "+z")")), text);
  const Problem problem = parse_problem(
      R"({"format": "orasp-problem/1", "parts": [{"id": "1"}, {"id": "2"}], "connections": [],)"
      R"( "objective": {"type": "indexed"}, "blocking": {"directions": [)" +
      slant + R"(, "+z", )" + b +
      R"(, "-z"], "blocked": [{"part": "2", "by": "1", "directions": ["+z", "slant"]}]}})");
  EXPECT_EQ(
      problem_digest(problem),
      detail::sha256_hex(
          R"({"format":"orasp-problem/1","parts":[["1",1.0,null],["2",1.0,null]],)"
          R"("connections":[],"precedence":[],)"
          R"("blocking":{"directions":["+z","-z",["b",[0.0,1.0,0.0]],["slant",[0.6,0.0,0.8]]],)"
          R"("blocked":[[0,1,["-z","-slant"]]]},)"
          R"("limits":{"max_subassemblies":null,"max_moved_parts":null,"max_moved_mass":null},)"
          R"("objective":{"type":"indexed"},"direction":"disassembly","fleet":null})"));
}

TEST(ProblemDigest, DiffersWherePlanningDiffers) {
  std::vector<std::string> digests = {
      digest(file_of({kParts, kConnections})),
      digest(with(R"("direction": "assembly")")),
      digest(with(R"("objective": {"type": "time"})")),
      digest(with(R"("objective": {"type": "time", "speed": 2})")),
      digest(with(R"("limits": {"max_subassemblies": 1})")),
      digest(with(R"("limits": {"max_moved_parts": 1})")),
      digest(with(R"("precedence": [{"connection": "1-2", "after": ["2-3"]}])")),
      digest(with(R"("precedence": [{"connection": "1-2", "after_any": ["2-3"]}])")),
      digest(with(R"("precedence": [{"connection": "1-2", "made_after_any": ["2-3"]}])")),
      digest(with(R"("precedence": [{"connection": "2-3", "after": ["1-2"]}])")),
      digest(with(R"("blocking": {"directions": ["+x", "-x"],
                                  "blocked": [{"part": "1", "by": "2", "directions": ["+x"]}]})")),
      digest(with(R"("blocking": {"directions": ["+x", "-x", "+y", "-y"],
                                  "blocked": [{"part": "1", "by": "2", "directions": ["+x"]}]})")),
      digest(with(R"("fleet": {"robots": 2})")),
      digest(file_of(
          {R"("parts": [{"id": "1", "mass": 2}, {"id": "2"}, {"id": "3"}])", kConnections})),
      digest(file_of({R"("parts": [{"id": "1", "position": [0, 0, 0]}, {"id": "2"}, {"id": "3"}])",
                      kConnections})),
      digest(file_of({kParts, R"("connections": [{"parts": ["2", "3"]}, {"parts": ["1", "2"]}])"})),
      digest(file_of(
          {kParts,
           R"("connections": [{"parts": ["2", "1"], "id": "1-2"}, {"parts": ["2", "3"]}])"})),
  };
  std::sort(digests.begin(), digests.end());
  EXPECT_EQ(std::adjacent_find(digests.begin(), digests.end()), digests.end());
}

TEST(ProblemDigest, DoesNotTellMinusZeroFromZero) {
  EXPECT_EQ(digest(with_part(R"({"id": "1", "mass": -0.0, "position": [-0.0, 0, 0]})")),
            digest(with_part(R"({"id": "1", "mass": 0, "position": [0, 0, 0]})")));
}

// Every complete problem shown in the documentation loads.
TEST(FormatPage, ShowsProblemsThatLoad) {
  const auto examples = json_examples("format.md", "\"orasp-problem/1\"");
  EXPECT_GE(examples.size(), 3U);
  for (const std::string& example : examples) EXPECT_EQ(fault(example), "no fault") << example;
}

}  // namespace
}  // namespace orasp
