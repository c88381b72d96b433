#include "orasp/bounds/small_pieces.h"

#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/bounds/piece_bound.h"
#include "orasp/bounds/raised_prices.h"
#include "orasp/model/random.h"
#include "orasp/model/tolerance.h"
#include "orasp/model/transition_system.h"

namespace orasp {
namespace {

constexpr std::size_t kParts = 9;

double between(SplitMix64& random, double least, double most) {
  return least + (most - least) * random.uniform();
}

/// Nine parts at random places around the depot, or some metres beside it, joined by a random tree
/// and some more connections; in every third problem with one base part, in every third with two.
ProblemSpec random_product(std::uint64_t seed, const std::string& objective) {
  SplitMix64 random(seed);
  ProblemSpec spec;
  spec.name = "p" + std::to_string(seed);
  const double beside = 3 * static_cast<double>(seed % 4);
  for (std::size_t p = 0; p < kParts; ++p) {
    Part part;
    part.id = std::string(1, static_cast<char>('a' + p));
    part.mass = between(random, 1, 5);
    part.position =
        Vector3{between(random, -3, 3) + beside, between(random, -3, 3), between(random, -3, 3)};
    spec.parts.push_back(part);
  }
  std::vector<std::vector<bool>> joined(kParts, std::vector<bool>(kParts, false));
  const auto join = [&](std::size_t a, std::size_t b) {
    if (a == b || joined[a][b]) return;
    joined[a][b] = joined[b][a] = true;
    Connection connection;
    connection.parts = {spec.parts[a].id, spec.parts[b].id};
    spec.connections.push_back(connection);
  };
  for (std::size_t p = 1; p < kParts; ++p) join(p, random.below(p));
  for (std::size_t extra = seed % 5; extra > 0; --extra)
    join(random.below(kParts), random.below(kParts));
  for (std::size_t base = seed % 3; base > 0; --base) spec.base.push_back(spec.parts[base * 2].id);
  spec.objective = Objective::named(objective);
  return spec;
}

/// What is known of the larger moves of a problem.
LargerMoves larger_moves(const TransitionSystem& system, Expander& expander) {
  return LargerMoves::of(
      system, system.problem().base().empty() ? kParts / 2 : kParts - 1,
      [&](std::size_t moved, std::size_t kept) { return expander.greatest_gain(moved, kept); });
}

/// The parts of a set of bits.
std::vector<PartIndex> parts_of(unsigned bits) {
  std::vector<PartIndex> parts;
  for (PartIndex p = 0; p < kParts; ++p) {
    if (((bits >> static_cast<std::size_t>(p)) & 1U) != 0) parts.push_back(p);
  }
  return parts;
}

bool connected(const Problem& problem, unsigned bits) {
  unsigned reached = bits & (~bits + 1);
  for (unsigned before = 0; before != reached;) {
    before = reached;
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
      const unsigned a = 1U << static_cast<std::size_t>(problem.ends(c)[0]);
      const unsigned b = 1U << static_cast<std::size_t>(problem.ends(c)[1]);
      if ((bits & a) != 0 && (bits & b) != 0 && (reached & (a | b)) != 0) reached |= a | b;
    }
  }
  return reached == bits;
}

/// Calls visit(a, b, c) for each way to cut the piece `bits` at connection c into two sides that
/// hang together; `a` holds the first part of c.
template <class Visit>
void for_each_cut(const Problem& problem, unsigned bits, Visit&& visit) {
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const unsigned first = 1U << static_cast<std::size_t>(problem.ends(c)[0]);
    const unsigned second = 1U << static_cast<std::size_t>(problem.ends(c)[1]);
    for (unsigned a = (bits - 1) & bits; a != 0; a = (a - 1) & bits) {
      const unsigned b = bits & ~a;
      if ((a & first) == 0 || (b & second) == 0) continue;
      if (connected(problem, a) && connected(problem, b)) visit(a, b, c);
    }
  }
}

// For every piece and every cut of it the bound is at least what the cut gains and the bounds of
// the two sides, whatever sizes are listed. So it is admissible too, by induction.
TEST(SmallPieces, EveryCutOfEveryPieceKeepsTheBound) {
  std::size_t with_largest = 0;
  std::size_t without_largest = 0;
  for (const char* objective : {"time", "travel"}) {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
      const ProblemSpec spec = random_product(seed, objective);
      const Problem problem(spec);
      const TransitionSystem system(problem);
      Expander expander(system);
      SCOPED_TRACE(spec.name + " " + objective);
      const LargerMoves moves = seed % 8 == 0 ? LargerMoves{} : larger_moves(system, expander);
      std::size_t sets = 0;  // of at most seven parts
      for (unsigned bits = 1; bits < 1U << kParts; ++bits)
        sets += std::popcount(bits) <= 7 && connected(problem, bits) ? 1 : 0;
      for (std::size_t most = 1; most <= kParts; ++most) {
        // In the end those of more than seven parts are too many, and those of seven count where
        // they bring something.
        const bool cut_short = most == kParts;
        const ListingEffort effort{.most_sets = cut_short ? sets : SmallPieces::kFewSets};
        const SmallPieces pieces(system, expander, most, moves, effort);
        const std::size_t listed = cut_short ? 6 : most;
        ASSERT_EQ(pieces.more_could_be_listed(), cut_short);
        ASSERT_TRUE(pieces.known());
        if (cut_short) (pieces.priced(7) ? without_largest : with_largest) += 1;
        std::vector<double> bounds(1U << kParts, -kInfinity);
        for (unsigned bits = 1; bits < 1U << kParts; ++bits) {
          if (connected(problem, bits)) bounds[bits] = pieces.bound(parts_of(bits));
        }
        for (unsigned bits = 1; bits < 1U << kParts; ++bits) {
          if (bounds[bits] == -kInfinity) continue;
          double best = parts_of(bits).size() == 1 ? 0 : -kInfinity;
          for_each_cut(problem, bits, [&](unsigned a, unsigned b, ConnectionIndex c) {
            const auto gain = expander.cut_gain(parts_of(a), parts_of(b), c);
            if (gain) best = std::max(best, *gain + bounds[a] + bounds[b]);
          });
          EXPECT_GE(bounds[bits], best - 1e-9);
          // What is listed is exact.
          if (parts_of(bits).size() <= listed) {
            EXPECT_NEAR(bounds[bits], best, 1e-9);
          }
        }
      }
    }
  }
  EXPECT_GT(with_largest, 0U);
  EXPECT_GT(without_largest, 0U);
}

/// random_product() with parts in each other's way.
ProblemSpec blocked_product(std::uint64_t seed, const std::string& objective) {
  ProblemSpec spec = random_product(seed, objective);
  SplitMix64 random(seed + 1000);
  spec.blocking = Blocking{};
  spec.blocking->directions = {"+x", "-x", "+z", "-z"};
  for (const Part& part : spec.parts) {
    for (const Part& by : spec.parts) {
      if (part.id == by.id || random.below(10) > 1 + seed % 3) continue;
      const BlockingDirection& direction = spec.blocking->directions[random.below(4)];
      spec.blocking->blocked.push_back({part.id, by.id, {direction.id}});
    }
  }
  return spec;
}

// Prices pay no heed to sets that blocking keeps from coming off a large piece. So the bound is
// kept by every cut of the pieces that legal cuts lead to.
TEST(SmallPieces, EveryLegalCutOfBlockedPartsKeepsTheBound) {
  std::size_t tighter = 0;
  std::size_t plans = 0;
  for (const char* objective : {"time", "travel"}) {
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
      const Problem problem(blocked_product(seed, objective));
      const TransitionSystem system(problem);
      Expander expander(system);
      SCOPED_TRACE(problem.spec().name + " " + objective);
      const std::size_t listed = 1 + seed % 6;
      const SmallPieces pieces(system, expander, listed, larger_moves(system, expander), {});
      ASSERT_TRUE(pieces.known());
      // By piece: the most that its cuts gain, -infinity where it cannot be taken apart. NaN: not
      // yet asked.
      std::vector<double> value(1U << kParts, std::numeric_limits<double>::quiet_NaN());
      const std::function<double(unsigned)> value_of = [&](unsigned bits) {
        if (!std::isnan(value[bits])) return value[bits];
        const double bound = pieces.bound(parts_of(bits));
        double most = parts_of(bits).size() == 1 ? 0 : -kInfinity;
        for_each_cut(problem, bits, [&](unsigned a, unsigned b, ConnectionIndex c) {
          const auto gain = expander.cut_gain(parts_of(a), parts_of(b), c);
          if (!gain) return;
          const double sides = value_of(a) + value_of(b);
          EXPECT_GE(bound, *gain + pieces.bound(parts_of(a)) + pieces.bound(parts_of(b)) - 1e-9);
          most = std::max(most, *gain + sides);
        });
        EXPECT_GE(bound, most - 1e-9);
        return value[bits] = most;
      };
      const unsigned all = (1U << kParts) - 1;
      if (value_of(all) == -kInfinity) continue;
      ++plans;
      ProblemSpec free = problem.spec();
      free.blocking.reset();
      const Problem without(free);
      const TransitionSystem free_system(without);
      Expander free_expander(free_system);
      const SmallPieces free_pieces(free_system, free_expander, listed,
                                    larger_moves(free_system, free_expander), {});
      if (pieces.bound(parts_of(all)) < free_pieces.bound(parts_of(all)) - 1e-6) ++tighter;
    }
  }
  EXPECT_GT(plans, 100U);
  EXPECT_GT(tighter, 10U);
}

// What the parts of a piece cost more than the prices that fit all pieces is never more than what
// its cuts lose, whether it is worked out for the piece alone, from a piece that it was cut from,
// or with few conditions or none at hand.
TEST(RaisedPrices, SayNoMoreThanWhatTheCutsOfAPieceLose) {
  std::size_t raised = 0;
  std::size_t raised_by_few = 0;
  for (const char* objective : {"time", "travel"}) {
    for (std::uint64_t seed = 0; seed < 150; ++seed) {
      const Problem problem(seed % 3 == 0 ? random_product(seed, objective)
                                          : blocked_product(seed, objective));
      const TransitionSystem system(problem);
      Expander expander(system);
      SCOPED_TRACE(problem.spec().name + " " + objective);
      const std::size_t listed = 1 + seed % 5;
      const LargerMoves moves = larger_moves(system, expander);
      const SmallPieces pieces(system, expander, listed, moves, {});
      const SmallPieces with_few(system, expander, listed, moves, {.most_near_rows = seed % 20});
      const RaisedPrices prices(pieces, kParts);
      const RaisedPrices few_prices(with_few, kParts);
      const auto raise_of = [](const RaisedPrices& of, const std::vector<PartIndex>& piece) {
        RaisedPrices::Raise raise;
        of.fit(of.none(), piece, kInfinity, raise);
        return raise.sum();
      };
      // By piece: the most that its cuts gain. NaN: not yet asked.
      std::vector<double> value(1U << kParts, std::numeric_limits<double>::quiet_NaN());
      const std::function<double(unsigned, const RaisedPrices::Raise&)> value_of =
          [&](unsigned bits, const RaisedPrices::Raise& above) {
            if (!std::isnan(value[bits])) return value[bits];
            const std::vector<PartIndex> piece = parts_of(bits);
            RaisedPrices::Raise raise;
            prices.fit(above, piece, kInfinity, raise);
            double most = piece.size() == 1 ? 0 : -kInfinity;
            for_each_cut(problem, bits, [&](unsigned a, unsigned b, ConnectionIndex c) {
              const auto gain = expander.cut_gain(parts_of(a), parts_of(b), c);
              if (gain) most = std::max(most, *gain + value_of(a, raise) + value_of(b, raise));
            });
            if (pieces.priced(piece.size())) {
              const double bound = pieces.bound(piece);
              EXPECT_GE(raise.sum(), -1e-9);
              EXPECT_GE(bound - raise.sum(), most - 1e-9);
              const double alone = raise_of(prices, piece);
              EXPECT_GE(bound - alone, most - 1e-9);
              const double by_few = raise_of(few_prices, piece);
              EXPECT_GE(bound - by_few, most - 1e-9);
              RaisedPrices::Raise some;
              prices.fit(prices.none(), piece, alone / 2, some);
              EXPECT_LE(some.sum(), alone + 1e-9);
              EXPECT_GE(some.sum(), alone / 2);
              if (alone > 1e-3) ++raised;
              if (by_few > 1e-3) ++raised_by_few;
            }
            return value[bits] = most;
          };
      static_cast<void>(value_of((1U << kParts) - 1, prices.none()));
    }
  }
  EXPECT_GT(raised, 5'000U);
  EXPECT_GT(raised_by_few, 500U);
}

// A product beside the depot costs much more than one around it: large pieces that move are priced.
TEST(SmallPieces, LargerMovesArePriced) {
  for (const char* objective : {"time", "travel"}) {
    for (std::uint64_t seed = 3; seed < 60; seed += 12) {
      const Problem problem(random_product(seed, objective));
      const TransitionSystem system(problem);
      Expander expander(system);
      const std::vector<PartIndex> all = parts_of((1U << kParts) - 1);
      const double blind = SmallPieces(system, expander, 2, {}, {}).bound(all);
      const double priced =
          SmallPieces(system, expander, 2, larger_moves(system, expander), {}).bound(all);
      const double exact = SmallPieces(system, expander, 9, {}, {}).bound(all);
      SCOPED_TRACE(problem.spec().name + " " + objective);
      EXPECT_GE(priced, exact - 1e-9);
      EXPECT_LT(priced - exact, 0.5 * (blind - exact));
    }
  }
}

// Where the sets of a size are too many, that size is not listed, and what is listed is found.
TEST(SmallPieces, ListsTheSizesThatThereIsRoomFor) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Problem problem(random_product(seed, "time"));
    const TransitionSystem system(problem);
    Expander expander(system);
    std::vector<std::size_t> sets_up_to(kParts + 1, 0);
    for (unsigned bits = 1; bits < 1U << kParts; ++bits) {
      if (connected(problem, bits)) ++sets_up_to[parts_of(bits).size()];
    }
    for (std::size_t size = 1; size <= kParts; ++size) sets_up_to[size] += sets_up_to[size - 1];
    const SmallPieces some(system, expander, kParts, {}, {.most_sets = sets_up_to[4]});
    const SmallPieces up_to_four(system, expander, 4, {}, {});
    EXPECT_TRUE(some.more_could_be_listed());
    EXPECT_FALSE(
        SmallPieces(system, expander, SmallPieces::kMostListed, {}, {}).more_could_be_listed());
    for (unsigned bits = 1; bits < 1U << kParts; ++bits) {
      if (!connected(problem, bits)) continue;
      EXPECT_EQ(some.bound(parts_of(bits)), up_to_four.bound(parts_of(bits)));
    }
  }
}

// Prices say more than nothing: without them the bound of a product under `travel` is 0 where more
// than three parts may move, since no cut gains more.
TEST(SmallPieces, PricesTellWhatPlansCostAtLeast) {
  for (std::uint64_t seed = 0; seed < 60; seed += 3) {
    const Problem problem(random_product(seed, "travel"));
    const TransitionSystem system(problem);
    Expander expander(system);
    const std::vector<PartIndex> all = parts_of((1U << kParts) - 1);
    const double exact = SmallPieces(system, expander, SmallPieces::kMostListed, {}, {}).bound(all);
    const double priced = SmallPieces(system, expander, 5, {}, {}).bound(all);
    EXPECT_LT(priced, -1);
    EXPECT_GE(priced, exact - 1e-9);
    PieceBound used(system, PieceBound::Kind::Both);
    EXPECT_LT(used(system.start().view()), -1);
  }
}

// Of two listed sides only the larger one stays for nothing. In a row of nine parts at one place
// all cuts cost the same; with sets of up to four parts listed, parts cost at least 4/5 of a cut
// each. They would cost 2/3 if every set of three parts might stay for nothing.
TEST(SmallPieces, TheSideThatMovesPaysForItself) {
  ProblemSpec spec = random_product(0, "time");
  spec.connections.clear();
  for (std::size_t p = 0; p < kParts; ++p) {
    spec.parts[p].position = Vector3{1, 0, 0};
    if (p == 0) continue;
    Connection connection;
    connection.parts = {spec.parts[p - 1].id, spec.parts[p].id};
    spec.connections.push_back(connection);
  }
  const Problem problem(spec);
  const TransitionSystem system(problem);
  Expander expander(system);
  const std::vector<PartIndex> all = parts_of((1U << kParts) - 1);
  const double exact = SmallPieces(system, expander, SmallPieces::kMostListed, {}, {}).bound(all);
  const double cut = exact / (kParts - 1);
  const double priced = SmallPieces(system, expander, 4, {}, {}).bound(all);
  EXPECT_LE(priced, 7 * cut);
  EXPECT_GE(priced, 8 * cut - 1e-9);
}

}  // namespace
}  // namespace orasp
