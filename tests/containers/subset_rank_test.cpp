#include "orasp/containers/subset_rank.h"

#include <bit>
#include <map>
#include <vector>

#include <gtest/gtest.h>

namespace orasp::detail {
namespace {

TEST(SubsetRank, CountsSubsets) {
  const SubsetRank ranks;
  EXPECT_EQ(ranks.subsets(0, 0), 1U);
  EXPECT_EQ(ranks.subsets(3, 4), 0U);
  EXPECT_EQ(ranks.subsets(19, 9), 92'378U);
  EXPECT_EQ(ranks.subsets(64, 0), 1U);
  EXPECT_EQ(ranks.subsets(64, 64), 1U);
  EXPECT_EQ(ranks.subsets(64, 32), 1'832'624'140'942'590'534U);
}

TEST(SubsetRank, NextWalksThroughAllSubsetsOfASizeInAscendingOrder) {
  for (std::size_t size = 0; size <= 8; ++size) {
    std::uint64_t subset = SubsetRank::first(size);
    for (std::uint64_t mask = 0; mask < 256; ++mask) {
      if (static_cast<std::size_t>(std::popcount(mask)) != size) continue;
      ASSERT_EQ(subset, mask);
      subset = SubsetRank::next(subset);
    }
  }
}

TEST(SubsetRank, RanksOfSetsWithoutAMemberAreTheirPlacesInThatOrder) {
  const SubsetRank ranks;
  std::vector<std::uint64_t> rank_of(1 << 10);
  std::map<int, std::uint64_t> next;
  for (std::uint64_t mask = 0; mask < rank_of.size(); ++mask)
    rank_of[mask] = next[std::popcount(mask)]++;
  for (std::uint64_t set = 1; set < rank_of.size(); ++set) {
    std::uint64_t seen = 0;
    ranks.for_each_without(set, [&](std::uint8_t member, std::uint64_t rank) {
      const std::uint64_t bit = std::uint64_t{1} << member;
      ASSERT_NE(set & bit, 0U);
      ASSERT_EQ(rank, rank_of[set ^ bit]);
      ASSERT_GT(bit, seen) << "members come in ascending order";
      seen |= bit;
    });
    ASSERT_EQ(seen, set);
  }
}

TEST(SubsetRank, ReachesTheHighestOfSixtyFour) {
  const SubsetRank ranks;
  const std::uint64_t set = std::uint64_t{1} << 63 | 1U;
  std::vector<std::uint64_t> found;
  ranks.for_each_without(set, [&](std::uint8_t, std::uint64_t rank) { found.push_back(rank); });
  EXPECT_EQ(found,
            (std::vector<std::uint64_t>{63, 0}));  // {63} is the last of 64 singles, {0} the first
}

}  // namespace
}  // namespace orasp::detail
