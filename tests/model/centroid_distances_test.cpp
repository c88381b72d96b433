#include "orasp/model/detail/centroid_distances.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/model/random.h"
#include "orasp/model/tolerance.h"

namespace orasp {
namespace {

constexpr std::size_t kParts = 10;

/// Ten parts, some beside the depot; in some problems one is fixed, or two have no position.
ProblemSpec scattered(std::uint64_t seed) {
  SplitMix64 random(seed);
  ProblemSpec spec;
  const double beside = static_cast<double>(seed % 5);
  for (std::size_t p = 0; p < kParts; ++p) {
    Part part;
    part.id = std::to_string(p);
    if (seed % 4 != 1 || p > 1)
      part.position = Vector3{random.uniform() * 4 - 2 + beside, random.uniform() * 4 - 2 - beside,
                              random.uniform() * (seed % 3 == 0 ? 0 : 1)};
    spec.parts.push_back(part);
  }
  if (seed % 4 == 2) spec.base.push_back("3");
  return spec;
}

struct Sums {
  std::size_t count = 0;
  Vector3 sum = {0, 0, 0};
  bool counts = true;

  [[nodiscard]] double metres(const Vector3& depot) const {
    const auto n = static_cast<double>(count);
    return std::hypot(sum[0] / n - depot[0], sum[1] / n - depot[1], sum[2] / n - depot[2]);
  }
};

Sums sums_of(const Problem& problem, unsigned bits) {
  Sums sums;
  for (PartIndex p = 0; p < kParts; ++p) {
    if (((bits >> static_cast<std::size_t>(p)) & 1U) == 0) continue;
    const auto& position = problem.parts()[p].position;
    if (!position || problem.in_base(p)) {
      sums.counts = false;
      return sums;
    }
    ++sums.count;
    for (std::size_t i = 0; i < 3; ++i) sums.sum[i] += (*position)[i];
  }
  return sums;
}

// Against all sets of parts: never above the truth, and not far below it.
TEST(CentroidDistances, AreNeverAboveThoseOfAnySet) {
  double bounds = 0;
  double truths = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const Problem problem(scattered(seed));
    const Vector3 depot = {0.5, 0, -0.25};
    const detail::CentroidDistances distances(problem, depot);
    std::vector<double> least(kParts + 1, kInfinity);
    for (unsigned bits = 1; bits < 1U << kParts; ++bits) {
      const Sums sums = sums_of(problem, bits);
      if (sums.counts) least[sums.count] = std::min(least[sums.count], sums.metres(depot));
    }
    for (std::size_t count = 1; count <= kParts; ++count) {
      EXPECT_LE(distances.least(count), least[count]);
      if (count > 2) {
        EXPECT_GE(distances.least(count), distances.least(count - 1));
      }
      if (!std::isfinite(least[count])) continue;
      bounds += distances.least(count);
      truths += least[count];
    }
  }
  EXPECT_GT(bounds, 0.9 * truths);
}

// The same with some parts given; and what is said of a set is at most what is said of a larger
// one.
TEST(CentroidDistances, WithSomePartsGiven) {
  double bounds = 0;
  double truths = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Problem problem(scattered(seed));
    const Vector3 depot = {0, 0, 0};
    const detail::CentroidDistances distances(problem, depot);
    const detail::CentroidDistances::Sets sets{2 + seed % 3, 5 + seed % 4, kInfinity};
    const auto side_of = [](const std::vector<PartIndex>& parts) {
      return detail::Side{{std::span<const PartIndex>(parts), {}}};
    };
    for (unsigned some = 1; some < 1U << kParts; some += 1 + some % 7) {
      const Sums given = sums_of(problem, some);
      if (!given.counts) continue;
      std::vector<PartIndex> parts;
      for (PartIndex p = 0; p < kParts; ++p) {
        if (((some >> static_cast<std::size_t>(p)) & 1U) != 0) parts.push_back(p);
      }
      double metres = kInfinity;
      double moment = kInfinity;
      const unsigned others = ((1U << kParts) - 1) & ~some;
      for (unsigned more = others;; more = (more - 1) & others) {
        const Sums sums = sums_of(problem, some | more);
        if (sums.counts && sums.count >= sets.least && sums.count <= sets.most) {
          const double now = sums.metres(depot);
          metres = std::min(metres, now);
          moment = std::min(moment, static_cast<double>(sums.count) * now * now);
        }
        if (more == 0) break;
      }
      const double bound = distances.least_with(side_of(parts), sets);
      EXPECT_LE(bound, metres);
      EXPECT_LE(distances.least_moment_with(side_of(parts), sets), moment);
      // Less is asked, so less may be found, but not less than is asked.
      const double half = distances.least_with(side_of(parts), {sets.least, sets.most, bound / 2});
      EXPECT_GE(half, bound / 2);
      EXPECT_LE(half, metres);
      if (std::isfinite(metres)) {
        bounds += bound;
        truths += metres;
      }
      for (PartIndex p = 0; p < kParts; ++p) {
        const unsigned larger = some | 1U << static_cast<std::size_t>(p);
        if (larger == some || !sums_of(problem, larger).counts) continue;
        std::vector<PartIndex> with = parts;
        with.push_back(p);
        EXPECT_LE(bound, distances.least_with(side_of(with), sets) + 1e-12);
        EXPECT_LE(distances.least_moment_with(side_of(parts), sets),
                  distances.least_moment_with(side_of(with), sets) + 1e-12);
      }
    }
  }
  EXPECT_GT(bounds, 0.8 * truths);
}

}  // namespace
}  // namespace orasp
