// What steps that move single parts cost at least.

#include "orasp/bounds/wide_bound.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/bounds/cover_prices.h"
#include "orasp/catalogue.h"
#include "orasp/graph/state_graph.h"
#include "orasp/io/problem_json.h"
#include "orasp/model/random.h"
#include "orasp/planners/detail/grounded_outlook.h"
#include "orasp/planners/value_iteration.h"
#include "tests/seeds.h"
#include "tests/wide_oracle.h"

namespace orasp {
namespace {

Budget at_most_expansions(std::uint64_t number) {
  Budget budget;
  budget.max_expansions = number;
  return budget;
}

using Edges = std::vector<std::array<PartIndex, 2>>;

double charged_in_all(const std::vector<double>& prices) {
  double sum = 0;
  for (const double price : prices) sum += price;
  return sum;
}

// Nemhauser and Trotter: some least cover of the relaxation takes each node whole, half or not.
double least_half_cover(const std::vector<double>& cost, const Edges& edges) {
  std::vector<int> halves(cost.size(), 0);
  double least = std::numeric_limits<double>::infinity();
  for (;;) {
    const bool covers = std::ranges::all_of(edges, [&](const auto& edge) {
      return edge[0] == edge[1] || halves[edge[0]] + halves[edge[1]] >= 2;
    });
    double sum = 0;
    for (std::size_t node = 0; node < cost.size(); ++node) {
      if (halves[node] > 0) sum += halves[node] / 2.0 * cost[node];
    }
    if (covers) least = std::min(least, sum);
    std::size_t node = 0;
    while (node < halves.size() && ++halves[node] > 2) halves[node++] = 0;
    if (node == halves.size()) return least;
  }
}

TEST(CoverPrices, AreTheRelaxationOfTheLeastCoverAndOverchargeNobody) {
  SplitMix64 random(5);
  for (int i = 0; i < some_of(400); ++i) {
    SCOPED_TRACE(i);
    const auto nodes = static_cast<std::size_t>(2 + random.below(6));
    std::vector<double> cost(nodes);
    for (double& each : cost) each = random.below(5) == 0 ? 0 : random.uniform();
    if (random.below(3) == 0) cost[0] = std::numeric_limits<double>::infinity();
    Edges edges(1 + random.below(3 * nodes));
    for (auto& edge : edges) {
      for (PartIndex& end : edge) end = static_cast<PartIndex>(random.below(nodes));
    }
    const std::vector<double> prices = cover_prices(cost, edges);
    std::vector<double> charged(nodes, 0.0);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      EXPECT_GE(prices[e], 0);
      if (edges[e][0] == edges[e][1]) {
        EXPECT_EQ(prices[e], 0);
      }
      for (const PartIndex end : edges[e]) charged[end] += prices[e];
    }
    for (std::size_t node = 0; node < nodes; ++node) EXPECT_LE(charged[node], cost[node] + 1e-15);
    EXPECT_NEAR(charged_in_all(prices), least_half_cover(cost, edges), 1e-9);
  }
}

TEST(CoverPrices, ALargePathIsChargedWhatItsCheaperHalfCosts) {
  constexpr std::size_t kNodes = 10'000;
  std::vector<double> cost(kNodes, 3.0);
  Edges edges;
  for (std::size_t node = 1; node < kNodes; node += 2) cost[node] = 1;
  for (std::size_t node = 1; node < kNodes; ++node)
    edges.push_back({static_cast<PartIndex>(node - 1), static_cast<PartIndex>(node)});
  EXPECT_NEAR(charged_in_all(cover_prices(cost, edges)), kNodes / 2.0, 1e-6);
}

/// Parts that come off one by one, some of them in the way of others.
ProblemSpec single_moves(std::uint64_t seed) {
  SplitMix64 random(seed);
  ProblemSpec spec;
  spec.action = StepKind::Part;
  spec.limits.max_moved_parts = 1;
  spec.direction = seed % 2 == 0 ? Direction::Disassembly : Direction::Assembly;
  const auto parts = static_cast<std::size_t>(3 + random.below(3));
  for (std::size_t p = 0; p < parts; ++p) {
    Part part;
    part.id = "p" + std::to_string(p);
    part.mass = static_cast<double>(1 + random.below(9));
    part.position = {random.uniform(), random.uniform(), random.uniform()};
    spec.parts.push_back(std::move(part));
  }
  const auto join = [&](std::size_t a, std::size_t b) {
    Connection connection;
    connection.id = "c" + std::to_string(spec.connections.size());
    connection.parts = {"p" + std::to_string(a), "p" + std::to_string(b)};
    connection.duration = static_cast<double>(random.below(4));
    spec.connections.push_back(std::move(connection));
  };
  for (std::size_t p = 1; p < parts; ++p) join(random.below(p), p);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto a = static_cast<std::size_t>(random.below(parts));
    const auto b = static_cast<std::size_t>(random.below(parts));
    if (a != b) join(a, b);
  }
  if (random.below(4) != 0) spec.base = {"p" + std::to_string(random.below(parts))};
  spec.limits.grounded = !spec.base.empty() && random.below(2) == 0;
  if (spec.limits.grounded || random.below(2) == 0) {
    spec.blocking.emplace();
    spec.blocking->directions = {"+x", "-x"};
    for (std::size_t i = 0; i < parts + 1; ++i) {
      const auto a = static_cast<std::size_t>(random.below(parts));
      const auto b = static_cast<std::size_t>(random.below(parts));
      if (a == b) continue;
      spec.blocking->blocked.push_back(
          {"p" + std::to_string(a), "p" + std::to_string(b), {random.below(2) == 0 ? "+x" : "-x"}});
    }
  }
  if (spec.direction == Direction::Disassembly && random.below(3) == 0)
    spec.goal = Goal{.removed = {"c0"}};
  const std::vector<std::string> types = {"time", "travel", "fuel", "completion"};
  spec.objective = Objective::named(types[random.below(types.size())]);
  if (random.below(4) == 0) {
    WeightedSum sum;
    sum.terms.push_back({random.below(3) == 0 ? -0.5 : 2.0, Objective::named("time")});
    sum.terms.push_back({1.0, spec.objective});
    spec.objective = Objective("sum", sum);
  }
  return spec;
}

TEST(SingleMoves, TheBoundIsNeverBelowTheTruthNorInconsistent) {
  int exact = 0;
  int solved = 0;
  int seen = 0;  // states that nothing leads on from, and that are known to be such
  int unseen = 0;
  for (std::uint64_t seed = 0; seed < some_of<std::uint64_t>(800); ++seed) {
    const ProblemSpec spec = single_moves(seed);
    const Problem problem(spec);
    SCOPED_TRACE("seed " + std::to_string(seed) + "\n" + problem_text(problem));
    const oracle::WideResult truth = oracle::wide_brute_force(spec);
    const Result answer = solve(problem, "auto");
    EXPECT_EQ(answer.has_plan(), truth.best.has_value());
    if (truth.best) {
      EXPECT_NEAR(answer.reward, *truth.best, 1e-7);
    }
    const TransitionSystem system(problem);
    if (system.infeasibility()) continue;
    const StateGraph graph = StateGraph::build(system, {});
    const Result result = value_iteration(graph, {}, {});
    WideBound bound(system);
    ASSERT_TRUE(bound.known());
    detail::GroundedOutlook outlook(system);
    for (StateId s = 0; s < graph.num_states(); ++s) {
      const bool shut = outlook.applies() && outlook.is_shut(system.open(graph.key(s)));
      if (result.values[s] == -kInfinity) {
        if (outlook.applies()) ++(shut ? seen : unseen);
        continue;
      }
      EXPECT_FALSE(shut) << "state " << s;
      const double most = bound(graph.key(s));
      EXPECT_GE(most, result.values[s] - 1e-9) << "state " << s;
      for (ActionId a = graph.begin(s); a < graph.end(s); ++a) {
        const double next = bound(graph.key(graph.successor(a)));
        EXPECT_GE(most, graph.reward(a) + next - 1e-9) << "state " << s << ": not consistent";
      }
    }
    if (!truth.best) continue;
    ++solved;
    if (bound(system.start_state()) <= *truth.best + 1e-9) ++exact;
  }
  EXPECT_GE(solved, least_of(300));
  EXPECT_GE(exact, least_of(200)) << "of " << solved;
  EXPECT_GE(seen, least_of(25)) << "and " << unseen << " not seen";
}

TEST(SingleMoves, WhatComesOffABaseIsProvedAtOnceHoweverManyOrdersThereAre) {
  // A wheel: all parts hang on the base and on their neighbours.
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
    ProblemSpec spec;
    spec.action = StepKind::Part;
    spec.direction = direction;
    spec.objective = Objective::named("time");
    spec.base = {"base"};
    spec.limits.grounded = true;
    spec.limits.max_moved_parts = 1;
    spec.parts.push_back({.id = "base", .position = Vector3{0, 0, 0}});
    constexpr int kRim = 40;
    double seconds = 0;
    for (int p = 0; p < kRim; ++p) {
      const std::string id = "p" + std::to_string(p);
      spec.parts.push_back({.id = id, .position = Vector3{1.0 + p, 0, 0}});
      spec.connections.push_back({.id = "r" + id, .parts = {"base", id}, .duration = 2});
      spec.connections.push_back(
          {.id = "n" + id, .parts = {id, "p" + std::to_string((p + 1) % kRim)}, .duration = 1});
      seconds += 3 + 2 * (1.0 + p);
    }
    const Problem problem(spec);
    const Result result = solve(problem, "auto", {}, at_most_expansions(1'000));
    EXPECT_EQ(result.status, Status::Optimal);
    EXPECT_NEAR(result.reward, -seconds, 1e-9);
  }
}

TEST(SingleMoves, AStepThatShutsTheWayIsTakenBackHoweverFarBackItIs) {
  // Each of the traps is a ring of the base, a left part, a top and a right part. The left one
  // holds the top fast, so it has to go first, but the right one is nearer, and without it the top
  // hangs on the left one.
  ProblemSpec spec;
  spec.action = StepKind::Part;
  spec.objective = Objective::named("time");
  spec.base = {"base"};
  spec.limits.grounded = true;
  spec.blocking.emplace();
  spec.blocking->directions = {"+x", "-x"};
  spec.parts.push_back({.id = "base", .position = Vector3{0, 0, 0}});
  constexpr int kTraps = 40;
  for (int i = 0; i < kTraps; ++i) {
    const std::string n = std::to_string(i);
    std::vector<Part> three = {{.id = "left" + n, .position = Vector3{3, 0, 0}},
                               {.id = "top" + n, .position = Vector3{2, 0, 0}},
                               {.id = "right" + n, .position = Vector3{1, 0, 0}}};
    // Nor does the order of the file tell.
    if (i % 2 == 0) std::ranges::reverse(three);
    spec.parts.insert(spec.parts.end(), three.begin(), three.end());
    spec.connections.push_back({.parts = {"base", "left" + n}});
    spec.connections.push_back({.parts = {"left" + n, "top" + n}});
    spec.connections.push_back({.parts = {"top" + n, "right" + n}});
    spec.connections.push_back({.parts = {"right" + n, "base"}});
    spec.blocking->blocked.push_back({"top" + n, "left" + n, {"+x"}});
    spec.blocking->blocked.push_back({"top" + n, "base", {"-x"}});
  }
  const Problem problem(spec);
  for (const char* const method : {"greedy", "auto"}) {
    SCOPED_TRACE(method);
    const Result result = solve(problem, method, {}, at_most_expansions(1'000));
    ASSERT_TRUE(result.has_plan());
    EXPECT_NEAR(result.reward, -(kTraps * (4 + 2 * 6.0)), 1e-9);
  }
}

}  // namespace
}  // namespace orasp
