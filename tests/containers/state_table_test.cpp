#include "orasp/containers/state_table.h"

#include <array>
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/model/random.h"

namespace orasp::detail {
namespace {

TEST(StateTable, NumbersKeysInOrderOfInsertion) {
  StateTable<1> table(1);
  const std::array<std::uint64_t, 3> keys = {7, 0, ~std::uint64_t{0}};
  EXPECT_EQ(table.insert(&keys[0]).number, 0U);
  EXPECT_EQ(table.insert(&keys[1]).number, 1U);
  EXPECT_EQ(table.insert(&keys[2]).number, 2U);
  EXPECT_FALSE(table.insert(&keys[1]).is_new);
  EXPECT_EQ(table.insert(&keys[1]).number, 1U);
  EXPECT_EQ(table.size(), 3U);
}

TEST(StateTable, FindsNothingInAnEmptyTable) {
  const StateTable<1> table(1);
  const std::uint64_t key = 0;
  EXPECT_EQ(table.find(&key), StateTable<1>::kAbsent);
}

TEST(StateTable, AgreesWithAMapOverManyKeysWhileItGrows) {
  SplitMix64 random(5);
  StateTable<1> table(1);
  std::map<std::uint64_t, std::uint32_t> expected;
  for (int i = 0; i < 50'000; ++i) {
    const std::uint64_t key = random.below(20'000) * 0x0101010101ULL;  // poor keys, many repeats
    const auto [at, is_new] =
        expected.try_emplace(key, static_cast<std::uint32_t>(expected.size()));
    const auto inserted = table.insert(&key);
    ASSERT_EQ(inserted.number, at->second);
    ASSERT_EQ(inserted.is_new, is_new);
  }
  for (const auto& [key, number] : expected) {
    ASSERT_EQ(table.find(&key), number);
    ASSERT_EQ(*table.key(number), key);
  }
  const std::uint64_t absent = 1;
  EXPECT_EQ(table.find(&absent), StateTable<1>::kAbsent);
}

TEST(StateTable, TellsWideKeysApartByAnyWord) {
  StateTable<0> table(3);
  std::map<std::array<std::uint64_t, 3>, std::uint32_t> expected;
  SplitMix64 random(6);
  for (int i = 0; i < 5'000; ++i) {
    const std::array<std::uint64_t, 3> key = {random.below(12), random.below(12), random.below(12)};
    const auto at = expected.try_emplace(key, static_cast<std::uint32_t>(expected.size())).first;
    ASSERT_EQ(table.insert(key.data()).number, at->second);
  }
  EXPECT_EQ(table.size(), expected.size());
}

TEST(StateTable, SaysBeforehandWhatItWillHold) {
  StateTable<1> table(1);
  for (std::uint64_t key = 0; key < 5'000;) {
    const std::uint64_t more = 1 + key % 97;
    const std::uint64_t promised = table.bytes_with(more);
    for (const std::uint64_t end = key + more; key < end; ++key)
      static_cast<void>(table.insert(&key));
    EXPECT_LE(table.bytes(), promised);
    EXPECT_GE(2 * table.bytes() + 2'048, promised);
  }
}

TEST(StateTable, ForgetsEverythingWhenCleared) {
  StateTable<1> table(1);
  const std::uint64_t key = 9;
  static_cast<void>(table.insert(&key));
  table.clear();
  EXPECT_EQ(table.size(), 0U);
  EXPECT_EQ(table.find(&key), StateTable<1>::kAbsent);
  EXPECT_TRUE(table.insert(&key).is_new);
}

}  // namespace
}  // namespace orasp::detail
