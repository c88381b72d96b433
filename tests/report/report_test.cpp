// The data of the report page against the model; what the page makes of them is tested in
// tests/web.

#include "orasp/report/report.h"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "orasp/catalogue.h"
#include "orasp/io/detail/json_text.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/scenario_generators.h"
#include "orasp/model/validate.h"
#include "orasp/report/fleet_report.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"
#include "tests/wide_problems.h"

namespace orasp {
namespace {

using Json = nlohmann::json;

/// A report on what `auto` finds.
Report solved(const TransitionSystem& system) {
  Report report;
  report.title = "title";
  report.best = solve(system.problem(), "auto");
  if (!report.best.has_plan()) return report;
  ReportPlan plan{.label = "auto", .origin = "Found.", .sequence = {}, .expected = {}, .notes = {}};
  for (const ConnectionIndex c : report.best.sequence)
    plan.sequence.push_back(system.problem().connection_id(c));
  report.plans = {plan};
  return report;
}

Json data_of(const Problem& problem) {
  const TransitionSystem system(problem);
  return Json::parse(report_data(system, solved(system)));
}

TEST(Report, TotalsRewardsAndPiecesAreThoseOfTheReplay) {
  for (std::uint64_t seed = 1; seed < 1 + some_of(200U); ++seed) {
    const Problem problem(random_problem(seed));
    const TransitionSystem system(problem);
    const Report report = solved(system);
    const Json data = Json::parse(report_data(system, report));
    if (report.plans.empty()) {
      EXPECT_TRUE(data["plans"].empty());
      continue;
    }
    const Evaluation evaluation =
        evaluate(system, std::span<const std::string>(report.plans.front().sequence));
    const Json& plan = data["plans"][0];
    EXPECT_TRUE(plan["valid"]);
    EXPECT_EQ(plan["status"], "optimal");
    const std::size_t n = evaluation.steps.size();
    ASSERT_EQ(plan["steps"].size(), n);
    ASSERT_EQ(plan["states"].size(), n + 1);
    // In disassembly order each operation ends with what it takes off.
    std::size_t next = 0;
    for (const Json& operation : plan["operations"]) {
      EXPECT_EQ(operation[0], next);
      next = operation[1];
      for (std::size_t k = operation[0]; k + 1 < next; ++k)
        EXPECT_FALSE(plan["steps"][k].contains("moved"));
    }
    EXPECT_EQ(next, n);
    std::vector<std::size_t> labels = plan["labels"];
    for (std::size_t k = 0; k < n; ++k) {
      // Written in disassembly order.
      const Step& step =
          evaluation.steps[problem.direction() == Direction::Assembly ? n - 1 - k : k];
      const Json& written = plan["steps"][k];
      EXPECT_EQ(written["c"], step.connection.value());
      EXPECT_EQ(written["reward"], step.reward);
      EXPECT_EQ(written.contains("moved"), step.separates);
      if (!step.separates) continue;
      EXPECT_EQ(written.contains("way"), step.direction.has_value());
      if (step.direction) {
        EXPECT_EQ(written["way"][0], problem.direction_name(*step.direction));
        EXPECT_EQ(written["way"][1], problem.direction_name(opposite(*step.direction)));
        EXPECT_EQ(written["way"][2].get<Vector3>(), problem.direction_vector(*step.direction));
      }
      EXPECT_EQ(written["moved"].get<std::vector<PartIndex>>(), step.moved());
      const std::size_t from = written["split"][0];
      for (const PartIndex part : step.moved()) EXPECT_EQ(labels[part], from);
      for (const PartIndex part : step.kept()) EXPECT_EQ(labels[part], from);
      for (const PartIndex part : step.moved()) labels[part] = written["split"][1];
      const std::set<std::size_t> pieces(labels.begin(), labels.end());
      EXPECT_EQ(plan["states"][k + 1][0], pieces.size());
      EXPECT_EQ(plan["states"][k + 1][1], std::ranges::count_if(pieces, [&](std::size_t label) {
                  return std::ranges::count(labels, label) > 1;
                }));
    }
    if (n == 0) continue;
    const bool assembly = problem.direction() == Direction::Assembly;
    EXPECT_NEAR(plan["steps"][assembly ? 0 : n - 1]["total"], evaluation.reward, 1e-9);
    EXPECT_NEAR(plan["steps"][assembly ? n - 1 : 0]["back"], evaluation.reward, 1e-9);
  }
}

/// For each part the first one of its piece, where these connections are there.
std::vector<PartIndex> firsts_of(const Problem& problem, const std::vector<bool>& there) {
  std::vector<PartIndex> first(problem.num_parts());
  for (PartIndex part = 0; part < problem.num_parts(); ++part) first[part] = part;
  for (PartIndex round = 0; round < problem.num_parts(); ++round) {
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
      const auto [a, b] = problem.ends(c);
      if (there[c]) first[a] = first[b] = std::min(first[a], first[b]);
    }
  }
  return first;
}

TEST(Report, StepsThatTakePartsOffSplitPiecesAsConnectionsDo) {
  std::size_t seen = 0;
  std::size_t fell_apart = 0;
  for (std::uint64_t seed = 1; seed < 1 + some_of(600U); ++seed) {
    const Problem problem(wide_random_problem(seed));
    if (problem.spec().action != StepKind::Part) continue;
    const TransitionSystem system(problem);
    Report report;
    report.best = solve(problem, "auto");
    if (!report.best.has_plan()) continue;
    ReportPlan plan;
    plan.part_steps = report.best.steps;
    report.plans = {plan};
    const Evaluation evaluation = replayed(system, plan);
    const Json data = Json::parse(report_data(system, report))["plans"][0];
    EXPECT_EQ(data["status"], "optimal");
    ASSERT_EQ(data["steps"].size(), plan.part_steps.size());
    std::vector<bool> there(problem.num_connections(),
                            problem.direction() == Direction::Disassembly);
    for (const PlanStep& step : plan.part_steps) {
      for (const ConnectionIndex c : step.connections) there[c] = true;
    }
    std::vector<std::size_t> labels = data["labels"];
    for (const Json& step : data["steps"]) {
      ++seen;
      for (const std::size_t c : step["cut"]) there[c] = false;
      for (const std::size_t part : step["moved"]) labels[part] = step["split"][1];
      if (step.contains("rest")) {
        ++fell_apart;
        for (const Json& piece : step["rest"]) {
          for (const std::size_t part : piece[1]) labels[part] = piece[0];
        }
      }
      const std::vector<PartIndex> first = firsts_of(problem, there);
      for (PartIndex a = 0; a < problem.num_parts(); ++a) {
        for (PartIndex b = 0; b < a; ++b) EXPECT_EQ(labels[a] == labels[b], first[a] == first[b]);
      }
    }
    EXPECT_NEAR(data["reward"].get<double>(), evaluation.reward, 1e-9);
  }
  EXPECT_GT(seen, 0);
  EXPECT_TRUE(fell_apart > 0 || some_of(600U) < 600);
}

TEST(Report, ShapesStandInThePageAndWhatIsWrongWithThemInItsData) {
  const Problem problem = load_scenario("3piece");
  const TransitionSystem system(problem);
  Report report = solved(system);
  EXPECT_TRUE(Json::parse(report_data(system, report))["shapes"].is_null());
  EXPECT_EQ(report_html(system, report).find("id=\"shapes\""), std::string::npos);
  report.shapes = PartShapes{.glb = "glTF\xff", .triangles = 1000, .triangles_read = 20'000};
  const std::string page = report_html(system, report);
  EXPECT_NE(page.find("<script type=\"application/octet-stream\" id=\"shapes\">Z2xURv8=</script>"),
            std::string::npos);
  EXPECT_EQ(Json::parse(report_data(system, report))["shapes"]["note"],
            "The parts are drawn with 1,000 triangles, simplified from 20,000 triangles.");
  report.shapes.reset();
  report.shapes_fault = "They are not there.";
  EXPECT_EQ(Json::parse(report_data(system, report))["shapes"]["fault"], "They are not there.");
}

TEST(Report, TheDrawingHoldsHAndWhatPrecedencePrunes) {
  const Json graph = data_of(load_scenario("2x3"))["graph"];
  EXPECT_EQ(graph["size"], Json({96, 304}));
  EXPECT_EQ(graph["free"], Json({128, 448}));  // 2^7 states, 7 * 2^6 actions
  const Json& drawing = graph["drawing"];
  EXPECT_EQ(drawing["nodes"].size(), 128);
  EXPECT_EQ(std::ranges::count_if(drawing["nodes"], [](const Json& node) { return node[2] == 1; }),
            32);
  EXPECT_EQ(
      std::ranges::count_if(drawing["actions"], [](const Json& action) { return action[4] == 0; }),
      304);
  EXPECT_EQ(drawing["paths"][0].size(), 8);
  // The best reward from the start, which exhaustive search finds too.
  EXPECT_NEAR(drawing["nodes"][0][3].get<double>(), 0.3636, 1e-9);
}

/// Six parts in a row, 1 to 6, with more members of the file.
Problem row(const std::string& more) {
  return parse_problem(R"({"format": "orasp-problem/1",
      "parts": [{"id": "1"}, {"id": "2"}, {"id": "3"}, {"id": "4"}, {"id": "5"}, {"id": "6"}],
      "connections": [{"parts": ["1", "2"]}, {"parts": ["2", "3"]}, {"parts": ["3", "4"]},
                      {"parts": ["4", "5"]}, {"parts": ["5", "6"]}])" +
                       more + "}");
}

std::size_t dead_ends(const Json& data) {
  const Json& nodes = data["graph"]["drawing"]["nodes"];
  return static_cast<std::size_t>(
      std::ranges::count_if(nodes, [](const Json& node) { return node[2] == 2; }));
}

TEST(Report, AStateFromWhichNothingIsLegalIsADeadEnd) {
  // Single parts alone may move: the row is taken apart from its ends. Where 3-4 must go before its
  // neighbours, 1-2 and 5-6 go, and then nothing does, for 3-4 would move two parts.
  EXPECT_EQ(dead_ends(data_of(row(R"(, "limits": {"max_moved_parts": 1})"))), 0);
  EXPECT_EQ(dead_ends(data_of(row(
                R"(, "limits": {"max_moved_parts": 1},
                    "precedence": [{"connection": "2-3", "after": ["3-4"]}, {"connection": )"
                R"("4-5", "after": ["3-4"]}])"))),
            1);
}

TEST(Report, AnInvalidPlanIsShownWithItsViolations) {
  const Problem problem = load_scenario("2x3");
  const TransitionSystem system(problem);
  Report report = solved(system);
  std::ranges::reverse(report.plans.front().sequence);
  report.plans.front().sequence.push_back("no such connection");
  const Json plan = Json::parse(report_data(system, report))["plans"][0];
  EXPECT_FALSE(plan["valid"]);
  EXPECT_EQ(plan["status"], "not valid");
  EXPECT_EQ(plan["steps"].size(), 7);
  EXPECT_EQ(plan["violations"].back()[3], "the problem has no connection \"no such connection\"");
  EXPECT_TRUE(plan["gap"].is_null());
  EXPECT_EQ(std::ranges::count_if(plan["steps"],
                                  [](const Json& step) { return step.contains("broken"); }),
            1);
}

TEST(Report, TextOfAProblemNeverEndsTheScriptThatHoldsIt) {
  const Problem problem = parse_problem(
      R"({"format": "orasp-problem/1", "name": "</script><!--", "parts": [{"id": "<b>"}, {"id": )"
      R"("&amp;"}],
          "connections": [{"id": "]]></SCRIPT>", "parts": ["<b>", "&amp;"]}]})");
  const TransitionSystem system(problem);
  Report report = solved(system);
  report.title = "</title><script>";
  const std::string data = report_data(system, report);
  EXPECT_EQ(data.find('<'), std::string::npos);
  EXPECT_EQ(Json::parse(data)["problem"]["name"], "</script><!--");
  const std::string page = report_html(system, report);
  EXPECT_NE(page.find("<title>&lt;/title&gt;&lt;script&gt;</title>"), std::string::npos);
}

TEST(Report, ThePageHoldsTheSpaceDrawingOnlyWherePartsHavePositions) {
  ProblemSpec spec = chain(2);
  const auto size = [](const ProblemSpec& of) {
    const Problem problem(of);
    const TransitionSystem system(problem);
    return report_html(system, solved(system)).size();
  };
  const std::size_t flat = size(spec);
  spec.parts[0].position = spec.parts[1].position = Vector3{};
  EXPECT_GT(size(spec), flat + 100'000);
  EXPECT_LT(size(spec), kMaxReportBytes);
}

TEST(Report, APageThatWouldBeTooLargeIsRefusedInASentence) {
  ProblemSpec spec = chain(50);
  for (Part& part : spec.parts) part.name = std::string(60'000, 'x');  // 3 MB in all
  const Problem problem(std::move(spec));
  const TransitionSystem system(problem);
  Report report;
  report.plans = {{.label = "", .origin = "", .sequence = {}, .expected = {}, .notes = {}}};
  for (const Connection& connection : problem.connections())
    report.plans.front().sequence.push_back(connection.id);
  report.best.status = Status::Unknown;
  try {
    static_cast<void>(report_html(system, report));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("the report would take"), std::string::npos);
  }
}

TEST(Report, AFleetsStatesFollowItsMoves) {
  const Problem problem = load_scenario("fleet-lattice");
  const FleetProblem fleet(problem);
  FleetReport report;
  report.best = solve(problem, "fleet-search");
  report.plans = {{.label = "x", .origin = "", .plan = report.best.fleet_plan, .notes = {}}};
  const Json plan = Json::parse(report_data(fleet, report))["plans"][0];
  const std::size_t n = report.best.fleet_plan.makespan();
  EXPECT_EQ(plan["status"], "optimal");
  ASSERT_EQ(plan["world"].size(), n + 1);
  EXPECT_EQ(plan["states"][0], Json({1, 1}));
  EXPECT_EQ(plan["states"][n], Json({9, 0}));
  for (const Json& place : plan["world"][n]["places"]) EXPECT_EQ(place, 0);  // all in the depot
  std::size_t cut = 0;
  for (const Json& step : plan["steps"]) cut += step["cut"].size();
  EXPECT_EQ(cut, 12);
}

TEST(Report, TheDensityOfASampleAddsUpToOne) {
  const Problem problem = load_scenario("3piece");
  const TransitionSystem system(problem);
  Report report = solved(system);
  ReportSample sample;
  sample.rewards = {1, 1, 2, 4};
  sample.mean = 2;
  sample.deviation = 1.4;
  sample.least = 1;
  sample.quartiles = {1, 1.5, 2.5};
  sample.greatest = 4;
  report.sample = sample;
  const Json density = Json::parse(report_data(system, report))["sample"]["density"];
  double sum = 0;  // trapezium rule
  for (std::size_t i = 1; i < density.size(); ++i) {
    const double width = density[i][0].get<double>() - density[i - 1][0].get<double>();
    sum += width * (density[i][1].get<double>() + density[i - 1][1].get<double>()) / 2;
  }
  EXPECT_NEAR(sum, 1, 0.01);
}

}  // namespace
}  // namespace orasp
