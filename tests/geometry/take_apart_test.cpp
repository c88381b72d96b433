// Which parts and sets of parts can leave by straight motions.

#include "orasp/geometry/detail/take_apart.h"

#include <gtest/gtest.h>

namespace orasp {
namespace {

using detail::BlockedAlong;
using detail::take_apart;
using detail::TakenApart;
using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
using Facts = std::vector<BlockedAlong>;

TEST(TakeApart, WhatNothingBlocksComesOffPartByPart) {
  const TakenApart apart = take_apart(3, 2, {}, Pairs{{0, 1}, {1, 2}}, {});
  EXPECT_EQ(apart.moved, 1U);
  EXPECT_TRUE(apart.stuck.empty());
}

TEST(TakeApart, AStackComesOffFromTheTopAlongOneLine) {
  // Along direction 0 (up) each part is blocked by the one above it; along 1 by those below.
  const Facts facts = {{0, 1, 0}, {1, 2, 0}, {0, 2, 0}};
  const TakenApart apart = take_apart(3, 2, facts, Pairs{{0, 1}, {1, 2}}, {});
  EXPECT_EQ(apart.moved, 1U);
  EXPECT_TRUE(apart.stuck.empty());
}

TEST(TakeApart, TwoPartsThatBlockEachOtherBothWaysAreStuck) {
  const Facts facts = {{0, 1, 0}, {1, 0, 0}};
  const TakenApart apart = take_apart(2, 2, facts, Pairs{{0, 1}}, {});
  EXPECT_EQ(apart.stuck, (std::vector<std::vector<std::uint32_t>>{{0, 1}}));
}

TEST(TakeApart, WhatIsNotJoinedHindersNothing) {
  const Facts facts = {{0, 1, 0}, {1, 0, 0}};
  EXPECT_TRUE(take_apart(2, 2, facts, {}, {}).stuck.empty());
}

TEST(TakeApart, TwoHalvesThatHoldEachOtherLeaveTogether) {
  // Direction pairs 0/1 and 2/3. Two pairs, 0-1 and 2-3: along 0 the parts of a pair block each
  // other, and the first pair may leave the second; along 2 all four are in a ring. A pair is then
  // parted along 2, where its members do not block each other.
  const Facts facts = {{0, 1, 0}, {1, 0, 0}, {2, 3, 0}, {3, 2, 0},
                       {0, 2, 2}, {2, 1, 2}, {1, 3, 2}, {3, 0, 2}};
  const TakenApart apart = take_apart(4, 4, facts, Pairs{{0, 1}, {2, 3}, {0, 2}, {1, 3}}, {});
  EXPECT_EQ(apart.moved, 2U);
  EXPECT_TRUE(apart.stuck.empty());
}

TEST(TakeApart, TellsWhereWhatMovesDoesNotHangTogether) {
  // Two hooks in slots of a fixed plate, which they leave along 0 alone. They hold each other with
  // play, so nothing joins them but the plate.
  const Facts facts = {{0, 1, 0}, {1, 0, 0}, {0, 2, 1}, {1, 2, 1},
                       {0, 2, 2}, {0, 2, 3}, {1, 2, 2}, {1, 2, 3}};
  const TakenApart apart = take_apart(3, 4, facts, Pairs{{0, 2}, {1, 2}}, {false, false, true});
  EXPECT_EQ(apart.moved, 2U);
  EXPECT_FALSE(apart.hangs_together);
  EXPECT_TRUE(apart.stuck.empty());
  EXPECT_TRUE(
      take_apart(3, 4, facts, Pairs{{0, 1}, {0, 2}, {1, 2}}, {false, false, true}).hangs_together);
}

TEST(TakeApart, APartOfTheBaseStaysAndTheOtherSideMoves) {
  // Along 0 part 1 is blocked by part 0, so 0 leaves along 0 or 1 along 1. With 0 fixed 1 moves.
  const Facts facts = {{1, 0, 0}};
  const TakenApart apart = take_apart(2, 2, facts, Pairs{{0, 1}}, {true, false});
  EXPECT_EQ(apart.moved, 1U);
  EXPECT_TRUE(apart.stuck.empty());
}

TEST(TakeApart, StuckPartsAreNamedWithoutThoseThatComeOff) {
  const Facts facts = {{0, 1, 0}, {1, 0, 0}};
  const TakenApart apart = take_apart(4, 2, facts, Pairs{{0, 1}, {1, 2}, {2, 3}}, {});
  EXPECT_EQ(apart.stuck, (std::vector<std::vector<std::uint32_t>>{{0, 1}}));
}

}  // namespace
}  // namespace orasp
