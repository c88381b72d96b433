#include "orasp/learning/replay_buffer.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/model/random.h"

namespace orasp {
namespace {

/// An episode over three connections that takes `order`, each step earning what stands beside it.
/// Legal is what is open.
ReplayBuffer::Episode episode(const std::vector<std::pair<ConnectionIndex, double>>& order) {
  ReplayBuffer::Episode steps(3);
  ConnectionSet open = ConnectionSet::all(3);
  for (const auto& [connection, reward] : order) {
    std::vector<Action> actions;
    std::size_t taken = 0;
    for_each_connection(open.view(), [&](ConnectionIndex c) {
      if (c == connection) taken = actions.size();
      actions.push_back({c, c == connection ? reward : -9});
    });
    steps.push(open.view(), actions, taken);
    open.erase(connection);
  }
  return steps;
}

TEST(ReplayBuffer, RemembersStatesMasksAndRests) {
  ReplayBuffer buffer(10, 3);
  buffer.add(episode({{1, 2.0}, {0, 3.0}, {2, 4.0}}), false);
  ASSERT_EQ(buffer.size(), 3U);
  EXPECT_EQ(buffer.step(0).connection, 1U);
  EXPECT_EQ(buffer.step(0).num_open, 3U);
  EXPECT_EQ(buffer.step(0).left, 2U);
  EXPECT_EQ(buffer.step(0).rest, 9);
  EXPECT_EQ(buffer.step(1).rest, 7);
  EXPECT_EQ(buffer.step(2).rest, 4);
  EXPECT_EQ(buffer.step(2).left, 0U);
  EXPECT_EQ(buffer.open(1)[0], 0b101U);
  const auto legal = buffer.legal_rewards(1);
  EXPECT_EQ(legal[0], 3.0F);
  EXPECT_TRUE(std::isnan(legal[1])) << "handled before";
  EXPECT_EQ(legal[2], -9.0F);
  EXPECT_EQ(buffer.later(0, 2), 2U);
}

TEST(ReplayBuffer, OverwritesTheOldestAndWrapsEpisodes) {
  ReplayBuffer buffer(4, 3);
  buffer.add(episode({{0, 1.0}, {1, 1.0}, {2, 1.0}}), false);
  buffer.add(episode({{2, 5.0}, {1, 6.0}}), true);
  ASSERT_EQ(buffer.size(), 4U);
  // The second episode stands at places 3 and 0.
  EXPECT_EQ(buffer.step(3).connection, 2U);
  EXPECT_TRUE(buffer.step(3).dead_end);
  EXPECT_EQ(buffer.later(3, 1), 0U);
  EXPECT_EQ(buffer.step(0).connection, 1U);
  EXPECT_EQ(buffer.step(0).reward, 6);
  EXPECT_EQ(buffer.step(1).connection, 1U) << "of the first episode, whose first step is gone";
  EXPECT_FALSE(buffer.step(1).dead_end);
}

TEST(ReplayBuffer, KeepsTheEndOfAnEpisodeThatIsLongerThanItself) {
  ReplayBuffer buffer(2, 3);
  buffer.add(episode({{0, 1.0}, {1, 2.0}, {2, 4.0}}), false);
  ASSERT_EQ(buffer.size(), 2U);
  EXPECT_EQ(buffer.step(0).connection, 1U);
  EXPECT_EQ(buffer.step(0).rest, 6);
  EXPECT_EQ(buffer.step(1).connection, 2U);
}

TEST(ReplayBuffer, DrawsEveryStep) {
  ReplayBuffer buffer(10, 3);
  buffer.add(episode({{1, 2.0}, {0, 3.0}, {2, 4.0}}), false);
  SplitMix64 random(1);
  std::vector<int> drawn(3);
  for (int i = 0; i < 300; ++i) ++drawn[buffer.sample(random)];
  for (const int times : drawn) EXPECT_GT(times, 60);
}

}  // namespace
}  // namespace orasp
