#include "orasp/model/scenario_generators.h"

#include <map>
#include <set>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "tests/fault.h"

namespace orasp {
namespace {

/// "1-2 2-3": the connections in their order.
std::string pairs(const ProblemSpec& spec) {
  std::string text;
  for (const Connection& connection : spec.connections) {
    if (!text.empty()) text += ' ';
    text += connection.parts[0] + "-" + connection.parts[1];
  }
  return text;
}

bool is_connected(const ProblemSpec& spec) {
  const Problem problem(spec);
  std::set<PartIndex> reached = {0};
  for (bool grew = true; grew;) {
    grew = false;
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
      const auto [a, b] = problem.ends(c);
      if (reached.contains(a) != reached.contains(b))
        grew = reached.insert(a).second || reached.insert(b).second;
    }
  }
  return reached.size() == problem.num_parts();
}

TEST(Chain, IsARowOfParts) {
  EXPECT_EQ(pairs(chain(4)), "1-2 2-3 3-4");
  EXPECT_EQ(chain(4).name, "chain:4");
  EXPECT_EQ(chain(1).parts.size(), 1U);
  EXPECT_TRUE(chain(1).connections.empty());
  EXPECT_EQ(Problem(chain(kMaxParts)).num_connections(), kMaxParts - 1);
}

TEST(Chain, RefusesSizesOutOfRange) {
  EXPECT_EQ(fault_of([] { return chain(0); }),
            "chain:0: 0 parts are not possible; it takes 1 to 16384");
  EXPECT_EQ(fault_of([] { return chain(kMaxParts + 1); }),
            "chain:16385: 16385 parts are not possible; it takes 1 to 16384");
}

//   1 - 2 - 3
//   |   |   |
//   4 - 5 - 6
TEST(Grid, JoinsRightAndLowerNeighbours) {
  const ProblemSpec spec = grid(2, 3);
  EXPECT_EQ(pairs(spec), "1-2 1-4 2-3 2-5 3-6 4-5 5-6");
  EXPECT_EQ(spec.name, "grid:2x3");
  EXPECT_EQ(spec.parts[5].position, (Vector3{2, 1, 0}));
  EXPECT_EQ(Problem(grid(1, 1)).num_connections(), 0U);
}

TEST(Grid, RefusesSizesOutOfRange) {
  EXPECT_EQ(fault_of([] { return grid(0, 3); }),
            "grid:0x3: a grid has at least 1 row and 1 column, and at most 16384 parts");
  EXPECT_EQ(fault_of([] { return grid(200, 200); }),
            "grid:200x200: 40000 parts are not possible; it takes 1 to 16384");
  EXPECT_EQ(fault_of([] { return grid(128, 128); }),
            "grid:128x128: it would have 32512 connections; a problem has at most 16384");
  EXPECT_NE(fault_of([] { return grid(std::size_t{1} << 33U, std::size_t{1} << 33U); }),
            "no fault");
}

// Found by a second program (Python; the leaf of each step by looking at all of them).
TEST(RandomTree, IsTheSameOnEveryMachine) {
  EXPECT_EQ(pairs(random_tree(8, 1)), "1-2 1-8 2-3 2-4 4-7 5-8 6-7");
  EXPECT_EQ(pairs(random_tree(12, 7)), "1-3 1-7 2-4 4-5 4-11 6-7 6-11 6-12 7-10 8-10 9-11");
  EXPECT_EQ(random_tree(12, 7).name, "tree:12:7");
}

TEST(RandomTree, IsATree) {
  EXPECT_TRUE(random_tree(1, 5).connections.empty());
  EXPECT_EQ(pairs(random_tree(2, 5)), "1-2");
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const ProblemSpec spec = random_tree(30, seed);
    EXPECT_EQ(spec.connections.size(), 29U);
    EXPECT_TRUE(is_connected(spec)) << seed;
  }
}

// There are 4^2 = 16 trees on 4 labels (Cayley). Of 16,000 seeds each should get about 1,000; the
// standard deviation is sqrt(16000 * 1/16 * 15/16) = 31.
TEST(RandomTree, IsUniform) {
  std::map<std::string, int> counts;
  for (std::uint64_t seed = 0; seed < 16'000; ++seed) ++counts[pairs(random_tree(4, seed))];
  EXPECT_EQ(counts.size(), 16U);
  for (const auto& [tree, count] : counts) EXPECT_NEAR(count, 1000, 5 * 31) << tree;
}

TEST(RandomGraph, IsTheSameOnEveryMachine) {
  EXPECT_EQ(pairs(random_graph(6, 9, 3)), "1-2 1-3 1-4 1-5 2-4 2-5 3-4 4-6 5-6");
  EXPECT_EQ(random_graph(6, 9, 3).name, "random:6:9:3");
}

TEST(RandomGraph, IsConnectedWithoutParallelConnections) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const ProblemSpec spec = random_graph(20, 35, seed);
    EXPECT_EQ(spec.connections.size(), 35U);
    EXPECT_TRUE(is_connected(spec)) << seed;  // a Problem: so the default ids differ
  }
}

TEST(RandomGraph, IsATreeOrCompleteAtTheEndsOfItsRange) {
  EXPECT_EQ(pairs(random_graph(8, 7, 1)), pairs(random_tree(8, 1)));
  EXPECT_EQ(pairs(random_graph(4, 6, 1)), "1-2 1-3 1-4 2-3 2-4 3-4");
  EXPECT_TRUE(random_graph(1, 0, 1).connections.empty());
}

TEST(RandomGraph, RefusesNumbersOfConnectionsOutOfRange) {
  EXPECT_EQ(fault_of([] { return random_graph(5, 3, 1); }),
            "random:5:3:1: 3 connections are not possible; 5 parts take 4 to 10, at most one for "
            "each pair");
  EXPECT_EQ(fault_of([] { return random_graph(5, 11, 1); }),
            "random:5:11:1: 11 connections are not possible; 5 parts take 4 to 10, at most one for "
            "each pair");
}

}  // namespace
}  // namespace orasp
