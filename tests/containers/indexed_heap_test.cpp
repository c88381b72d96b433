#include "orasp/containers/indexed_heap.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/model/random.h"

namespace orasp::detail {
namespace {

TEST(IndexedHeap, GivesItemsByKeyAndTiesByNumber) {
  const std::vector<double> keys = {3, 1, 2, 1, 3};
  IndexedHeap heap(keys.size(), keys);
  for (std::uint32_t item = 5; item-- > 0;) heap.enter_or_decrease(item);
  std::vector<std::uint32_t> order;
  while (!heap.empty()) {
    order.push_back(heap.top());
    heap.pop();
  }
  EXPECT_EQ(order, (std::vector<std::uint32_t>{1, 3, 2, 0, 4}));
}

TEST(IndexedHeap, MovesAnItemUpWhenItsKeyDecreases) {
  std::vector<double> keys = {5, 6, 7};
  IndexedHeap heap(keys.size(), keys);
  for (std::uint32_t item = 0; item < 3; ++item) heap.enter_or_decrease(item);
  keys[2] = 1;
  heap.enter_or_decrease(2);
  EXPECT_EQ(heap.top(), 2U);
}

TEST(IndexedHeap, SortsManyItemsUnderRandomDecreases) {
  SplitMix64 random(3);
  std::vector<double> keys(500);
  for (double& key : keys) key = random.uniform();
  IndexedHeap heap(keys.size(), keys);
  for (std::uint32_t item = 0; item < 500; ++item) heap.enter_or_decrease(item);
  for (int i = 0; i < 2000; ++i) {
    const auto item = static_cast<std::uint32_t>(random.below(500));
    keys[item] *= random.uniform();
    heap.enter_or_decrease(item);
  }
  double last = -1;
  for (int i = 0; i < 500; ++i) {
    ASSERT_GE(keys[heap.top()], last);
    last = keys[heap.top()];
    heap.pop();
  }
  EXPECT_TRUE(heap.empty());
}

}  // namespace
}  // namespace orasp::detail
