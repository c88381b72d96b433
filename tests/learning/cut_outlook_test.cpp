// Which few parts could come off next, against all sets of parts of small products.

#include "orasp/learning/cut_outlook.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/bounds/piece_bound.h"
#include "orasp/io/problem_source.h"
#include "orasp/model/random.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

using Mask = std::uint64_t;

/// A product as masks of its parts.
class Masks {
 public:
  Masks(const Problem& problem, const ConnectionSet& present)
      : problem_(problem), present_(present) {}

  /// Whether these parts hang together.
  [[nodiscard]] bool connected(Mask parts) const {
    Mask reached = parts & (~parts + 1);
    for (Mask before = 0; reached != before;) {
      before = reached;
      for_each_connection(present_.view(), [&](ConnectionIndex c) {
        const Mask ends = ends_of(c);
        if ((ends & parts) == ends && (ends & reached) != 0) reached |= ends;
      });
    }
    return reached == parts;
  }
  /// The connections between the one and the other.
  [[nodiscard]] std::vector<ConnectionIndex> between(Mask a, Mask b) const {
    std::vector<ConnectionIndex> found;
    for_each_connection(present_.view(), [&](ConnectionIndex c) {
      if ((ends_of(c) & a) != 0 && (ends_of(c) & b) != 0 && (ends_of(c) & ~(a | b)) == 0)
        found.push_back(c);
    });
    return found;
  }
  [[nodiscard]] Mask ends_of(ConnectionIndex c) const {
    const auto& ends = problem_.ends(c);
    return Mask{1} << static_cast<std::size_t>(ends[0]) | Mask{1}
                                                              << static_cast<std::size_t>(ends[1]);
  }

 private:
  const Problem& problem_;
  const ConnectionSet& present_;
};

std::vector<PartIndex> parts_of(Mask mask) {
  std::vector<PartIndex> parts;
  for (std::size_t p = 0; p < 64; ++p) {
    if ((mask >> p & 1U) != 0) parts.push_back(static_cast<PartIndex>(p));
  }
  return parts;
}

/// What each connection helps to cut off, by definition: the loss of every set, with how many
/// connections hold it.
std::map<ConnectionIndex, std::vector<std::pair<double, std::size_t>>> held_by(
    const TransitionSystem& system, const PieceGains& gains, const ConnectionSet& present) {
  const Problem& problem = system.problem();
  const Masks masks(problem, present);
  Expander expander(system);
  const auto bound = [&](Mask parts) {
    if (std::popcount(parts) < 2) return 0.0;
    const std::vector<PartIndex> piece = parts_of(parts);
    double most = kInfinity;
    if (gains.sizes_known()) most = gains.by_size(piece.size());
    if (gains.parts_known()) most = std::min(most, gains.by_parts(piece));
    return most;
  };
  const auto& limit = problem.limits().max_subassemblies;
  const bool full =
      limit && system.subassemblies(present.view()) >= static_cast<std::size_t>(*limit);
  std::map<ConnectionIndex, std::vector<std::pair<double, std::size_t>>> held;
  const Mask all = (Mask{1} << problem.num_parts()) - 1;
  for (Mask piece = 1; piece <= all; ++piece) {
    if (!masks.connected(piece) || !masks.between(piece, all & ~piece).empty()) continue;
    for (Mask set = piece; set > 0; set = (set - 1) & piece) {
      const Mask rest = piece & ~set;
      if (rest == 0 || std::popcount(set) > 3) continue;
      if (!masks.connected(set) || !masks.connected(rest)) continue;
      if (full && std::popcount(set) > 1 && std::popcount(rest) > 1) continue;
      const auto holding = masks.between(set, rest);
      const ConnectionIndex last = holding.back();
      const bool forwards = (set >> static_cast<std::size_t>(problem.ends(last)[0]) & 1U) != 0;
      const auto gain =
          expander.cut_gain(parts_of(forwards ? set : rest), parts_of(forwards ? rest : set), last);
      if (!gain) continue;
      for (const ConnectionIndex c : holding)
        held[c].emplace_back(bound(piece) - *gain - bound(set) - bound(rest), holding.size());
    }
  }
  return held;
}

TEST(CutOutlook, IsWhatAllSetsOfUpToThreePartsSay) {
  int known = 0;
  int several = 0;
  int forbidden = 0;
  for (std::uint64_t seed = 0; seed < some_of(std::uint64_t{400}); ++seed) {
    ProblemSpec spec = seed % 2 == 0 ? random_problem(seed) : larger_random_problem(seed);
    spec.direction = Direction::Disassembly;
    spec.objective = Objective::named(seed % 3 == 0 ? "cubesat" : "time");
    const Problem problem(std::move(spec));
    const TransitionSystem system(problem);
    const auto gains = std::make_shared<const PieceGains>(system);
    CutOutlook outlook(system, gains);
    if (!outlook.known()) continue;
    PieceBound bound(system, PieceBound::Kind::Both);
    SplitMix64 random(seed);
    Expander expander(system);
    for (ConnectionSet open = system.start(); !open.empty();) {
      const auto legal = expander.legal_actions(open.view());
      const std::vector<Action> actions(legal.begin(), legal.end());
      if (actions.empty()) break;
      const auto held = held_by(system, *gains, open);
      const auto seen = outlook.look(open.view(), actions);
      ASSERT_EQ(seen.size(), actions.size());
      for (std::size_t i = 0; i < actions.size(); ++i) {
        const auto at = held.find(actions[i].connection);
        ASSERT_EQ(seen[i].known, at != held.end()) << seed;
        if (!seen[i].known) {
          ++forbidden;
          EXPECT_FALSE(seen[i].holds_best);
          continue;
        }
        ++known;
        const double least = std::ranges::min_element(at->second)->first;
        EXPECT_NEAR(seen[i].loss, std::max(least, 0.0), 1e-7) << seed;
        EXPECT_GT(least, -1e-7) << "the bound is consistent, so that nothing is gained";
        std::size_t left = 100;
        for (const auto& [loss, holding] : at->second) {
          if (loss < least + 1e-9) left = std::min(left, holding);
        }
        EXPECT_EQ(seen[i].left, left) << seed;
        if (left > 1) ++several;
      }
      // Who holds the best set of all loses least of all.
      const auto loses_less = [](const auto& a, const auto& b) {
        return !b.known || (a.known && a.loss < b.loss - 1e-7);
      };
      for (std::size_t i = 0; i < actions.size(); ++i) {
        if (!seen[i].holds_best || system.subassemblies(open.view()) > 1) continue;
        EXPECT_TRUE(std::ranges::none_of(seen, [&](const auto& other) {
          return loses_less(other, seen[i]) && other.known;
        })) << seed;
      }
      open.erase(actions[random.below(actions.size())].connection);
    }
  }
  EXPECT_GT(known, more_than(2000));
  EXPECT_GT(several, more_than(500));
  EXPECT_GT(forbidden, more_than(10));
}

TEST(CutOutlook, KnowsNothingOfPlansThatPutTogether) {
  ProblemSpec spec = find_problem("grid:3x3").spec();
  spec.objective = Objective::named("time");
  spec.direction = Direction::Assembly;
  const Problem problem(std::move(spec));
  const TransitionSystem system(problem);
  CutOutlook outlook(system, std::make_shared<const PieceGains>(system));
  EXPECT_FALSE(outlook.known());
}

}  // namespace
}  // namespace orasp
