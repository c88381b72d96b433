#include "orasp/cluster/share_out.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/cluster/thread_ranks.h"

namespace orasp {
namespace {

constexpr auto kFailed = [](std::size_t piece, const std::string& why) {
  return std::to_string(piece) + ": " + why;
};

TEST(ShareOut, EveryPieceIsDoneOnceAndItsAnswerStandsInItsPlace) {
  for (const std::size_t count : {1U, 2U, 5U}) {
    std::array<std::atomic<int>, 40> done{};
    const auto answers = on_thread_ranks(count, [&](Ranks& ranks) {
      return share_out(ranks, done.size(),
                       [&](std::size_t piece, const std::stop_token&) {
                         ++done[piece];
                         return "piece " + std::to_string(piece);
                       },
                       kFailed, {});
    });
    ASSERT_EQ(answers[0].size(), done.size());
    for (std::size_t piece = 0; piece < done.size(); ++piece) {
      EXPECT_EQ(done[piece], 1);
      EXPECT_EQ(answers[0][piece], "piece " + std::to_string(piece));
    }
    for (std::size_t rank = 1; rank < count; ++rank) EXPECT_TRUE(answers[rank].empty());
  }
}

TEST(ShareOut, WhatFailsOnARankIsDoneByAnother) {
  std::atomic<int> failures = 0;
  const auto answers = on_thread_ranks(3, [&](Ranks& ranks) {
    return share_out(ranks, 9,
                     [&](std::size_t piece, const std::stop_token&) -> std::string {
                       if (ranks.rank() == 0) {
                         ++failures;
                         throw std::bad_alloc();
                       }
                       return std::to_string(piece);
                     },
                     kFailed, {});
  });
  EXPECT_GT(failures, 0);
  for (std::size_t piece = 0; piece < 9; ++piece)
    EXPECT_EQ(answers[0][piece], std::to_string(piece));
}

TEST(ShareOut, WhatFailsTwiceIsSaidWithItsReason) {
  for (const std::size_t count : {1U, 2U, 3U}) {
    std::atomic<std::size_t> tries = 0;
    const auto answers = on_thread_ranks(count, [&](Ranks& ranks) {
      return share_out(ranks, 4,
                       [&](std::size_t piece, const std::stop_token&) -> std::string {
                         if (piece != 2) return "done";
                         ++tries;
                         throw std::runtime_error("no luck");
                       },
                       kFailed, {});
    });
    EXPECT_EQ(tries, std::min<std::size_t>(count, 2));
    const std::vector<std::optional<std::string>> expected = {"done", "done", "2: no luck", "done"};
    EXPECT_EQ(answers[0], expected);
  }
}

TEST(ShareOut, AStopOnAnyRankStopsAll) {
  for (const std::size_t stopped : {0U, 2U}) {
    const auto answers = on_thread_ranks(3, [&](Ranks& ranks) {
      std::stop_source source;
      const auto work = [&](std::size_t piece, const std::stop_token& stop) {
        // The stop comes in the middle of the first piece of a rank.
        if (ranks.rank() == stopped) source.request_stop();
        while (!stop.stop_requested()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return std::to_string(piece);
      };
      return share_out(ranks, 8, work, kFailed, source.get_token());
    });
    EXPECT_EQ(std::ranges::count_if(answers[0], [](const auto& one) { return one.has_value(); }),
              3);
  }
}

}  // namespace
}  // namespace orasp
