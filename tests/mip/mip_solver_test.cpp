#include "orasp/mip/mip_solver.h"

#include <array>
#include <cmath>
#include <csignal>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "orasp/model/error.h"

namespace orasp {
namespace {

class MipSolverTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!mip_solver_available()) GTEST_SKIP() << "built without CBC";
  }
  static MipSolution solve(const MipModel& model, const MipSettings& settings = {}) {
    return make_mip_solver()->solve(model, settings);
  }
};

/// Weights 2, 3, 4, 5 of worth 3, 4, 5, 6 in a sack for 5: the first two are worth 7, more than any
/// other choice (6, 5).
MipModel knapsack() {
  MipModel model;
  MipSum weight;
  const double weights[] = {2, 3, 4, 5};
  const double worths[] = {3, 4, 5, 6};
  for (int i = 0; i < 4; ++i)
    weight.add(model.add_binary(mip_name("take", i + 1), -worths[i]), weights[i]);
  model.add_row("weight", weight, MipSense::AtMost, 5);
  return model;
}

TEST_F(MipSolverTest, FillsAKnapsackBest) {
  MipModel model = knapsack();
  model.add_constant(100);
  const MipSolution solution = solve(model);
  EXPECT_EQ(solution.status, MipSolution::Status::Optimal);
  EXPECT_EQ(solution.values, (std::vector<double>{1, 1, 0, 0}));
  EXPECT_NEAR(solution.objective, 93, 1e-9);
  EXPECT_NEAR(solution.bound, 93, 1e-9);
  EXPECT_EQ(model.broken_by(solution.values, 1e-6), "");
}

// x + y = 3.5 with x whole and 0 <= y <= 1: x is 3, y a half; 2 x - y is 5.5.
TEST_F(MipSolverTest, MixesWholeAndContinuousColumns) {
  MipModel model;
  const MipColumn x = model.add_column({"x", 2, 0, 10, true});
  const MipColumn y = model.add_continuous("y", 1, -1);
  model.add_row("sum", MipSum().add(x, 1).add(y, 1), MipSense::Equal, 3.5);
  const MipSolution solution = solve(model);
  EXPECT_EQ(solution.status, MipSolution::Status::Optimal);
  EXPECT_NEAR(solution.objective, 5.5, 1e-7);
}

TEST_F(MipSolverTest, ProvesThatThereIsNoSolution) {
  MipModel model = knapsack();
  MipSum all;
  for (MipColumn c = 0; c < 4; ++c) all.add(c, 1);
  model.add_row("three", all, MipSense::AtLeast, 3);
  const MipSolution solution = solve(model);
  EXPECT_EQ(solution.status, MipSolution::Status::Infeasible);
  EXPECT_TRUE(solution.values.empty());
}

// Feasible as a linear program, not in whole numbers: 2 x + 2 y is even.
TEST_F(MipSolverTest, ProvesThatThereIsNoWholeSolution) {
  MipModel model;
  const MipColumn x = model.add_column({"x", 1, 0, 7, true});
  const MipColumn y = model.add_column({"y", 1, 0, 7, true});
  model.add_row("odd", MipSum().add(x, 2).add(y, 2), MipSense::Equal, 7);
  EXPECT_EQ(solve(model).status, MipSolution::Status::Infeasible);
}

TEST_F(MipSolverTest, SaysThatAnObjectiveFallsWithoutEnd) {
  MipModel model;
  const MipColumn x = model.add_continuous("x", std::numeric_limits<double>::infinity(), -1);
  const MipColumn y = model.add_binary("y");
  model.add_row("r", MipSum().add(x, 1).add(y, 1), MipSense::AtLeast, 1);
  const MipSolution solution = solve(model);
  EXPECT_EQ(solution.status, MipSolution::Status::Unbounded);
  EXPECT_TRUE(solution.values.empty());
}

TEST_F(MipSolverTest, TakesAModelWithoutRows) {
  MipModel model;
  model.add_binary("x", -1);
  model.add_binary("y", 1);
  const MipSolution solution = solve(model);
  EXPECT_EQ(solution.status, MipSolution::Status::Optimal);
  EXPECT_EQ(solution.values, (std::vector<double>{1, 0}));
}

/// Market split (Cornuejols and Dawande 1998): rows that no choice meets exactly, so that the
/// search must try nearly all.
MipModel market_split() {
  MipModel model;
  std::uint64_t state = 7;
  const auto draw = [&] {
    return static_cast<double>((state = state * 6364136223846793005U + 1442695040888963407U) >> 33 &
                               127);
  };
  const int columns = 40;
  for (int c = 0; c < columns; ++c) model.add_binary(mip_name("x", c + 1));
  for (int r = 0; r < 5; ++r) {
    MipSum sum;
    double total = 0;
    for (int c = 0; c < columns; ++c) {
      const double weight = draw();
      total += weight;
      sum.add(static_cast<MipColumn>(c), weight);
    }
    const MipColumn over = model.add_continuous(mip_name("over", r + 1), 1e4, 1);
    const MipColumn under = model.add_continuous(mip_name("under", r + 1), 1e4, 1);
    sum.add(over, -1).add(under, 1);
    model.add_row(mip_name("r", r + 1), sum, MipSense::Equal, std::floor(total / 2));
  }
  return model;
}

TEST_F(MipSolverTest, StopsWhenTheWatcherSaysSoWithWhatItHas) {
  int calls = 0;
  MipSettings settings;
  settings.watcher = [&](const MipProgress& progress) {
    ++calls;
    EXPECT_LE(progress.bound, progress.best + 1e-6);
    return progress.nodes >= 20 ? Stop::ExpansionLimit : Stop::None;
  };
  const MipModel model = market_split();
  const MipSolution solution = solve(model, settings);
  EXPECT_GE(calls, 1);
  EXPECT_EQ(stop_name(solution.stop), "expansion limit");
  EXPECT_NE(solution.status, MipSolution::Status::Optimal);
  EXPECT_NE(solution.status, MipSolution::Status::Infeasible);
  if (!solution.values.empty()) {
    EXPECT_EQ(model.broken_by(solution.values, 1e-5), "");
    EXPECT_LE(solution.bound, solution.objective);
  }
}

// Else an interrupt would end a linear program that then passes for infeasible.
TEST_F(MipSolverTest, LeavesSigintToWhoeverHasIt) {
  static std::sig_atomic_t heard = 0;
  heard = 0;
  const auto before = std::signal(SIGINT, [](int) { heard = heard + 1; });
  int raised = 0;
  MipSettings settings;
  settings.watcher = [&](const MipProgress& progress) {
    ++raised;
    std::raise(SIGINT);
    return progress.nodes >= 20 ? Stop::ExpansionLimit : Stop::None;
  };
  const MipSolution solution = solve(market_split(), settings);
  EXPECT_NE(solution.status, MipSolution::Status::Optimal);
  EXPECT_GE(raised, 2);
  EXPECT_EQ(heard, raised);
  std::signal(SIGINT, before);
}

TEST_F(MipSolverTest, DoesNothingWhereItIsOverBeforeTheStart) {
  MipSettings settings;
  settings.watcher = [](const MipProgress&) { return Stop::Cancelled; };
  const MipSolution solution = solve(knapsack(), settings);
  EXPECT_EQ(solution.status, MipSolution::Status::Unknown);
  EXPECT_EQ(stop_name(solution.stop), "interrupted");
}

TEST_F(MipSolverTest, SolvesInSeveralThreadsAtOnce) {
  std::array<double, 2> found{};
  {
    std::jthread one([&] {
      for (int i = 0; i < 20; ++i) found[0] += solve(knapsack()).objective;
    });
    std::jthread other([&] {
      for (int i = 0; i < 20; ++i) found[1] += solve(knapsack()).objective;
    });
  }
  EXPECT_NEAR(found[0], -140, 1e-9);
  EXPECT_NEAR(found[1], -140, 1e-9);
}

TEST(MipSolverLoader, SaysHowToGetTheSolverWhereItIsMissing) {
  if (mip_solver_available()) GTEST_SKIP() << "built with CBC";
  try {
    (void)make_mip_solver();
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("coinor-libcbc-dev"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace orasp
