// Every row of the tables of measured and published values (`cubesat` by exhaustive search; see
// docs/algorithms.md).

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/graph/graph_size.h"
#include "orasp/graph/state_graph.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/validate.h"
#include "tests/oracle.h"

namespace orasp {
namespace {

constexpr const char* kExactMethods[] = {"value-iteration", "dijkstra", "bellman-ford",
                                         "orasp-search",    "a-star",   "beam"};

/// Least reward of a complete plan: H in order of generation, so each state after all that lead to
/// it.
double worst_reward(const StateGraph& graph) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  std::vector<double> least(graph.num_states(), kNever);
  least[0] = 0;
  for (StateId s = 0; s < graph.num_states(); ++s) {
    for (ActionId a = graph.begin(s); a < graph.end(s); ++a) {
      double& there = least[graph.successor(a)];
      there = std::min(there, least[s] + graph.reward(a));
    }
  }
  return graph.goal() ? least[*graph.goal()] : kNever;
}

struct Row {
  const char* name;  ///< a scenario, or a file under ../shared/problems
  std::uint64_t states;
  std::uint64_t actions;
  double best;
  double worst;  ///< NaN where the table has none
};

std::ostream& operator<<(std::ostream& out, const Row& row) {
  return out << row.name;
}

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::string shared_folder() {
  const char* const given = std::getenv("ORASP_SHARED");
  return given != nullptr ? given : ORASP_SOURCE_DIR "/../shared";
}

class KnownValues : public testing::TestWithParam<Row> {
 protected:
  void SetUp() override {
    const std::string name = GetParam().name;
    if (!name.ends_with(".json")) return;
    file_ = shared_folder() + "/problems/" + name;
    if (!std::filesystem::exists(file_)) {
      GTEST_SKIP() << "no file " << file_
                   << "; set ORASP_SHARED to the folder that holds problems/";
    }
  }
  [[nodiscard]] Problem problem() const {
    return file_.empty() ? load_scenario(GetParam().name) : read_problem(file_);
  }

 private:
  std::string file_;
};

TEST_P(KnownValues, SizeOfTheGraphAndTheWorstPlan) {
  const Problem the_problem = problem();
  const TransitionSystem system(the_problem);
  Budget budget;
  budget.threads = 2;
  const StateGraph graph = StateGraph::build(system, budget);
  EXPECT_EQ(graph.num_states(), GetParam().states);
  EXPECT_EQ(graph.num_actions(), GetParam().actions);
  if (!std::isnan(GetParam().worst)) {
    EXPECT_NEAR(worst_reward(graph), GetParam().worst, 1e-9);
  }
}

TEST_P(KnownValues, BestPlanOfEachExactMethod) {
  const Problem the_problem = problem();
  for (const char* method : kExactMethods) {
    SCOPED_TRACE(method);
    const Result result = solve(the_problem, method);
    ASSERT_EQ(status_name(result.status), "optimal");
    EXPECT_NEAR(result.reward, GetParam().best, 1e-9);
    const Evaluation evaluation =
        evaluate(the_problem, std::span<const ConnectionIndex>(result.sequence));
    EXPECT_TRUE(evaluation.valid);
    EXPECT_NEAR(evaluation.reward, GetParam().best, 1e-9);
    const oracle::OracleReplay replay = oracle::replay(the_problem.spec(), result.sequence);
    EXPECT_TRUE(replay.valid);
    EXPECT_NEAR(replay.reward, GetParam().best, 1e-9);
  }
}

std::string name_of(const testing::TestParamInfo<Row>& info) {
  std::string name = info.param.name;
  name = name.substr(name.find('/') + 1);
  name = name.substr(0, name.find('.'));
  std::erase(name, '-');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Scenarios, KnownValues,
                         testing::Values(Row{"3piece", 8, 12, 0.7785, 0.7785},
                                         Row{"4brick", 8, 12, 0.5570, 0.5450},
                                         Row{"4piece", 16, 32, 0.5570, 0.5450},
                                         Row{"2x3", 96, 304, 0.3636, 0.0900},
                                         Row{"lattice", 1'296, 6'048, 0.0735, -0.4617},
                                         Row{"hubble", 12'096, 67'824, -0.9902, -1.6502}),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Large, KnownValues,
                         testing::Values(Row{"hubble-free", 524'288, 4'980'736, -0.9902, -2.4350},
                                         Row{"hubble-upc", 243'787, 1'906'095, -0.9902, kNone}),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Blocking, KnownValues,
                         testing::Values(Row{"lego/lego-011.json", 8'192, 53'248, -0.4100, -1.3316},
                                         Row{"lego/lego-023.json", 1'488, 7'256, 0.0735, -0.3249},
                                         Row{"lego/lego-069.json", 9'688, 56'504, -0.1199,
                                             -0.7799}),
                         name_of);

struct ObjectiveRow {
  const char* scenario;
  double cubesat_zone;
  double custom;
  double indexed;
  double time;
  double fuel;
  double completion;
};

std::ostream& operator<<(std::ostream& out, const ObjectiveRow& row) {
  return out << row.scenario;
}

class KnownValuesOfObjectives : public testing::TestWithParam<ObjectiveRow> {};

TEST_P(KnownValuesOfObjectives, BestPlanOfEachExactMethod) {
  const ObjectiveRow& row = GetParam();
  const Problem problem = load_scenario(row.scenario);
  const std::vector<std::pair<const char*, double>> bests = {{"cubesat_zone", row.cubesat_zone},
                                                             {"custom", row.custom},
                                                             {"indexed", row.indexed},
                                                             {"time", row.time},
                                                             {"fuel", row.fuel},
                                                             {"completion", row.completion}};
  for (const auto& [type, best] : bests) {
    const Problem changed = problem.with_objective(Objective::named(type));
    for (const char* method : kExactMethods) {
      SCOPED_TRACE(std::string(type) + " by " + method);
      const Result result = solve(changed, method);
      EXPECT_EQ(status_name(result.status), "optimal");
      EXPECT_NEAR(result.reward, best, 5.1e-7);  // the table has six decimals
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenarios, KnownValuesOfObjectives,
    testing::Values(ObjectiveRow{"3piece", 0.831100, -1.700000, 3, -5, -0.400746, 1197},
                    ObjectiveRow{"4brick", 0.691000, -4.200000, 3, -6, -0.601120, 1297},
                    ObjectiveRow{"4piece", 0.691000, -4.300000, 5, -7, -0.601120, 1296},
                    ObjectiveRow{"2x3", 0.497600, -6.600000, 13, -12, -1.001866, 1493},
                    ObjectiveRow{"lattice", 0.207500, -10.100000, 34, -20, -1.602985, 1788},
                    ObjectiveRow{"hubble", -0.856200, -21.800000, 91, -38, -3.807090, 2881}),
    [](const auto& row) { return "of_" + std::string(row.param.scenario); });

/// H of a scenario without its precedence.
GraphSize size_without_precedence(const std::string& name) {
  ProblemSpec spec = load_scenario(name).spec();
  spec.precedence.clear();
  const Problem problem(spec);
  const TransitionSystem system(problem);
  return graph_size(StateGraph::build(system, Budget{}));
}

// Without constraints H has every subset: 2^E states and E 2^(E-1) actions, and H~ has E! complete
// sequences.
TEST(KnownSizes, WithoutPrecedenceHoldsEverySubset) {
  const GraphSize small = size_without_precedence("2x3");
  EXPECT_EQ(small.states, 128U);
  EXPECT_EQ(small.actions, 448U);
  EXPECT_EQ(small.sequences, "5040");
  const GraphSize lattice = size_without_precedence("lattice");
  EXPECT_EQ(lattice.states, 4'096U);
  EXPECT_EQ(lattice.actions, 24'576U);
  EXPECT_EQ(lattice.sequences, "479001600");
}

// 19! sequences; nodes of the tree: the sum over k of 19! / k!, which is floor(19! e) =
// 330665665962404000.
TEST(KnownSizes, TreeOfHubbleWithoutConstraints) {
  const Problem problem = load_scenario("hubble-free");
  const TransitionSystem system(problem);
  Budget budget;
  budget.threads = 2;
  const GraphSize size = graph_size(StateGraph::build(system, budget));
  EXPECT_EQ(size.sequences, "121645100408832000");
  EXPECT_EQ(size.tree_nodes, "330665665962404000");
  EXPECT_EQ(size.dead_ends, 0U);
  EXPECT_EQ(size.layers.size(), 20U);
  EXPECT_EQ(size.layers[9].states, 92'378U);  // 19 over 9
}

// The bound of the reference that peeling single parts meets: no plan of ISS earns more than
// -2.1506, none of JWST more than -16.7118.
TEST(KnownBounds, NoPlanBeatsThem) {
  for (const auto& [name, bound] : {std::pair{"iss", -2.1506}, std::pair{"jwst", -16.7118}}) {
    for (const char* method : {"greedy", "random"}) {
      const Problem problem = load_scenario(name);
      const Result result = solve(problem, method);
      EXPECT_EQ(status_name(result.status), "feasible");
      EXPECT_LE(result.reward, bound + 1e-9) << name << " by " << method;
      EXPECT_TRUE(oracle::replay(problem.spec(), result.sequence).valid);
    }
  }
}

}  // namespace
}  // namespace orasp
