#include "orasp/planners/detail/side_lister.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/formula_parser.h"
#include "orasp/model/random.h"
#include "orasp/orasp.h"
#include "orasp/planners/detail/and_or_search.h"
#include "tests/checks.h"
#include "tests/locked_products.h"

namespace orasp {
namespace {

using Set = detail::PartSet<1>;

std::vector<Set> neighbours_in(const Problem& problem) {
  std::vector<Set> neighbours(kPartsOfLocked);
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    neighbours[problem.ends(c)[0]].insert(problem.ends(c)[1]);
    neighbours[problem.ends(c)[1]].insert(problem.ends(c)[0]);
  }
  return neighbours;
}

bool connected(const Set& set, const std::vector<Set>& neighbours) {
  if (set.empty()) return false;
  Set reached;
  reached.insert(set.first());
  for (Set before; before != reached;) {
    before = reached;
    before.for_each([&](std::size_t p) { reached = reached | (neighbours[p] & set); });
  }
  return reached == set;
}

/// By the words of the file: some direction along which no part of `a` is blocked by one of `b`.
/// Two base parts never move, so that blocking does not matter between them.
bool can_leave(const ProblemSpec& spec, const Set& a, const Set& b) {
  if (!spec.blocking) return true;
  const auto number = [](const std::string& id) { return static_cast<std::size_t>(id[0] - 'a'); };
  bool base_in_a = false;
  bool base_in_b = false;
  for (const std::string& id : spec.base) {
    base_in_a = base_in_a || a.contains(number(id));
    base_in_b = base_in_b || b.contains(number(id));
  }
  if (base_in_a && base_in_b) return true;
  for (const BlockingDirection& direction : spec.blocking->directions) {
    std::string back = direction.id;
    back[0] = back[0] == '+' ? '-' : '+';
    bool free = true;
    for (const Blocked& blocked : spec.blocking->blocked) {
      const std::size_t part = number(blocked.part);
      const std::size_t by = number(blocked.by);
      for (const std::string& along : blocked.directions) {
        if (along == direction.id && a.contains(part) && b.contains(by)) free = false;
        if (along == back && a.contains(by) && b.contains(part)) free = false;
      }
    }
    if (free) return true;
  }
  return false;
}

// Of every piece every pair of connected sides of which one can leave the other comes once. With
// two base parts more may come, which who asks looks at again.
TEST(SideLister, ListsEachWayToPartAPieceOnce) {
  std::size_t ways = 0;
  std::size_t forbidden = 0;
  for (std::uint64_t seed = 0; seed < 120; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const ProblemSpec spec = locked_product(seed, "time");
    const Problem problem(spec);
    const std::vector<Set> neighbours = neighbours_in(problem);
    const detail::SideLister<1> sides(problem, neighbours);
    for (std::uint64_t bits = 1; bits < std::uint64_t{1} << kPartsOfLocked; ++bits) {
      const Set piece{{bits}};
      if (piece.size() < 2 || !connected(piece, neighbours)) continue;
      std::map<std::uint64_t, int> listed;
      sides.list(
          piece,
          [&](const Set& a, const Set& b) {
            ASSERT_EQ((a | b), piece);
            ASSERT_TRUE((a & b).empty());
            ASSERT_TRUE(a.contains(piece.first()));
            ++listed[a.words[0]];
          },
          [] { return false; });
      for (std::uint64_t side = bits; side != 0; side = (side - 1) & bits) {
        const Set a{{side}};
        const Set b = piece - a;
        if (!a.contains(piece.first()) || !connected(a, neighbours) || !connected(b, neighbours)) {
          ASSERT_EQ(listed.count(side), 0U);
          continue;
        }
        const bool legal = can_leave(spec, a, b);
        ways += legal ? 1 : 0;
        forbidden += legal ? 0 : 1;
        if (legal) {
          ASSERT_EQ(listed[side], 1);
        } else if (spec.base.size() < 2) {
          ASSERT_EQ(listed.count(side), 0U);
        }
      }
    }
  }
  EXPECT_GT(ways, 10'000U);
  EXPECT_GT(forbidden, 1'000U);
}

TEST(SideLister, StopsWhenItIsTold) {
  const Problem problem(locked_product(0, "time"));
  const std::vector<Set> neighbours = neighbours_in(problem);
  const detail::SideLister<1> sides(problem, neighbours);
  std::size_t offered = 0;
  sides.list(
      Set{{(std::uint64_t{1} << kPartsOfLocked) - 1}}, [&](const Set&, const Set&) { ++offered; },
      [&] { return offered >= 3; });
  EXPECT_EQ(offered, 3U);
}

// Of every piece the legal cuts that lose little enough, each with what it loses by the definition.
TEST(CutLister, ListsTheCutsWithinALimitWithWhatTheyLose) {
  std::size_t listed = 0;
  std::size_t beyond = 0;
  for (const char* objective : {"time", "travel"}) {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
      SCOPED_TRACE(std::string(objective) + ", seed " + std::to_string(seed));
      const Problem problem(locked_product(seed, objective));
      const TransitionSystem system(problem);
      const detail::PieceProblem pieces(system, std::make_shared<const PieceGains>(system));
      const std::vector<Set> neighbours = neighbours_in(problem);
      detail::CutLister<1> lister(pieces, 0);
      if (lister.links().along_forest) continue;
      detail::CutLister<1> other(pieces, 0);
      detail::CutLister<1>::List list;
      for (std::uint64_t bits = 1; bits < std::uint64_t{1} << kPartsOfLocked; ++bits) {
        const Set piece{{bits}};
        if (piece.size() < 2 || !connected(piece, neighbours)) continue;
        const double here = other.upper(piece, piece.size());
        std::map<std::uint64_t, double> losses;
        for (std::uint64_t side = bits; side != 0; side = (side - 1) & bits) {
          const Set a{{side}};
          const Set b = piece - a;
          if (!a.contains(piece.first()) || !connected(a, neighbours) || !connected(b, neighbours))
            continue;
          const auto gain = other.gain(piece, a, b, a.size(), b.size());
          if (!gain) continue;
          losses[side] = here - *gain - other.upper(a, a.size()) - other.upper(b, b.size());
        }
        if (losses.empty()) continue;
        double middle = 0;
        for (const auto& [side, loss] : losses) middle += loss / static_cast<double>(losses.size());
        for (const double limit : {kInfinity, middle}) {
          lister.list(piece, here, limit, list, [] { return false; });
          ASSERT_TRUE(list.complete);
          double skipped = kInfinity;
          std::size_t within = 0;
          for (const auto& [side, loss] : losses) {
            within += loss <= limit ? 1 : 0;
            if (loss > limit) skipped = std::min(skipped, loss);
          }
          ASSERT_EQ(list.cuts.size(), within);
          ASSERT_EQ(list.skipped, skipped);
          listed += within;
          beyond += losses.size() - within;
          for (const auto& cut : list.cuts) {
            ASSERT_EQ((cut.side | cut.rest), piece);
            const auto found = losses.find(cut.side.words[0]);
            ASSERT_NE(found, losses.end());
            ASSERT_EQ(cut.own_loss, found->second);
            ASSERT_EQ(cut.rest_bound, other.upper(cut.rest, cut.rest.size()));
          }
        }
      }
    }
  }
  EXPECT_GT(listed, 10'000U);
  EXPECT_GT(beyond, 1'000U);
}

/// All parts are connected to all others, and nothing blocks.
ProblemSpec complete_product(std::size_t parts) {
  ProblemSpec spec = locked_product(0, "time", parts);
  spec.connections.clear();
  for (std::size_t a = 0; a < parts; ++a) {
    for (std::size_t b = a + 1; b < parts; ++b) {
      Connection connection;
      connection.id = std::to_string(spec.connections.size());
      connection.parts = {spec.parts[a].id, spec.parts[b].id};
      spec.connections.push_back(connection);
    }
  }
  return spec;
}

TEST(CutLister, SaysWhereItIsNotComplete) {
  for (const std::size_t parts : {13U, 16U}) {
    const Problem problem(complete_product(parts));
    const TransitionSystem system(problem);
    const detail::PieceProblem pieces(system, std::make_shared<const PieceGains>(system));
    detail::CutLister<1> lister(pieces, 0);
    detail::CutLister<1>::List list;
    const Set all{{(std::uint64_t{1} << parts) - 1}};
    lister.list(all, 0, kInfinity, list, [] { return true; });
    EXPECT_FALSE(list.complete);
    lister.list(all, 0, kInfinity, list, [] { return false; });
    EXPECT_EQ(list.complete, parts == 13);  // the others have 32,767 ways
    if (parts == 13) {
      EXPECT_EQ(list.cuts.size(), (std::size_t{1} << 12U) - 1);
    }
  }
}

// Whole proofs against value iteration on all states, in both directions.
TEST(AndOr, AgreesWithValueIterationOnProductsThatLockThemselves) {
  std::size_t solved = 0;
  for (const char* objective : {"time", "travel"}) {
    for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
      for (std::uint64_t seed = 0; seed < 60; ++seed) {
        SCOPED_TRACE(std::string(objective) + ", seed " + std::to_string(seed));
        ProblemSpec spec = locked_product(seed, objective);
        spec.direction = direction;
        const Problem problem(spec);
        const TransitionSystem system(problem);
        const Result truth = value_iteration(system, {}, Budget{});
        const Result found = and_or(system, {}, Budget{});
        ASSERT_EQ(status_name(found.status), status_name(truth.status));
        if (truth.status != Status::Optimal) continue;
        ++solved;
        ASSERT_NEAR(found.reward, truth.reward, 1e-9 * std::max(1.0, std::abs(truth.reward)));
        ASSERT_TRUE(evaluate(problem, found.sequence).valid);
      }
    }
  }
  EXPECT_GT(solved, 80U);
}

// In turns, the bound of each holds, and none is lost. To know the best plan changes nothing.
TEST(AndOr, KeepsWhatItProvedBetweenTurns) {
  std::size_t turns_taken = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Problem problem(locked_product(seed, "travel"));
    const TransitionSystem system(problem);
    const Result truth = value_iteration(system, {}, Budget{});
    if (truth.status != Status::Optimal) continue;
    const Result some = random_sequence(system, {.seed = 1}, Budget{});
    for (const Result& known : {Result{}, truth, some}) {
      const Budget budget;
      AndOrTurns turns(system, budget);
      double before = kInfinity;
      for (bool done = false; !done; ++turns_taken) {
        const Result result = turns.next(1, known);
        ASSERT_TRUE(result.bound.has_value());
        ASSERT_GE(*result.bound, truth.reward - 1e-9);
        ASSERT_LE(*result.bound, before);
        before = *result.bound;
        done = result.stop == Stop::None;
      }
      ASSERT_NEAR(before, truth.reward, 1e-9);
    }
  }
  EXPECT_GE(turns_taken, 60U);
}

// Runs of a few expansions each: the bound of each holds and is no worse than the one before. With
// the best plan known, that nothing is better is proved by looking at less.
TEST(AndOr, GoesOnWhereARunEndedAndNeedNotFindAPlanThatIsKnown) {
  std::uint64_t looked = 0;
  std::uint64_t looked_with_plan = 0;
  for (const char* objective : {"time", "travel"}) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      SCOPED_TRACE(std::string(objective) + ", seed " + std::to_string(seed));
      const Problem problem(locked_product(seed, objective, 15));
      const TransitionSystem system(problem);
      const Result truth = value_iteration(system, {}, Budget{});
      if (truth.status != Status::Optimal) continue;
      const detail::PieceProblem pieces(system, std::make_shared<const PieceGains>(system));
      const Budget budget;
      const double least = 1e-9 * std::max(1.0, std::abs(truth.reward));
      for (const double known : {-kInfinity, truth.reward - 0.1, truth.reward}) {
        Result spent;
        detail::AndOrSearch<1> search(pieces, 0, budget, spent);
        search.know_plan(known);
        double before = kInfinity;
        bool done = false;
        for (std::size_t runs = 0; runs < 10'000 && !done; ++runs) {
          done = search.run(3, 1'000'000);
          ASSERT_GE(*spent.bound, truth.reward - least);
          ASSERT_LE(*spent.bound, before + least);
          before = *spent.bound;
        }
        ASSERT_TRUE(done);
        ASSERT_NEAR(before, truth.reward, least);
        (known == truth.reward ? looked_with_plan : looked) += spent.statistics.generated;
        if (known == truth.reward) continue;
        const Evaluation found = evaluate(problem, search.sequence(false));
        ASSERT_TRUE(found.valid);
        ASSERT_NEAR(found.reward, truth.reward, least);
      }
    }
  }
  EXPECT_GT(looked_with_plan, 0U);
  EXPECT_LT(2 * looked_with_plan, looked);
}

// Where few small pieces are listed, prices say most of what is known of a piece before its cuts
// are looked at. The best plan is found all the same, at once and in runs of a few expansions.
TEST(AndOr, FindsTheBestPlanWherePiecesArePriced) {
  std::size_t solved = 0;
  for (const char* objective : {"time", "travel"}) {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
      SCOPED_TRACE(std::string(objective) + ", seed " + std::to_string(seed));
      ProblemSpec spec = locked_product(seed, objective, 12);
      if (seed % 4 == 2) spec.limits.max_moved_mass = 2.5;
      const Problem problem(spec);
      const TransitionSystem system(problem);
      const Result truth = value_iteration(system, {}, Budget{});
      const std::size_t listed = 12 + 8 * (seed % 5);
      const detail::PieceProblem pieces(
          system, std::make_shared<const PieceGains>(system, ListingEffort{.most_sets = listed}));
      const Budget budget;
      for (const std::uint64_t expansions : {std::uint64_t{3}, std::uint64_t{1'000'000}}) {
        Result spent;
        detail::AndOrSearch<1> search(pieces, 0, budget, spent);
        bool done = false;
        for (std::size_t runs = 0; runs < 10'000 && !done; ++runs) {
          done = search.run(expansions, 1'000'000);
          ASSERT_GE(*spent.bound, truth.reward - 1e-9 * std::max(1.0, std::abs(truth.reward)));
        }
        ASSERT_TRUE(done);
        if (truth.status != Status::Optimal) {
          ASSERT_EQ(*spent.bound, -kInfinity);
          continue;
        }
        ASSERT_NEAR(*spent.bound, truth.reward, 1e-9 * std::max(1.0, std::abs(truth.reward)));
        const Evaluation found = evaluate(problem, search.sequence(false));
        ASSERT_TRUE(found.valid);
        ASSERT_NEAR(found.reward, truth.reward, 1e-9 * std::max(1.0, std::abs(truth.reward)));
        ++solved;
      }
    }
  }
  EXPECT_GE(solved, 100U);
}

// A window may hold all of eight parts, so that from any plan the best one is found.
TEST(AndOr, CutsAPlanAnewInTheBestWayThereIs) {
  std::size_t better = 0;
  for (const char* objective : {"time", "travel"}) {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
      SCOPED_TRACE(std::string(objective) + ", seed " + std::to_string(seed));
      const Problem problem(locked_product(seed, objective));
      const TransitionSystem system(problem);
      const Result truth = value_iteration(system, {}, Budget{});
      if (truth.status != Status::Optimal) continue;
      const Result start = random_sequence(system, {.seed = seed}, Budget{});
      if (!start.has_plan()) continue;
      const detail::PieceProblem pieces(system, std::make_shared<const PieceGains>(system));
      const Budget budget;
      Result spent;
      detail::AndOrSearch<1> search(pieces, 0, budget, spent);
      const double least = 1e-9 * std::max(1.0, std::abs(truth.reward));
      if (!search.recut(start.sequence, 100'000, seed)) {
        ASSERT_NEAR(start.reward, truth.reward, least);
        continue;
      }
      const Evaluation found = evaluate(problem, search.sequence(false));
      ASSERT_TRUE(found.valid);
      ASSERT_NEAR(found.reward, truth.reward, least);
      ++better;
    }
  }
  EXPECT_GT(better, 60U);
}

// While a plan is made better on one thread the search goes on on the other.
TEST(AndOr, MakesAPlanBetterBesideTheSearchWithTheSameAnswer) {
  std::size_t open = 0;
  for (const std::uint64_t seed : {1U, 5U}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Problem problem(locked_product(seed, "time", 30));
    const TransitionSystem system(problem);
    Budget budget;
    const Result one = and_or(system, {.rounds = 2}, budget);
    budget.threads = 2;
    const Result two = and_or(system, {.rounds = 2}, budget);
    EXPECT_EQ(one.sequence, two.sequence);
    EXPECT_EQ(one.bound, two.bound);
    EXPECT_EQ(one.statistics.expanded, two.statistics.expanded);
    if (one.status == Status::Feasible) ++open;
    ASSERT_TRUE(evaluate(problem, one.sequence).valid);
  }
  EXPECT_GT(open, 0U);
}

// A hub with chains of equal length on it: no cut takes more than a chain off it, which sizes alone
// do not know. By hand for three chains of two parts: 7 + 5 + 3, and 2 for each chain.
TEST(AndOr, KnowsThatNoCutTakesMoreThanAChainOffAHub) {
  const auto hub = [](std::size_t chains, std::size_t length) {
    ProblemSpec spec;
    spec.name = "hub";
    spec.parts.push_back({.id = "hub"});
    for (std::size_t chain = 0; chain < chains; ++chain) {
      for (std::size_t i = 0; i < length; ++i) {
        const std::string id = std::to_string(chain) + "." + std::to_string(i);
        const std::string before =
            i == 0 ? "hub" : std::to_string(chain) + "." + std::to_string(i - 1);
        spec.parts.push_back({.id = id});
        Connection connection;
        connection.parts = {before, id};
        spec.connections.push_back(connection);
      }
    }
    spec.objective = {"expression", Expression{.formula = "-separates*(moved_parts+kept_parts)",
                                               .constants = {},
                                               .depot = {},
                                               .compiler = compile_formula}};
    return Problem(spec);
  };
  const Problem small = hub(3, 2);
  const Result result = and_or(TransitionSystem(small), {}, Budget{});
  EXPECT_EQ(status_name(result.status), "optimal");
  EXPECT_EQ(result.reward, -(7 + 5 + 3 + 3 * 2));
  // Six chains of 21: 127 + 106 + 85 + 64 for the first four, and 94 for each of them; the hub is
  // then in the middle of a chain of 43, which costs 237.
  const Problem large = hub(6, 21);
  const Result halved = and_or(TransitionSystem(large), {.rounds = 1}, Budget{});
  EXPECT_EQ(status_name(halved.status), "optimal");
  EXPECT_EQ(halved.reward, -(127 + 106 + 85 + 64 + 4 * 94 + 237));
}

}  // namespace
}  // namespace orasp
