#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/formula_parser.h"
#include "orasp/orasp.h"
#include "orasp/planners/detail/and_or_search.h"
#include "tests/locked_products.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

/// The pieces of a problem of which few are listed, so that most are priced; swept once
/// `sweep_from` were expanded.
std::unique_ptr<detail::PieceProblem> pieces_of(const TransitionSystem& system, std::size_t listed,
                                                std::uint64_t sweep_from) {
  auto pieces = std::make_unique<detail::PieceProblem>(
      system, std::make_shared<const PieceGains>(system, ListingEffort{.most_sets = listed}));
  pieces->sweep_from = sweep_from;
  return pieces;
}

// The best plan is found by sweeps alone and after some pieces were expanded one by one, at once
// and in runs of a few expansions, with any plan known, in both directions; no bound on the way is
// below the truth, and threads change nothing.
TEST(AndOr, FindsTheBestPlanBySweeps) {
  std::size_t solved = 0;
  std::size_t infeasible = 0;
  std::size_t in_several_runs = 0;
  for (std::uint64_t seed = 0; seed < some_of(120U); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    ProblemSpec spec = locked_product(seed, seed % 2 == 0 ? "time" : "travel", 9 + seed % 5);
    if (seed % 4 == 2) spec.limits.max_moved_mass = 2.5;
    const bool backwards = seed % 3 == 0;
    if (backwards) spec.direction = Direction::Assembly;
    const Problem problem(spec);
    const TransitionSystem forwards(problem);
    const Result truth = value_iteration(forwards, {}, Budget{});
    const double tolerance = 1e-9 * std::max(1.0, std::abs(truth.reward));
    const std::unique_ptr<const TransitionSystem> turned(
        backwards ? new TransitionSystem(forwards.backwards()) : nullptr);
    const TransitionSystem& system = backwards ? *turned : forwards;
    const auto pieces = pieces_of(system, 12 + 8 * (seed % 5), seed % 7 < 4 ? 0 : seed % 7);
    for (const std::uint64_t length : {5U, 1'000'000U}) {
      for (const double known : {-kInfinity, truth.reward - 0.1, truth.reward}) {
        if (known > -kInfinity && !truth.has_plan()) continue;
        std::vector<std::pair<double, std::uint64_t>> after_runs;
        for (const unsigned threads : {1U, 3U}) {
          Budget budget;
          budget.threads = threads;
          Result spent;
          detail::AndOrSearch<1> search(*pieces, 0, budget, spent);
          search.know_plan(known);
          std::size_t runs = 0;
          for (bool done = false; !done; ++runs) {
            ASSERT_LT(runs, 10'000U);
            // A better plan makes the limit of a sweep lower that a run had to leave.
            if (runs == 2 && truth.has_plan()) search.know_plan(truth.reward - 0.05);
            done = search.run(length, 1'000'000);
            if (truth.has_plan()) {
              ASSERT_GE(*spent.bound, truth.reward - tolerance);
            }
            const std::pair after(*spent.bound, spent.statistics.expanded);
            if (threads == 1) after_runs.push_back(after);
            ASSERT_EQ(after, after_runs.at(runs));
          }
          if (runs > 2) ++in_several_runs;
          if (!truth.has_plan()) {
            ASSERT_EQ(*spent.bound, -kInfinity);
            ++infeasible;
            continue;
          }
          ASSERT_NEAR(*spent.bound, truth.reward, tolerance);
          if (known == truth.reward) continue;
          std::vector<ConnectionIndex> plan = search.sequence(false);
          if (backwards) std::ranges::reverse(plan);
          const Evaluation found = evaluate(problem, plan);
          ASSERT_TRUE(found.valid);
          ASSERT_NEAR(found.reward, truth.reward, tolerance);
          ++solved;
        }
      }
    }
  }
  EXPECT_GE(solved, more_than(500U));
  EXPECT_GE(in_several_runs, more_than(250U));
  EXPECT_GE(infeasible, more_than(0U));
}

// Where there is no room to keep all cuts, sweeps end, and the search goes on piece by piece.
TEST(AndOr, GoesOnWithoutSweepsWhereThereIsNoRoomForCuts) {
  std::size_t ended = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Problem problem(locked_product(seed, "time", 14));
    const TransitionSystem system(problem);
    const Result truth = value_iteration(system, {}, Budget{});
    if (!truth.has_plan()) continue;
    const auto pieces = pieces_of(system, 20, 0);
    for (const std::uint64_t kibibytes : {40U, 80U, 160U, 320U}) {
      Budget budget;
      budget.max_bytes = kibibytes << 10U;
      budget.threads = 2;
      Result spent;
      detail::AndOrSearch<1> search(*pieces, 0, budget, spent);
      ASSERT_TRUE(search.sweeps());
      const bool done = search.run(1'000'000, 1'000'000'000);
      ASSERT_GE(*spent.bound, truth.reward - 1e-9);
      if (!done) continue;  // no memory for the pieces themselves
      ASSERT_NEAR(*spent.bound, truth.reward, 1e-9);
      ASSERT_NEAR(evaluate(problem, search.sequence(false)).reward, truth.reward, 1e-9);
      if (!search.sweeps()) ++ended;
    }
  }
  EXPECT_GT(ended, 3U);
}

// A formula without a value for some cut ends a run; the next one proves nothing from what was not
// looked at.
TEST(AndOr, ProvesNothingFromASweepThatAFormulaEnded) {
  std::size_t without_value = 0;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    ProblemSpec spec = locked_product(seed, "travel", 12);
    const Problem with_values(spec);
    const Result truth = value_iteration(TransitionSystem(with_values), {}, Budget{});
    if (!truth.has_plan()) continue;
    // The cost is that of travel wherever it has a value.
    spec.objective = {"expression",
                      Expression{.formula = "-separates*(distance + 0/(kept_parts - " +
                                            std::to_string(3 + seed % 4) + "))",
                                 .constants = {},
                                 .depot = {},
                                 .compiler = compile_formula}};
    const Problem problem(spec);
    const TransitionSystem system(problem);
    const auto pieces = pieces_of(system, 20, 0);
    Budget budget;
    budget.threads = 1 + seed % 2;
    Result spent;
    detail::AndOrSearch<1> search(*pieces, 0, budget, spent);
    for (std::size_t run = 0; run < 4; ++run) {
      try {
        ASSERT_FALSE(search.run(1'000'000, 1'000'000));
      } catch (const InputError&) {
        ++without_value;
      }
      ASSERT_GE(*spent.bound, truth.reward - 1e-9);
    }
  }
  EXPECT_GT(without_value, 10U);
}

// Where the sets of seven parts are the largest that there is room for, two systems of prices are
// made at the same time: no bound is below the truth, and it is the same every time.
TEST(SmallPieces, MakesTwoSystemsOfPricesAtATime) {
  std::size_t of_six_or_seven = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Problem problem(locked_product(seed, "time", 12));
    const TransitionSystem system(problem);
    const Result truth = value_iteration(system, {}, Budget{});
    std::vector<PartIndex> all;
    for (PartIndex part = 0; part < problem.num_parts(); ++part) all.push_back(part);
    for (std::size_t listed = 50; listed < 800; listed += 50) {
      const PieceGains gains(system, {.most_sets = listed});
      const SmallPieces& pieces = gains.prices().small_pieces();
      if (!pieces.known() || !pieces.more_could_be_listed()) continue;
      if (pieces.priced(8) && !pieces.priced(6)) ++of_six_or_seven;
      if (truth.has_plan()) {
        ASSERT_GE(pieces.bound(all), truth.reward - 1e-9);
      }
      const PieceGains again(system, {.most_sets = listed});
      ASSERT_EQ(pieces.bound(all), again.prices().small_pieces().bound(all));
    }
  }
  EXPECT_GT(of_six_or_seven, 0U);
}

}  // namespace
}  // namespace orasp
