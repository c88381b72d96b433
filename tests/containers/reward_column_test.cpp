#include "orasp/containers/reward_column.h"

#include <vector>

#include <gtest/gtest.h>

namespace orasp::detail {
namespace {

/// Appends `values` as a builder does: numbered while that is possible.
void append(RewardColumn& column, ValueNumbers& local, const std::vector<double>& values) {
  std::vector<std::uint32_t> numbers;
  for (const double value : values) numbers.push_back(local.number(value));
  const auto global = column.admit(local.values());
  const std::size_t at = column.size();
  column.extend(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (column.numbered()) {
      column.set_number(at + i, global[numbers[i]]);
    } else {
      column.set_value(at + i, values[i]);
    }
  }
}

TEST(RewardColumn, TakesOneByteForFewValues) {
  RewardColumn column;
  ValueNumbers local;
  append(column, local, {1.5, -0.25, 1.5, 0.0, -0.0});
  EXPECT_EQ(column.bytes(), 5U);
  EXPECT_EQ(column[1], -0.25);
  EXPECT_EQ(column[2], 1.5);
}

class RewardColumnWidths : public testing::TestWithParam<std::pair<std::size_t, std::size_t>> {};

TEST_P(RewardColumnWidths, KeepsEveryValueWhileItWidens) {
  const auto [distinct, bytes_each] = GetParam();
  RewardColumn column;
  ValueNumbers local;
  std::vector<double> all;
  for (std::size_t begin = 0; begin < distinct; begin += 100) {
    std::vector<double> some;
    for (std::size_t i = begin; i < std::min(begin + 100, distinct); ++i)
      some.push_back(static_cast<double>(i) / 7);
    append(column, local, some);
    all.insert(all.end(), some.begin(), some.end());
  }
  ASSERT_EQ(column.size(), all.size());
  for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(column[i], all[i]);
  EXPECT_EQ(column.bytes(), bytes_each * all.size());
  const double last = column.with_reader([&](auto value_of) { return value_of(all.size() - 1); });
  EXPECT_EQ(last, all.back());
}

INSTANTIATE_TEST_SUITE_P(AroundTheLimits, RewardColumnWidths,
                         testing::Values(std::pair{256, 1}, std::pair{257, 2}, std::pair{65'536, 2},
                                         std::pair{65'537, 8}));

}  // namespace
}  // namespace orasp::detail
