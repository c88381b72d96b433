#include "orasp/task/memory_limit.h"

#include <gtest/gtest.h>

namespace orasp {
namespace {

TEST(MemoryLimit, IsWhatTheBudgetAllows) {
  Budget budget;
  budget.max_bytes = 1000;
  EXPECT_EQ(allowed_bytes(budget), 1000U);
}

// Without a limit of its own a budget allows 80 % of the machine; the program's default is 75 % of
// the machine or of less.
TEST(MemoryLimit, LeavesSomethingToTheMachine) {
  const std::uint64_t most = allowed_bytes(Budget{});
  EXPECT_GT(most, 0U);
  EXPECT_LT(most, Budget{}.max_bytes);
  EXPECT_GT(default_memory_limit(), 0U);
  EXPECT_LT(default_memory_limit(), most);
}

}  // namespace
}  // namespace orasp
