#include "orasp/planners/detail/crew_cut.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/model/connection_set.h"
#include "orasp/model/error.h"
#include "tests/cluster/thread_ranks.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

class CrewOfRanks final : public detail::Crew {
 public:
  explicit CrewOfRanks(Ranks& ranks) : ranks_(ranks) {}
  [[nodiscard]] std::size_t size() const override { return ranks_.size(); }
  [[nodiscard]] std::size_t member() const override { return ranks_.rank(); }
  [[nodiscard]] std::vector<std::string> told_by_all(const std::string& mine) override {
    return ranks_.gather_everywhere(mine);
  }
  [[nodiscard]] std::vector<std::string> exchange(std::vector<std::string> texts) override {
    return ranks_.exchange(std::move(texts));
  }
  void take_sums(std::span<std::uint64_t> numbers) override { ranks_.take_sums(numbers); }
  void take_greatest(std::span<double> numbers) override { ranks_.take_greatest(numbers); }

 private:
  Ranks& ranks_;
};

// The cut that each member found among the keys that they hold, sorted.
std::vector<detail::CrewCut> cuts_of(const std::vector<std::vector<std::uint64_t>>& keys,
                                     std::uint64_t wanted) {
  return on_thread_ranks(keys.size(), [&](Ranks& ranks) {
    CrewOfRanks crew(ranks);
    const std::vector<std::uint64_t>& mine = keys[ranks.rank()];
    return detail::cut_of_all(
        crew, mine.size(), [&](std::size_t i) { return mine[i]; }, wanted);
  });
}

// What a stretch promises, of each member's own keys and of all of them.
void expect_cut(const std::vector<std::vector<std::uint64_t>>& keys, std::uint64_t wanted) {
  const auto cuts = cuts_of(keys, wanted);
  std::uint64_t below = 0;
  std::uint64_t up_to = 0;
  std::uint64_t count = 0;
  std::uint64_t most_below = 0;
  std::vector<std::uint64_t> stretch;
  std::uint64_t least_above = std::numeric_limits<std::uint64_t>::max();
  for (std::size_t member = 0; member < keys.size(); ++member) {
    const detail::CrewCut& cut = cuts[member];
    EXPECT_EQ(cut.below, cuts[0].below);
    EXPECT_EQ(cut.up_to, cuts[0].up_to);
    below += cut.begin;
    up_to += cut.end;
    count += keys[member].size();
    for (std::size_t i = 0; i < keys[member].size(); ++i) {
      const std::uint64_t key = keys[member][i];
      if (i < cut.begin) most_below = std::max(most_below, key);
      if (i >= cut.end) least_above = std::min(least_above, key);
      if (i >= cut.begin && i < cut.end) stretch.push_back(key);
    }
  }
  EXPECT_EQ(below, cuts[0].below);
  EXPECT_EQ(up_to, cuts[0].up_to);
  EXPECT_LT(below, wanted);
  EXPECT_LE(wanted, up_to);
  ASSERT_FALSE(stretch.empty());
  const auto [least, greatest] = std::ranges::minmax(stretch);
  if (below > 0) {
    EXPECT_LT(most_below, least);
  }
  EXPECT_GE(least_above, greatest);
  if (wanted != up_to) {
    EXPECT_EQ(least, greatest);
    EXPECT_TRUE(up_to == count || greatest < least_above);
  }
}

TEST(CrewCut, EndsAfterTheWantedLeastKeysOfAll) {
  // 1 2 2 2 7 9: three of them end among the twos, four after them.
  const std::vector<std::vector<std::uint64_t>> keys = {{2, 9}, {}, {1, 2, 2, 7}};
  const auto among = cuts_of(keys, 3);
  EXPECT_EQ(among[0].below, 1U);
  EXPECT_EQ(among[0].up_to, 4U);
  EXPECT_EQ(among[2].begin, 1U);
  EXPECT_EQ(among[2].end, 3U);
  EXPECT_EQ(cuts_of(keys, 4)[1].up_to, 4U);
}

TEST(CrewCut, IsRightForKeysOfEveryKind) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  for (std::uint64_t seed = 0; seed < some_of(std::uint64_t{200}); ++seed) {
    SCOPED_TRACE(seed);
    std::uint64_t state = mixed(seed + 1);
    const auto random = [&] { return state = mixed(state + 0x9e3779b97f4a7c15ULL); };
    std::vector<std::vector<std::uint64_t>> keys(1 + seed % 5);
    // From few keys that are often the same to keys all over, the least and the greatest among
    // them.
    const std::uint64_t range = seed % 4 == 0 ? kMost : std::uint64_t{1} << (2 + random() % 60);
    const std::uint64_t count = 1 + random() % 300;
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::uint64_t kind = random() % 20;
      keys[random() % keys.size()].push_back(kind == 0 ? 0 : kind == 1 ? kMost : random() % range);
    }
    for (auto& of_member : keys) std::ranges::sort(of_member);
    expect_cut(keys, 1);
    expect_cut(keys, count);
    expect_cut(keys, 1 + random() % count);
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace orasp
