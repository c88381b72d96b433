#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/formula_parser.h"
#include "orasp/model/objectives/retried.h"
#include "orasp/orasp.h"
#include "orasp/planners/detail/and_or_search.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

Objective formula(const std::string& text) {
  return {"expression",
          Expression{.formula = text, .constants = {}, .depot = {}, .compiler = compile_formula}};
}

Objective some_objective(SplitMix64& random) {
  switch (random.below(6)) {
    case 0: return Objective::named("custom");
    case 1: return formula("-separates*(moved_parts+kept_parts)");
    case 2: return formula("-separates - moved_parts + completes*(3 + index)");
    case 3: {
      PieceCost costs{.operation = random.uniform(), .pieces = {}, .completion = random.uniform()};
      for (std::size_t size = 1; size <= 4; ++size) costs.pieces[size] = random.uniform();
      return {"piece_cost", costs};
    }
    case 4:
      return random.below(2) == 0 ? Objective::named("completion")
                                  : formula("separates*kept_parts/3 + completes");
    default:
      constexpr std::array<const char*, 4> kNames = {"time", "travel", "cubesat", "cubesat_zone"};
      return Objective::named(kNames[random.below(kNames.size())]);
  }
}

/// A product of 7 to 11 parts where each connection has a chance of its own, in one piece or two.
ProblemSpec product(std::uint64_t seed) {
  SplitMix64 random(seed);
  SplitMix64 places(~seed);
  ProblemSpec spec;
  spec.name = "p" + std::to_string(seed);
  const std::size_t parts = 7 + random.below(5);
  for (std::size_t p = 0; p < parts; ++p) {
    Part part;
    part.id = std::string(1, static_cast<char>('a' + p));
    part.position = Vector3{places.uniform() - 0.5, places.uniform() - 0.5, places.uniform() - 0.5};
    spec.parts.push_back(part);
  }
  const auto join = [&](std::size_t a, std::size_t b) {
    Connection connection;
    connection.id = std::to_string(spec.connections.size());
    connection.parts = {spec.parts[a].id, spec.parts[b].id};
    connection.success = 0.4 + 0.6 * random.uniform();
    spec.connections.push_back(connection);
  };
  const std::size_t second_piece = random.below(3) == 0 ? 2 + random.below(parts - 3) : parts;
  for (std::size_t p = 1; p < parts; ++p) {
    if (p < second_piece) join(p, random.below(p));
    if (p > second_piece) join(p, second_piece + random.below(p - second_piece));
  }
  for (std::size_t more = random.below(4); more > 0; --more) {
    const std::size_t a = random.below(parts);
    const std::size_t b = random.below(parts);
    if ((a < second_piece) == (b < second_piece) && (a != b || random.below(3) == 0)) join(a, b);
  }
  if (random.below(2) == 0) spec.limits.max_moved_parts = 1 + random.below(4);
  if (random.below(2) == 0) spec.limits.max_subassemblies = 2 + random.below(2);
  if (random.below(4) == 0) {
    Blocking& blocking = spec.blocking.emplace();
    for (const char* axis : {"+x", "-x"}) blocking.directions.emplace_back(axis);
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t a = random.below(parts);
      const std::size_t b = (a + 1 + random.below(parts - 1)) % parts;
      spec.blocking->blocked.push_back(
          {.part = spec.parts[a].id, .by = spec.parts[b].id, .directions = {"+x"}});
    }
  }
  spec.objective = some_objective(random);
  if (random.below(3) == 0) spec.direction = Direction::Assembly;
  return spec;
}

// Where connections differ, the last cuts of a piece and the last step of all weigh more than
// others. The best plan is found all the same, at once and in runs that begin with a few
// expansions, with cores of any size, and no bound on the way is below the truth.
TEST(AndOr, FindsTheBestPlanWhereConnectionsDiffer) {
  std::size_t solved = 0;
  std::size_t last_matters = 0;
  // The first ones have a loop that is the best last step though a pair would earn more there, and
  // a side that has to wait for its last step while the other one needs all that may lie about.
  std::vector<std::uint64_t> seeds{5004, 7558};
  for (std::uint64_t seed = 0; seed < some_of(3000U); ++seed) seeds.push_back(seed);
  for (const std::uint64_t seed : seeds) {
    const ProblemSpec spec = product(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem = attempts_paid(Problem(spec));
    const TransitionSystem forwards(problem);
    if (forwards.infeasibility()) continue;
    const Result truth = value_iteration(forwards, {}, Budget{});
    const bool backwards = spec.direction == Direction::Assembly;
    const std::unique_ptr<const TransitionSystem> turned(
        backwards ? new TransitionSystem(forwards.backwards()) : nullptr);
    const TransitionSystem& system = backwards ? *turned : forwards;
    const double tolerance = 1e-9 * std::max(1.0, std::abs(truth.reward));
    detail::PieceProblem pieces(system, nullptr);
    pieces.most_core_parts = 3 + seed % 4;
    if (pieces.last) ++last_matters;
    std::size_t large_pieces = 0;
    pieces.graph.for_each_piece(
        ConnectionSet::all(problem.num_connections()).view(),
        [&](std::span<const PartIndex> piece) { large_pieces += piece.size() > 1 ? 1 : 0; });
    for (const std::uint64_t at_first : {std::uint64_t{3}, std::uint64_t{1'000'000}}) {
      const Budget budget;
      Result spent;
      detail::AndOrSearch<1> search(pieces, 0, budget, spent);
      bool done = false;
      for (std::uint64_t length = at_first; length < 8'000'000 && !done; length *= 2) {
        done = search.run(length, 1'000'000);
        if (truth.has_plan()) {
          ASSERT_GE(*spent.bound, truth.reward - tolerance);
        }
      }
      ASSERT_TRUE(done);
      if (!truth.has_plan()) continue;
      std::vector<ConnectionIndex> plan = search.sequence(false);
      // What the search leaves out: pieces that wait for each other at the start, connections that
      // are removed early to set parts free, and an assembly whose last step joins nothing with a
      // connection that another cut would like to keep.
      const bool exact = !spec.blocking && (large_pieces == 1 || !spec.limits.max_subassemblies) &&
                         (!backwards || !pieces.first || pieces.first->without_cut.empty());
      if (plan.empty() && !exact) continue;
      if (backwards) std::ranges::reverse(plan);
      const Evaluation found = evaluate(problem, plan);
      ASSERT_TRUE(found.valid);
      ASSERT_LE(found.reward, truth.reward + tolerance);
      if (!exact) continue;
      ASSERT_NEAR(found.reward, *spent.bound, tolerance);
      ASSERT_NEAR(found.reward, truth.reward, tolerance);
      ++solved;
    }
  }
  EXPECT_GE(solved, least_of(2500U));
  EXPECT_GE(last_matters, least_of(1400U));
}

// The last step joins nothing: a second connection between two pieces that are joined before, by
// the one that costs least there.
TEST(AndOr, EndsAnAssemblyWithAConnectionThatNoCutNeeds) {
  const Problem problem = attempts_paid(Problem(product(24)));
  const TransitionSystem system(problem);
  const Result result = and_or(system, {}, Budget{});
  EXPECT_EQ(result.status, Status::Optimal);
  EXPECT_NEAR(result.reward, value_iteration(system, {}, Budget{}).reward, 1e-9);
}

}  // namespace
}  // namespace orasp
