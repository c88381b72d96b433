#include "orasp/model/random.h"

#include <gtest/gtest.h>

namespace orasp {
namespace {

// The reference implementation's first numbers.
TEST(SplitMix64, HasTheNumbersOfTheReference) {
  EXPECT_EQ(SplitMix64(0).next(), 0xe220a8397b1dcdafULL);
  SplitMix64 random(42);
  EXPECT_EQ(random.next(), 13679457532755275413ULL);
  EXPECT_EQ(random.next(), 2949826092126892291ULL);
}

TEST(SplitMix64, StaysBelowItsBound) {
  SplitMix64 random(1);
  for (std::uint64_t bound = 1; bound < 100; ++bound) EXPECT_LT(random.below(bound), bound);
  for (int i = 0; i < 1000; ++i) {
    const double x = random.uniform();
    EXPECT_GE(x, 0);
    EXPECT_LT(x, 1);
  }
}

TEST(SplitMix64, GoesOnFromItsState) {
  SplitMix64 random(7);
  static_cast<void>(random.next());
  SplitMix64 copy(random.state());
  EXPECT_EQ(copy.next(), random.next());
}

}  // namespace
}  // namespace orasp
