// Symmetry against brute force: what is taken for one is worth the same, in every state of hundreds
// of problems with planted symmetries, and every method finds the same optimum with it and without.

#include "orasp/symmetry/symmetry.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/explain/alternatives.h"
#include "orasp/io/formula_parser.h"
#include "orasp/model/random.h"
#include "tests/checks.h"
#include "tests/fault.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"
#include "tests/symmetry/symmetric_problems.h"
#include "tests/wide_oracle.h"

namespace orasp {
namespace {

constexpr std::uint64_t kSeeds = 600;

bool has_nauty() {
  return !automorphism_finder_obstacle();
}

ConnectionSet form_of(OrbitForm& form, const ConnectionSet& set) {
  std::vector<std::uint64_t> words(set.view().begin(), set.view().end());
  form.canonical(words);
  return {set.universe(), words};
}

// -------------------------------------------------------------------------------------------------
// Forms of sets under groups that are given.

/// All elements of a group on a few points.
std::set<Permutation> closure(const std::vector<Permutation>& generators, std::size_t points) {
  Permutation identity(points);
  std::iota(identity.begin(), identity.end(), 0U);
  std::set<Permutation> all{identity};
  std::vector<Permutation> queue{identity};
  for (std::size_t i = 0; i < queue.size(); ++i) {
    for (const Permutation& g : generators) {
      Permutation next(points);
      for (std::size_t p = 0; p < points; ++p) next[p] = g[queue[i][p]];
      if (all.insert(next).second) queue.push_back(next);
    }
  }
  return all;
}

std::uint64_t image(const Permutation& g, std::uint64_t set) {
  std::uint64_t moved = 0;
  for (std::size_t p = 0; p < g.size(); ++p) {
    if ((set >> p & 1U) != 0) moved |= std::uint64_t{1} << g[p];
  }
  return moved;
}

/// The form of every set is one of its orbit, the number of forms is what `saving` says, and where
/// all of the group is used, each orbit has one form.
void expect_forms(const std::vector<Permutation>& generators, std::size_t points, bool whole) {
  const std::set<Permutation> group = closure(generators, points);
  OrbitForm form(points, generators);
  double order = 1;
  for (const std::uint64_t factor : form.order()) order *= static_cast<double>(factor);
  EXPECT_EQ(static_cast<std::size_t>(std::fmod(static_cast<double>(group.size()), order)), 0U);
  if (whole) {
    EXPECT_EQ(static_cast<double>(group.size()), order);
  }
  std::set<std::uint64_t> forms;
  std::set<std::uint64_t> orbits;
  for (std::uint64_t set = 0; set < std::uint64_t{1} << points; ++set) {
    std::uint64_t found = set;
    form.canonical({&found, 1});
    forms.insert(found);
    bool in_orbit = false;
    std::uint64_t least = set;
    for (const Permutation& g : group) {
      const std::uint64_t other = image(g, set);
      in_orbit = in_orbit || other == found;
      least = std::min(least, other);
    }
    EXPECT_TRUE(in_orbit);
    orbits.insert(least);
    std::uint64_t again = found;
    form.canonical({&again, 1});
    EXPECT_EQ(again, found);
    for (std::size_t p = 0; p < points; ++p) {
      if ((found >> p & 1U) == 0) continue;
      std::uint64_t one = found & ~(std::uint64_t{1} << p);
      std::uint64_t other = one;
      form.canonical({&one, 1});
      form.canonical_but_for(p, {&other, 1});
      EXPECT_EQ(one, other);
    }
  }
  EXPECT_NEAR(form.saving(), std::exp2(points) / static_cast<double>(forms.size()),
              1e-6 * form.saving());
  if (order == static_cast<double>(group.size())) {
    EXPECT_EQ(forms.size(), orbits.size());
  }
}

Permutation exchange(std::size_t points, const std::vector<std::uint32_t>& block,
                     const std::vector<std::uint32_t>& other) {
  Permutation g(points);
  std::iota(g.begin(), g.end(), 0U);
  for (std::size_t i = 0; i < block.size(); ++i) {
    g[block[i]] = other[i];
    g[other[i]] = block[i];
  }
  return g;
}

TEST(OrbitForm, EqualPointsAreCounted) {
  expect_forms({exchange(6, {0}, {3}), exchange(6, {3}, {5}), exchange(6, {1}, {2})}, 6, true);
}

TEST(OrbitForm, EqualBlocksAreSorted) {
  expect_forms({exchange(9, {0, 4}, {2, 7}), exchange(9, {2, 7}, {8, 1}), exchange(9, {3}, {5})}, 9,
               true);
}

TEST(OrbitForm, BlocksOfEqualPointsAreSortedInside) {
  // Three blocks of three, in each of which two points are equal.
  expect_forms(
      {exchange(9, {0, 1, 2}, {3, 4, 5}), exchange(9, {3, 4, 5}, {6, 7, 8}), exchange(9, {4}, {5})},
      9, true);
  // Two blocks, one exchange alone.
  expect_forms({exchange(8, {0, 1, 2, 3}, {4, 5, 6, 7}), exchange(8, {1}, {2})}, 8, true);
}

TEST(OrbitForm, RingsAndGridsTakeTheLeastImage) {
  Permutation turn(8);
  Permutation flip(8);
  for (std::uint32_t p = 0; p < 8; ++p) {
    turn[p] = (p + 1) % 8;
    flip[p] = (8 - p) % 8;
  }
  expect_forms({turn, flip}, 8, true);
  expect_forms({turn}, 8, true);
}

// What is in a table whose rows and columns may each be put in any order.
TEST(OrbitForm, TablesAreSortedByColumnsForEachOrderOfRows) {
  const auto table = [](std::uint32_t rows, std::uint32_t columns, bool heads) {
    std::vector<Permutation> generators;
    const std::uint32_t points = rows * columns + (heads ? columns : 0);
    const auto at = [&](std::uint32_t r, std::uint32_t c) { return r * columns + c; };
    for (std::uint32_t r = 0; r + 1 < rows; ++r) {
      std::vector<std::uint32_t> one;
      std::vector<std::uint32_t> other;
      for (std::uint32_t c = 0; c < columns; ++c) {
        one.push_back(at(r, c));
        other.push_back(at(r + 1, c));
      }
      generators.push_back(exchange(points, one, other));
    }
    for (std::uint32_t c = 0; c + 1 < columns; ++c) {
      std::vector<std::uint32_t> one;
      std::vector<std::uint32_t> other;
      for (std::uint32_t r = 0; r < rows + (heads ? 1 : 0); ++r) {
        one.push_back(at(r, c));
        other.push_back(at(r, c + 1));
      }
      generators.push_back(exchange(points, one, other));
    }
    return generators;
  };
  expect_forms(table(3, 3, false), 9, true);
  expect_forms(table(2, 4, true), 12, true);
  expect_forms(table(3, 3, true), 12, true);
  // Two such tables that may be exchanged.
  std::vector<Permutation> two;
  std::vector<std::uint32_t> one(6);
  std::vector<std::uint32_t> other(6);
  std::iota(one.begin(), one.end(), 0U);
  std::iota(other.begin(), other.end(), 6U);
  for (Permutation g : table(2, 3, false)) {
    for (std::uint32_t p = 6; p < 12; ++p) g.push_back(p);
    two.push_back(g);
  }
  two.push_back(exchange(12, one, other));
  expect_forms(two, 12, true);
}

TEST(OrbitForm, OfALargeGroupOfAnotherKindAPartIsUsed) {
  // All permutations of seven things, acting on pairs of them: 5,040 elements.
  std::vector<std::array<std::uint32_t, 2>> pairs;
  for (std::uint32_t a = 0; a < 7; ++a) {
    for (std::uint32_t b = a + 1; b < 7; ++b) pairs.push_back({a, b});
  }
  std::vector<Permutation> generators;
  for (std::uint32_t i = 0; i + 1 < 7; ++i) {
    Permutation g;
    for (auto pair : pairs) {
      for (std::uint32_t& end : pair) end = end == i ? i + 1 : end == i + 1 ? i : end;
      std::ranges::sort(pair);
      g.push_back(static_cast<std::uint32_t>(std::ranges::find(pairs, pair) - pairs.begin()));
    }
    generators.push_back(g);
  }
  OrbitForm form(pairs.size(), generators);
  double order = 1;
  for (const std::uint64_t factor : form.order()) order *= static_cast<double>(factor);
  EXPECT_GE(order, 24);
  EXPECT_LE(order, 5040);
}

TEST(OrbitForm, LongBlocksAreSortedToo) {
  constexpr std::size_t kLength = 70;
  std::vector<std::uint32_t> one(kLength);
  std::vector<std::uint32_t> other(kLength);
  std::vector<std::uint32_t> third(kLength);
  for (std::uint32_t i = 0; i < kLength; ++i) {
    one[i] = 3 * i;
    other[i] = 3 * i + 1;
    third[i] = 3 * i + 2;
  }
  const std::size_t points = 3 * kLength;
  OrbitForm form(points, {exchange(points, one, other), exchange(points, other, third)});
  SplitMix64 random(5);
  for (int i = 0; i < 200; ++i) {
    ConnectionSet set(points);
    ConnectionSet moved(points);
    const std::size_t shift = 1 + static_cast<std::size_t>(random.below(2));
    for (std::size_t p = 0; p < points; ++p) {
      if (random.uniform() < 0.5) continue;
      set.insert(static_cast<ConnectionIndex>(p));
      moved.insert(static_cast<ConnectionIndex>(p / 3 * 3 + (p % 3 + shift) % 3));
    }
    EXPECT_EQ(form_of(form, set), form_of(form, moved));
    EXPECT_EQ(form_of(form, set).size(), set.size());
  }
}

TEST(OrbitForm, RandomGroups) {
  SplitMix64 random(17);
  for (int i = 0; i < 150; ++i) {
    SCOPED_TRACE(i);
    const std::size_t points = 4 + static_cast<std::size_t>(random.below(4));
    std::vector<Permutation> generators;
    for (std::uint64_t k = 1 + random.below(3); k > 0; --k) {
      // Products of exchanges, or of cycles.
      Permutation g(points);
      std::iota(g.begin(), g.end(), 0U);
      for (std::uint64_t swaps = 1 + random.below(3); swaps > 0; --swaps)
        std::swap(g[random.below(points)], g[random.below(points)]);
      generators.push_back(g);
    }
    expect_forms(generators, points, false);
    if (HasFailure()) return;
  }
}

// -------------------------------------------------------------------------------------------------
// Problems.

/// The rewards of the legal steps of a state, sorted.
std::vector<double> step_rewards(const oracle::World& world, const oracle::State& open) {
  std::vector<double> rewards;
  for (const oracle::Facts& facts : world.legal_facts(open)) rewards.push_back(facts.reward);
  std::ranges::sort(rewards);
  return rewards;
}

/// Brute force; by that which knows bases where there is one.
oracle::OracleResult truth_of(const ProblemSpec& spec) {
  if (spec.base.empty()) return oracle::brute_force(spec);
  const oracle::WideResult wide = oracle::wide_brute_force(spec);
  oracle::OracleResult truth;
  truth.feasible = wide.best.has_value();
  if (wide.best) truth.best = *wide.best;
  for (const auto& [state, best] : wide.best_to_go) truth.best_to_go[state.first] = best;
  return truth;
}

void expect_equal_worth(const ProblemSpec& spec, const Symmetry& symmetry,
                        const oracle::OracleResult& truth) {
  OrbitForm form = symmetry.form();
  const oracle::World world(spec);
  const std::size_t connections = spec.connections.size();
  for (const auto& [state, best] : truth.best_to_go) {
    const ConnectionSet stands = form_of(form, oracle::set_of(state));
    const oracle::State other = oracle::state_of(stands.view(), connections);
    ASSERT_TRUE(truth.best_to_go.contains(other)) << "a state stands for it that is not reached";
    const double best_there = truth.best_to_go.at(other);
    ASSERT_EQ(std::isfinite(best), std::isfinite(best_there));
    if (std::isfinite(best)) {
      ASSERT_NEAR(best, best_there, reward_tolerance(best));
    }
    if (!spec.base.empty()) continue;
    const std::vector<double> here = step_rewards(world, state);
    const std::vector<double> there = step_rewards(world, other);
    ASSERT_EQ(here.size(), there.size());
    for (std::size_t i = 0; i < here.size(); ++i)
      ASSERT_NEAR(here[i], there[i], reward_tolerance(here[i]));
  }
}

TEST(Symmetry, StatesThatStandForOneAnotherAreWorthTheSame) {
  if (!has_nauty()) GTEST_SKIP() << "built without nauty";
  int used = 0;
  int refused = 0;
  int many = 0;
  double greatest = 1;
  const auto look_at = [&](const ProblemSpec& spec) {
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    const Symmetry symmetry(system);
    if (symmetry.obstacle()) ++refused;
    if (symmetry.trivial()) return false;
    greatest = std::max(greatest, symmetry.order());
    expect_equal_worth(spec, symmetry, truth_of(spec));
    return true;
  };
  for (std::uint64_t seed = 0; seed < some_of(kSeeds); ++seed) {
    const ProblemSpec spec = symmetric_problem(seed);
    used += look_at(spec) ? 1 : 0;
    // Of 66 directions and more each stays what it is.
    if (seed % 2 == 0 && spec.blocking && !spec.blocking->directions.empty())
      many += look_at(with_named_directions(spec, 33)) ? 1 : 0;
    if (HasFailure()) return;
  }
  EXPECT_GE(used, least_of(400));
  EXPECT_GE(refused, least_of(5));
  EXPECT_GE(many, least_of(50));
  EXPECT_GE(greatest, least_of(700));
}

TEST(Symmetry, RandomProblemsOfEveryKindAreSafe) {
  if (!has_nauty()) GTEST_SKIP() << "built without nauty";
  int used = 0;
  for (std::uint64_t seed = 0; seed < some_of(std::uint64_t{1500}); ++seed) {
    const ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    const Symmetry symmetry(system);
    if (symmetry.trivial()) continue;
    ++used;
    expect_equal_worth(spec, symmetry, truth_of(spec));
    if (HasFailure()) return;
  }
  EXPECT_GE(used, least_of(20));
}

constexpr std::array<const char*, 6> kMethods = {"value-iteration", "dijkstra", "bellman-ford",
                                                 "orasp-search",    "a-star",   "beam"};

Options with(SymmetryUse use) {
  Options options;
  options.symmetry = use;
  return options;
}

TEST(Symmetry, EveryMethodFindsTheSameOptimumWithIt) {
  if (!has_nauty()) GTEST_SKIP() << "built without nauty";
  int solved = 0;
  for (std::uint64_t seed = 0; seed < some_of(kSeeds); ++seed) {
    const ProblemSpec spec = symmetric_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const oracle::OracleResult truth = truth_of(spec);
    for (const char* const method : kMethods) {
      SCOPED_TRACE(method);
      if (const auto reason = obstacle(problem, method, with(SymmetryUse::On))) {
        const std::string fault =
            fault_of([&] { return solve(problem, method, with(SymmetryUse::On)); });
        if (truth.feasible || fault != "no fault") {
          EXPECT_EQ(fault, *reason);
        }
        continue;
      }
      const Result result = solve(problem, method, with(SymmetryUse::On));
      if (spec.base.empty()) {
        expect_honest(problem, truth, find_planner(method), result);
      } else if (truth.feasible) {
        EXPECT_NEAR(result.reward, truth.best, reward_tolerance(truth.best));
        EXPECT_TRUE(evaluate(problem, std::span<const ConnectionIndex>(result.sequence)).valid);
      }
      EXPECT_EQ(result.status, truth.feasible ? Status::Optimal : Status::Infeasible);
      Budget two_threads;
      two_threads.threads = 2;
      expect_same_answer(result, solve(problem, method, with(SymmetryUse::On), two_threads));
      const Result without = solve(problem, method, with(SymmetryUse::Off));
      EXPECT_LE(result.statistics.states, without.statistics.states == 0
                                              ? result.statistics.states
                                              : without.statistics.states);
      ++solved;
    }
    if (HasFailure()) return;
  }
  EXPECT_GE(solved, least_of(2500));
}

// Of `and-or`, which searches one of the pieces that an exchange takes into one another.
TEST(Symmetry, PiecesThatStandForOneAnotherAreWorthTheSame) {
  if (!has_nauty()) GTEST_SKIP() << "built without nauty";
  int used = 0;
  int proved = 0;
  int fewer = 0;
  int proved_without = 0;
  for (std::uint64_t seed = 0; seed < some_of(2 * kSeeds); ++seed) {
    ProblemSpec spec = symmetric_problem(seed / 2);
    spec.direction = seed % 2 == 0 ? Direction::Disassembly : Direction::Assembly;
    SCOPED_TRACE(spec.name + " " + std::to_string(seed));
    const Problem problem(spec);
    if (obstacle(problem, "and-or", with(SymmetryUse::On))) continue;
    const oracle::OracleResult truth = truth_of(spec);
    const Result result = solve(problem, "and-or", with(SymmetryUse::On));
    const Result without = solve(problem, "and-or", with(SymmetryUse::Off));
    if (spec.base.empty()) expect_honest(problem, truth, find_planner("and-or"), result);
    if (!truth.feasible) {
      EXPECT_FALSE(result.has_plan());
      continue;
    }
    ASSERT_NE(result.status, Status::Infeasible);
    ASSERT_TRUE(result.bound.has_value());
    EXPECT_GE(*result.bound, truth.best - reward_tolerance(truth.best));
    EXPECT_NEAR(*result.bound, *without.bound, reward_tolerance(truth.best));
    if (result.status == Status::Optimal) {
      EXPECT_NEAR(result.reward, truth.best, reward_tolerance(truth.best));
      EXPECT_TRUE(evaluate(problem, std::span<const ConnectionIndex>(result.sequence)).valid);
      ++proved;
    }
    proved_without += without.status == Status::Optimal ? 1 : 0;
    used += result.notes.empty() ? 0 : 1;
    fewer += result.statistics.states < without.statistics.states ? 1 : 0;
    if (HasFailure()) return;
  }
  EXPECT_GE(used, least_of(500));
  EXPECT_GE(fewer, least_of(300));
  EXPECT_GE(proved, proved_without - least_of(10));
}

// Three equal cars, whose cuts no bound by sizes tells the best of.
TEST(Symmetry, EqualPiecesAreSearchedOnce) {
  if (!has_nauty()) GTEST_SKIP() << "built without nauty";
  ProblemSpec spec;
  spec.parts.push_back({.id = "jig"});
  const auto add = [&](const std::string& on, const std::string& id, double duration) {
    spec.parts.push_back({.id = id});
    Connection connection;
    connection.parts = {on, id};
    connection.duration = duration;
    spec.connections.push_back(connection);
  };
  for (const std::string car : {"a", "b", "c"}) {
    add("jig", car, 2);
    for (const std::string wheel : {"1", "2", "3"}) {
      add(car, car + wheel, 1);
      add(car + wheel, car + wheel + "n", 0.5);
    }
  }
  spec.objective.type = "expression";
  spec.objective.parameters =
      Expression{.formula = "-abs(moved_parts - 4) - 0.1 * duration * kept_parts",
                 .compiler = compile_formula};
  spec.limits.max_subassemblies = 2;
  const Problem problem(spec);
  const Result result = solve(problem, "and-or", with(SymmetryUse::On));
  const Result without = solve(problem, "and-or", with(SymmetryUse::Off));
  EXPECT_EQ(result.status, Status::Optimal);
  EXPECT_EQ(without.status, Status::Optimal);
  EXPECT_NEAR(result.reward, without.reward, reward_tolerance(without.reward));
  EXPECT_LE(20 * result.statistics.states, without.statistics.states);  // 563 and 43,513
}

TEST(Symmetry, TheSameInTheMiddleOfTheWorkAndWithRetries) {
  if (!has_nauty()) GTEST_SKIP() << "built without nauty";
  int used = 0;
  SplitMix64 random(3);
  for (std::uint64_t seed = 0; seed < some_of(kSeeds); ++seed) {
    ProblemSpec spec = symmetric_problem(seed);
    if (seed % 3 == 0) {
      for (Connection& connection : spec.connections)
        connection.success = connection.duration > 1 ? 0.5 : 0.8;
      if (seed % 2 == 0) spec.connections.front().success = 0.9;
    }
    const Problem problem(spec);
    SCOPED_TRACE(spec.name);
    // A few steps from the start, and now and then something that stays or comes late.
    Situation now = Situation::whole(problem.num_connections());
    if (seed % 3 != 0) {
      const TransitionSystem system(problem);
      Expander expander(system);
      for (std::uint64_t steps = random.below(3); steps > 0; --steps) {
        const auto legal = expander.legal_actions(now.open.view());
        if (legal.empty() || now.open.size() < 2) break;
        now.open.erase(legal[static_cast<std::size_t>(random.below(legal.size()))].connection);
      }
      const auto any = [&] {
        return static_cast<ConnectionIndex>(random.below(problem.num_connections()));
      };
      if (random.below(3) == 0) now.inaccessible.insert(any());
      if (random.below(6) == 0) now.late.insert(any());
      if (random.below(6) == 0) now.not_next.insert(any());
    }
    const Task task(problem, now);
    for (const char* const method : {"dijkstra", "orasp-search", "a-star", "beam"}) {
      SCOPED_TRACE(method);
      if (obstacle(task, method, with(SymmetryUse::On))) continue;
      const Result result = solve(task, method, with(SymmetryUse::On));
      const Result without = solve(task, method, with(SymmetryUse::Off));
      EXPECT_EQ(result.status, without.status);
      if (without.has_plan()) {
        EXPECT_NEAR(result.reward, without.reward, reward_tolerance(without.reward));
      }
      used += result.notes.empty() ? 0 : 1;
    }
    if (HasFailure()) return;
  }
  EXPECT_GE(used, least_of(300));
}

// What is left of a search that was stopped is an honest plan and a true bound.
TEST(Symmetry, StoppedSearchesStayHonest) {
  if (!has_nauty()) GTEST_SKIP() << "built without nauty";
  for (std::uint64_t seed = 0; seed < some_of(kSeeds / 2); ++seed) {
    const ProblemSpec spec = symmetric_problem(seed);
    if (!spec.base.empty()) continue;
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const oracle::OracleResult truth = truth_of(spec);
    for (const char* const method : {"dijkstra", "orasp-search", "a-star", "beam", "and-or"}) {
      SCOPED_TRACE(method);
      if (obstacle(problem, method, with(SymmetryUse::On))) continue;
      for (const std::uint64_t most : {1, 5, 20}) {
        Budget budget;
        budget.max_expansions = most;
        expect_honest(problem, truth, find_planner(method),
                      solve(problem, method, with(SymmetryUse::On), budget));
      }
    }
    if (HasFailure()) return;
  }
}

TEST(Symmetry, SequencesUpToSymmetryAreThoseOfBruteForce) {
  if (!has_nauty()) GTEST_SKIP() << "built without nauty";
  int counted = 0;
  for (std::uint64_t seed = 0; seed < some_of(kSeeds); ++seed) {
    const ProblemSpec spec = symmetric_problem(seed);
    if (spec.connections.size() > 6 || !spec.base.empty()) continue;
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    const auto factors = symmetry_order(system);
    const Symmetry symmetry(system);
    ASSERT_EQ(factors.has_value(), !symmetry.obstacle().has_value());
    if (!factors) continue;
    std::uint64_t order = 1;
    for (const std::uint32_t factor : *factors) order *= factor;
    const std::set<Permutation> group = closure(symmetry.generators(), problem.num_connections());
    EXPECT_EQ(order, group.size());
    // All sequences, and those of them that come first among their images.
    const oracle::World world(spec);
    std::uint64_t all = 0;
    std::uint64_t different = 0;
    std::vector<std::uint32_t> sequence;
    const auto walk = [&](auto&& self, const oracle::State& open) -> void {
      if (sequence.size() == problem.num_connections()) {
        ++all;
        const bool first = std::ranges::all_of(group, [&](const Permutation& g) {
          std::vector<std::uint32_t> other;
          for (const std::uint32_t c : sequence) other.push_back(g[c]);
          return sequence <= other;
        });
        different += first ? 1 : 0;
        return;
      }
      for (const oracle::Facts& facts : world.legal_facts(open)) {
        oracle::State next = open;
        next[facts.connection] = false;
        sequence.push_back(static_cast<std::uint32_t>(facts.connection));
        self(self, next);
        sequence.pop_back();
      }
    };
    if (!world.start_infeasible()) walk(walk, world.start());
    EXPECT_EQ(different * order, all);
    const Alternatives found = find_alternatives(system, true, 0, Budget{});
    if (order > 1 && all > 0) {
      ASSERT_TRUE(found.optimal_up_to_symmetry.has_value());
      EXPECT_EQ(std::to_string(std::stoull(*found.optimal_up_to_symmetry) * order),
                *found.optimal_sequences);
      ++counted;
    } else {
      EXPECT_FALSE(found.optimal_up_to_symmetry.has_value());
    }
    if (HasFailure()) return;
  }
  EXPECT_GE(counted, least_of(100));
}

// -------------------------------------------------------------------------------------------------

/// `many` equal parts on one.
ProblemSpec star(std::size_t many) {
  ProblemSpec spec;
  spec.parts.push_back({.id = "plate"});
  for (std::size_t i = 0; i < many; ++i) {
    spec.parts.push_back({.id = "nut " + std::to_string(i)});
    spec.connections.push_back({.parts = {"plate", spec.parts.back().id}});
  }
  return spec;
}

double order_of(const ProblemSpec& spec) {
  const Problem problem(spec);
  const TransitionSystem system(problem);
  return Symmetry(system).order();
}

TEST(Symmetry, WhatTellsPartsApartCounts) {
  if (!has_nauty()) GTEST_SKIP() << "built without nauty";
  EXPECT_EQ(order_of(star(5)), 120);
  // What they are called tells nothing apart.
  ProblemSpec called = star(5);
  for (std::size_t i = 1; i < called.parts.size(); ++i)
    called.parts[i].product = i % 2 == 0 ? "nut" : "bolt";
  EXPECT_EQ(order_of(called), 120);
  ProblemSpec spec = star(5);
  spec.parts[1].mass = 2;
  EXPECT_EQ(order_of(spec), 24);
  spec = star(5);
  spec.connections[3].duration = 2;
  EXPECT_EQ(order_of(spec), 24);
  spec = star(5);
  spec.base = {"nut 0", "nut 1"};
  EXPECT_EQ(order_of(spec), 12);
  spec = star(5);
  spec.precedence.push_back({.connection = "plate-nut 0", .after = {"plate-nut 1", "plate-nut 2"}});
  EXPECT_EQ(order_of(spec), 4);
  spec = star(4);
  spec.blocking.emplace();
  spec.blocking->directions = {"+x", "-x"};
  spec.blocking->blocked = {{"nut 0", "plate", {"+x"}, {}}, {"plate", "nut 1", {"-x"}, {}}};
  EXPECT_EQ(order_of(spec), 4);  // the two facts say the same, one of each nut
  // Directions may be exchanged, of all pairs at once.
  spec.blocking->blocked[1].directions = {"+x"};
  EXPECT_EQ(order_of(spec), 4);
  spec.blocking->blocked = {{"nut 0", "plate", {"+x"}, {}},
                            {"nut 1", "plate", {"-x"}, {}},
                            {"nut 2", "plate", {"+x"}, {}},
                            {"nut 3", "plate", {"-x"}, {}}};
  EXPECT_EQ(order_of(spec), 8);  // the two of a kind, and one kind with the other
  spec.blocking->blocked.pop_back();
  EXPECT_EQ(order_of(spec), 2);
  spec.blocking->directions = {"+x", "-x", "+y", "-y"};
  spec.blocking->blocked = {{"nut 0", "plate", {"+x", "-x", "+y"}, {}},
                            {"nut 1", "plate", {"+x", "+y", "-y"}, {}}};
  EXPECT_EQ(order_of(spec), 4);
  spec.blocking->blocked[1].directions = {"+x", "-x"};
  EXPECT_EQ(order_of(spec), 2);
  spec = star(4);
  spec.parts[2].position = Vector3{1, 2, 3};
  spec.parts[2].name = "the second one";
  EXPECT_EQ(order_of(spec), 24);  // cubesat looks at neither
  spec.objective = Objective::named("time");
  EXPECT_EQ(order_of(spec), 1);
}

// Who blocks whom counts, not only in which directions each is blocked.
TEST(Symmetry, WhatIsBlockedStaysBlockedByTheSame) {
  if (!has_nauty()) GTEST_SKIP() << "built without nauty";
  ProblemSpec spec;
  for (const std::string id : {"a", "b", "c", "d"}) {
    for (const Part& other : spec.parts) spec.connections.push_back({.parts = {other.id, id}});
    spec.parts.push_back({.id = id});
  }
  EXPECT_EQ(order_of(spec), 24);
  spec.blocking.emplace();
  spec.blocking->directions = {"+x", "-x", "+y", "-y"};
  spec.blocking->blocked = {{"a", "b", {"+x"}, {}}, {"c", "d", {"+y"}, {}}};
  // Each pair may be reversed, and one pair exchanged with the other.
  EXPECT_EQ(order_of(spec), 8);
  spec.blocking->blocked[1].directions = {"+x"};
  // Both pairs are reversed, or none.
  EXPECT_EQ(order_of(spec), 4);
}

// Of more directions than are exchanged, each stays what it is.
TEST(Symmetry, ManyDirectionsStayWhatTheyAre) {
  if (!has_nauty()) GTEST_SKIP() << "built without nauty";
  ProblemSpec spec = star(4);
  spec.blocking.emplace();
  for (int i = 0; i < 33; ++i) {
    const std::string name = "slant " + std::to_string(i);
    spec.blocking->directions.push_back({name, Vector3{1, static_cast<double>(i), 1}});
  }
  spec.blocking->blocked = {{"nut 0", "plate", {"slant 0"}, {}},
                            {"nut 1", "plate", {"slant 0"}, {}},
                            {"nut 2", "plate", {"slant 1"}, {}},
                            {"nut 3", "plate", {"-slant 1"}, {}}};
  EXPECT_EQ(order_of(spec), 2);
  // The same, said of the other part.
  spec.blocking->blocked[1] = {"plate", "nut 1", {"-slant 0"}, {}};
  EXPECT_EQ(order_of(spec), 2);
  spec.blocking->blocked[2].directions = {"slant 0"};
  EXPECT_EQ(order_of(spec), 6);
}

TEST(Symmetry, ObjectivesThatMayTellPartsApartAreRefused) {
  for (const char* const type : {"indexed", "travel", "route"}) {
    ProblemSpec spec = star(3);
    for (Part& part : spec.parts) part.position = Vector3{};
    spec.objective = Objective::named(type);
    const Problem problem(spec);
    for (const char* const method : kMethods) {
      const std::string fault =
          fault_of([&] { return solve(problem, method, with(SymmetryUse::On)); });
      EXPECT_NE(fault.find("finds no symmetry"), std::string::npos) << method << ": " << fault;
      EXPECT_TRUE(solve(problem, method).has_plan());
    }
  }
}

TEST(Symmetry, LargerProblemsUseItByThemselves) {
  if (!has_nauty()) GTEST_SKIP() << "built without nauty";
  // 18 equal parts: 262,144 states, and 19 up to symmetry.
  const Problem problem(star(18));
  for (const char* const method : {"value-iteration", "dijkstra", "bellman-ford"}) {
    const Result with_it = solve(problem, method);
    const Result without = solve(problem, method, with(SymmetryUse::Off));
    EXPECT_EQ(with_it.statistics.states, 19U);
    EXPECT_EQ(without.statistics.states, 262'144U);
    EXPECT_NEAR(with_it.reward, without.reward, 1e-9);
    EXPECT_EQ(with_it.notes.back(),
              "6402373705728000 ways to exchange equal parts leave the problem as it is");
  }
}

// 70 equal parts: 2^70 states in two words, and 71 up to symmetry.
TEST(Symmetry, WhatIsTooLargeForHMayFitUpToSymmetry) {
  if (!has_nauty()) GTEST_SKIP() << "built without nauty";
  for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
    ProblemSpec spec = star(70);
    spec.direction = direction;
    const Problem problem(spec);
    // One by one; the step that costs nothing but completes is the smallest or the largest.
    const double best =
        direction == Direction::Disassembly
            ? 1 - (67 * 0.0967 + (0.0967 + 0.1368) + (0.0967 + 0.1248))
            : 1 - (66 * 0.0967 + (0.0967 + 0.1368) + (0.0967 + 0.1248) + (0.0967 + 0.0967));
    for (const char* const method : {"value-iteration", "dijkstra", "bellman-ford"}) {
      EXPECT_TRUE(obstacle(problem, method, with(SymmetryUse::Off)).has_value());
      EXPECT_FALSE(obstacle(problem, method).has_value());
      const Result result = solve(problem, method);
      EXPECT_EQ(result.statistics.states, 71U);
      EXPECT_EQ(result.status, Status::Optimal);
      EXPECT_NEAR(result.reward, best, 1e-9);
    }
    Options options = with(SymmetryUse::On);
    options.bound = BoundKind::None;
    const Result found = solve(problem, "a-star", options);
    EXPECT_EQ(found.status, Status::Optimal);
    EXPECT_LE(found.statistics.expanded, 71U);
    EXPECT_NEAR(found.reward, best, 1e-9);
    EXPECT_NEAR(solve(problem, "beam", options).reward, best, 1e-9);
  }
}

}  // namespace
}  // namespace orasp
