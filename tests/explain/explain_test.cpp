// Explanations against the oracle: conflicts by taking constraints away, connections by definition
// and by looking at every state.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/explain/explain_connection.h"
#include "orasp/explain/explain_problem.h"
#include "orasp/model/scenario_generators.h"
#include "tests/instances.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

constexpr std::uint64_t kSeeds = 900;

std::vector<std::string> places(const ProblemExplanation& found) {
  std::vector<std::string> names;
  for (const ConflictItem& item : found.conflict) names.push_back(item.where);
  return names;
}

/// The problem with the constraints at these places and no others.
ProblemSpec with_only(const ProblemSpec& whole, const std::vector<std::string>& wanted) {
  const auto is_wanted = [&](const std::string& place) {
    return std::ranges::find(wanted, place) != wanted.end();
  };
  ProblemSpec spec = whole;
  spec.precedence.clear();
  for (std::size_t i = 0; i < whole.precedence.size(); ++i) {
    if (is_wanted("precedence[" + std::to_string(i) + "]"))
      spec.precedence.push_back(whole.precedence[i]);
  }
  if (!is_wanted("limits.max_subassemblies")) spec.limits.max_subassemblies.reset();
  if (!is_wanted("limits.max_moved_parts")) spec.limits.max_moved_parts.reset();
  if (!is_wanted("limits.max_moved_mass")) spec.limits.max_moved_mass.reset();
  if (whole.blocking) {
    spec.blocking->blocked.clear();
    for (std::size_t i = 0; i < whole.blocking->blocked.size(); ++i) {
      if (is_wanted("blocking.blocked[" + std::to_string(i) + "]"))
        spec.blocking->blocked.push_back(whole.blocking->blocked[i]);
    }
  }
  return spec;
}

void expect_irreducible(const ProblemSpec& spec, const ProblemExplanation& found) {
  const std::vector<std::string> conflict = places(found);
  ASSERT_FALSE(conflict.empty());
  EXPECT_TRUE(found.minimal);
  EXPECT_FALSE(oracle::brute_force(with_only(spec, conflict)).feasible);
  for (const std::string& place : conflict) {
    SCOPED_TRACE("without " + place);
    std::vector<std::string> others = conflict;
    std::erase(others, place);
    ASSERT_EQ(others.size() + 1, conflict.size());
    EXPECT_TRUE(oracle::brute_force(with_only(spec, others)).feasible);
  }
}

std::vector<std::string> all_places(const ProblemSpec& spec) {
  std::vector<std::string> names = {"limits.max_subassemblies", "limits.max_moved_parts",
                                    "limits.max_moved_mass"};
  for (std::size_t i = 0; i < spec.precedence.size(); ++i)
    names.push_back("precedence[" + std::to_string(i) + "]");
  for (std::size_t i = 0; spec.blocking && i < spec.blocking->blocked.size(); ++i)
    names.push_back("blocking.blocked[" + std::to_string(i) + "]");
  return names;
}

// A conflict once found is broken by taking its first constraint away, and the next one looked for:
// most random problems have one that a single constraint makes, and these would hide all others.
TEST(ExplainProblem, ConflictsAreIrreducible) {
  std::map<std::size_t, std::size_t> sizes;
  std::set<Constraint> kinds;
  for (std::uint64_t seed = 0; seed < some_of(kSeeds); ++seed) {
    ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    while (true) {
      const ProblemExplanation found = explain_problem(Problem(spec), Budget{});
      const bool feasible = oracle::brute_force(spec).feasible;
      ASSERT_EQ(status_name(found.status), feasible ? "feasible" : "infeasible");
      if (feasible) {
        EXPECT_TRUE(found.conflict.empty());
        EXPECT_TRUE(oracle::replay(spec, found.plan).valid);
        break;
      }
      expect_irreducible(spec, found);
      if (HasFailure()) return;
      ++sizes[found.conflict.size()];
      for (const ConflictItem& item : found.conflict) kinds.insert(item.constraint);
      std::vector<std::string> others = all_places(spec);
      std::erase(others, found.conflict.front().where);
      spec = with_only(spec, others);
    }
  }
  EXPECT_GE(sizes[1], more_than(100U));
  EXPECT_GE(sizes[3] + sizes[4] + sizes[5] + sizes[6], more_than(50U));
  if (percent_of_seeds() == 100) {
    EXPECT_EQ(kinds.size(), 7U);
  }
  for (const auto& [size, count] : sizes)
    RecordProperty("conflicts_of_" + std::to_string(size), static_cast<int>(count));
}

TEST(ExplainProblem, NamesExactlyTheEntriesOfACycle) {
  ProblemSpec spec = instances::assembly(5, {{1, 2}, {2, 3}, {3, 4}, {4, 5}});
  spec.precedence = {{"1-2", {"3-4"}, {}},
                     {"2-3", {"3-4", "4-5"}, {}},
                     {"3-4", {"1-2"}, {}},
                     {"4-5", {}, {"1-2", "2-3"}},
                     {"3-4", {"2-3", "1-2"}, {}}};
  const ProblemExplanation found = explain_problem(Problem(spec), Budget{});
  expect_irreducible(spec, found);
  EXPECT_EQ(found.conflict.size(), 2U);
  for (const ConflictItem& item : found.conflict)
    EXPECT_EQ(item.constraint, Constraint::Precedence);

  const ProblemSpec ring = instances::locked_ring();
  const ProblemExplanation cycle = explain_problem(Problem(ring), Budget{});
  EXPECT_EQ(places(cycle),
            (std::vector<std::string>{"precedence[0]", "precedence[1]", "precedence[2]"}));
  EXPECT_EQ(cycle.conflict[0].message, R"("1-2" may be removed only after "2-3")");
  ProblemSpec backwards = ring;
  backwards.direction = Direction::Assembly;
  EXPECT_EQ(explain_problem(Problem(backwards), Budget{}).conflict[0].message,
            R"("1-2" must be made before "2-3")");
}

// A cycle of 300 connections among 16,000, found without building a problem for each test.
TEST(ExplainProblem, FindsALongCycleInALargeProblem) {
  ProblemSpec spec = chain(16'000);
  for (int i = 1; i <= 2000; ++i) {
    const auto id = [](int k) { return std::to_string(k) + "-" + std::to_string(k + 1); };
    const int next = i == 300 ? 1 : i == 2000 ? 200 : i + 1;  // the others lead into the cycle
    spec.precedence.push_back({id(i), {id(next), id(5000 + i)}, {}});
  }
  const auto begin = std::chrono::steady_clock::now();
  const ProblemExplanation found = explain_problem(Problem(spec), Budget{});
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(30));
  EXPECT_TRUE(found.minimal);
  ASSERT_EQ(found.conflict.size(), 300U);
  EXPECT_EQ(found.conflict.back().where, "precedence[299]");
  EXPECT_EQ(found.conflict.back().message, R"("300-301" may be removed only after "1-2")");
}

// Of the ids of an entry only those that take part are named.
TEST(ExplainProblem, NamesOnlyTheIdsThatMatter) {
  ProblemSpec spec = instances::assembly(4, {{1, 2}, {2, 3}, {3, 4}});
  spec.precedence = {{"1-2", {"2-3", "3-4"}, {}}, {"3-4", {"1-2"}, {}}};
  const ProblemExplanation found = explain_problem(Problem(spec), Budget{});
  EXPECT_EQ(places(found), (std::vector<std::string>{"precedence[0]", "precedence[1]"}));
  EXPECT_EQ(found.conflict[0].message, R"("1-2" may be removed only after "3-4")");
}

// Every alternative of an `after_any` must be closed before it is a conflict.
TEST(ExplainProblem, AnAlternativeNeedsAllItsClosures) {
  ProblemSpec spec = instances::assembly(4, {{1, 2}, {2, 3}, {3, 4}});
  spec.precedence = {{"1-2", {}, {"2-3", "3-4"}}, {"2-3", {"1-2"}, {}}, {"3-4", {"1-2"}, {}}};
  const ProblemExplanation found = explain_problem(Problem(spec), Budget{});
  EXPECT_EQ(places(found),
            (std::vector<std::string>{"precedence[0]", "precedence[1]", "precedence[2]"}));
  EXPECT_EQ(found.conflict[0].message,
            R"("1-2" may be removed only after at least one of "2-3" and "3-4")");
}

TEST(ExplainProblem, TooManyStartingSubassembliesAreTheLimitAlone) {
  ProblemSpec spec = instances::two_pieces();
  spec.limits.max_subassemblies = 1;
  spec.limits.max_moved_parts = 0;
  spec.precedence = {{"1-2", {"3-4"}, {}}, {"3-4", {"1-2"}, {}}};
  const ProblemExplanation found = explain_problem(Problem(spec), Budget{});
  EXPECT_EQ(places(found), (std::vector<std::string>{"limits.max_subassemblies"}));
  EXPECT_EQ(found.conflict[0].message,
            "the whole product is 2 subassemblies; at most 1 are allowed");
}

//   1 - 2 - 3 - 4 1 and 4 are closed in by their neighbours, so the middle goes first; that moves
//   two parts.
TEST(ExplainProblem, BlockingAgainstALimit) {
  ProblemSpec spec = instances::assembly(4, {{1, 2}, {2, 3}, {3, 4}});
  spec.blocking =
      Blocking{{"+x", "-x"},
               {{"1", "2", {"+x"}}, {"1", "3", {"-x"}}, {"4", "3", {"-x"}}, {"4", "2", {"+x"}}}};
  spec.limits.max_moved_parts = 1;
  spec.limits.max_moved_mass = 50;
  const ProblemExplanation found = explain_problem(Problem(spec), Budget{});
  expect_irreducible(spec, found);
  EXPECT_EQ(places(found),
            (std::vector<std::string>{"limits.max_moved_parts", "blocking.blocked[0]",
                                      "blocking.blocked[1]", "blocking.blocked[2]",
                                      "blocking.blocked[3]"}));
  EXPECT_EQ(found.conflict[0].message, "a moved piece may have at most 1 part");
  EXPECT_EQ(found.conflict[1].message, R"("1" cannot leave "2" along +x)");
}

// The lid is closed in by the box along both directions, by 12 mm and by a lip of 0.25 mm, where an
// import took 0.1 mm for contact.
ProblemSpec lid_under_a_lip() {
  ProblemSpec spec = instances::assembly(2, {{1, 2}});
  spec.blocking = Blocking{{"+x", "-x"}, {{"1", "2", {"-x", "+x"}, {0.012, 0.00025}}}, 0.0001};
  return spec;
}

TEST(ExplainProblem, SaysHowWideFactsOfAnImportAre) {
  const ProblemExplanation found = explain_problem(Problem(lid_under_a_lip()), Budget{});
  ASSERT_EQ(found.conflict.size(), 1U);
  EXPECT_EQ(found.conflict[0].message,
            R"("1" cannot leave "2" along +x (0.25 mm wide, near the tolerance of 0.1 mm) and -x )"
            "(12 mm wide)");
}

TEST(ExplainConnection, SaysHowWideFactsOfAnImportAre) {
  ProblemSpec spec = lid_under_a_lip();
  const auto explained = [&spec] {
    const Problem problem(spec);
    return explain_connection(problem, ConnectionSet::all(1), 0, Budget{}).remedies.at(0);
  };
  // "2" moves, and its way along +x is that of "1" along -x.
  EXPECT_TRUE(explained().message.ends_with("(blocking.blocked[0], 12 mm wide)"))
      << explained().message;
  ASSERT_EQ(explained().directions.size(), 2U);
  EXPECT_EQ(explained().directions[0].width, 0.012);
  EXPECT_EQ(explained().directions[1].width, 0.00025);
  // Of several facts along a direction the widest keeps it shut; one without a width hides it.
  spec.blocking->blocked.push_back({"2", "1", {"-x"}, {0.003}});
  EXPECT_EQ(explained().directions[1].width, 0.003);
  spec.blocking->blocked.push_back({"2", "1", {"-x"}, {}});
  EXPECT_FALSE(explained().directions[1].width);
  spec.blocking->blocked = {{"1", "2", {"-x", "+x"}, {}}};
  EXPECT_TRUE(explained().message.ends_with("(blocking.blocked[0])")) << explained().message;
  EXPECT_FALSE(explained().directions[0].width);
}

TEST(ExplainProblem, FindsAFewAmongHundredsOfEntries) {
  ProblemSpec spec = instances::assembly(0, {});
  Blocking blocking{{"+x", "-x"}, {}};
  for (int p = 1; p <= 60; ++p) {
    Part part;
    part.id = std::to_string(p);
    spec.parts.push_back(part);
    if (p == 1) continue;
    Connection connection;
    connection.parts = {"1", part.id};
    spec.connections.push_back(connection);
    for (int by = 1; by < p; ++by)
      blocking.blocked.push_back({part.id, std::to_string(by), {"+x"}});
  }
  blocking.blocked[700].directions = {"+x", "-x"};  // 38 by 35
  spec.blocking = blocking;
  spec.precedence = {{"1-36", {"1-38"}, {}}};
  const ProblemExplanation found = explain_problem(Problem(spec), Budget{});
  ASSERT_EQ(status_name(found.status), "infeasible");
  EXPECT_TRUE(found.minimal);
  EXPECT_EQ(places(found), (std::vector<std::string>{"blocking.blocked[700]"}));
  EXPECT_EQ(found.conflict[0].message, R"("38" cannot leave "35" along +x and -x)");
  EXPECT_LT(found.tests, 80U);
}

// What is not decided is not called smallest, and not called infeasible.
TEST(ExplainProblem, ClaimsNothingThatIsNotProved) {
  ProblemSpec spec = instances::hopeless();
  Budget budget;
  budget.max_expansions = 100;
  const ProblemExplanation unknown = explain_problem(Problem(spec), budget);
  EXPECT_EQ(status_name(unknown.status), "unknown");
  EXPECT_EQ(stop_name(unknown.stop), "expansion limit");
  EXPECT_TRUE(unknown.conflict.empty());

  spec.limits.max_moved_parts = 5;
  std::stop_source stop;  // requested at the first test after the one that proves it
  Budget interrupted;
  interrupted.stop = stop.get_token();
  interrupted.progress = [&](const Progress&) { stop.request_stop(); };
  const ProblemExplanation found = explain_problem(Problem(spec), interrupted);
  EXPECT_EQ(status_name(found.status), "infeasible");
  EXPECT_FALSE(found.minimal);
  EXPECT_EQ(stop_name(found.stop), "interrupted");
  EXPECT_EQ(places(found),
            (std::vector<std::string>{"limits.max_moved_parts", "blocking.blocked[0]",
                                      "blocking.blocked[1]", "blocking.blocked[2]"}));
}

// -------------------------------------------------------------------------------------------------

std::set<std::string> names_of(const std::set<oracle::Rule>& rules) {
  static const std::map<oracle::Rule, std::string> kNames = {
      {oracle::Rule::Precedence, "precedence"},
      {oracle::Rule::PrecedenceAny, "precedence"},
      {oracle::Rule::PrecedenceMadeAny, "precedence"},
      {oracle::Rule::MaxSubassemblies, "max_subassemblies"},
      {oracle::Rule::MaxMovedParts, "max_moved_parts"},
      {oracle::Rule::MaxMovedMass, "max_moved_mass"},
      {oracle::Rule::Blocking, "blocking"}};
  std::set<std::string> names;
  for (const oracle::Rule rule : rules) names.insert(kNames.at(rule));
  return names;
}

/// Fewest legal steps other than `connection` to a state in which it is legal, by the oracle.
std::optional<std::size_t> fewest_steps(const oracle::World& world, const oracle::State& from,
                                        std::size_t connection) {
  std::map<oracle::State, std::size_t> steps = {{from, 0}};
  std::deque<oracle::State> queue = {from};
  while (!queue.empty()) {
    const oracle::State state = queue.front();
    queue.pop_front();
    const auto legal = world.legal_facts(state);
    for (const oracle::Facts& facts : legal) {
      if (facts.connection == connection) return steps.at(state);
    }
    for (const oracle::Facts& facts : legal) {
      oracle::State next = state;
      next.at(facts.connection) = false;
      if (steps.emplace(next, steps.at(state) + 1).second) queue.push_back(next);
    }
  }
  return std::nullopt;
}

/// With the limit at `least` this rule is kept, and below it is not.
void expect_least(const ProblemSpec& spec, const Remedy& remedy, const oracle::State& state,
                  std::size_t connection) {
  const auto breaks = [&](double value) {
    ProblemSpec changed = spec;
    oracle::Rule rule = oracle::Rule::MaxMovedMass;
    if (remedy.constraint == Constraint::MaxSubassemblies) {
      changed.limits.max_subassemblies = static_cast<std::size_t>(value);
      rule = oracle::Rule::MaxSubassemblies;
    } else if (remedy.constraint == Constraint::MaxMovedParts) {
      changed.limits.max_moved_parts = static_cast<std::size_t>(value);
      rule = oracle::Rule::MaxMovedParts;
    } else {
      changed.limits.max_moved_mass = value;
    }
    return oracle::World(changed).facts(state, connection).broken.contains(rule);
  };
  ASSERT_TRUE(remedy.least.has_value());
  EXPECT_FALSE(breaks(*remedy.least));
  const bool is_mass = remedy.constraint == Constraint::MaxMovedMass;
  EXPECT_TRUE(breaks(is_mass ? *remedy.least * 0.999 : *remedy.least - 1));
}

/// Without the entries that block one direction, the connection is not blocked.
void expect_directions(const ProblemSpec& spec, const Remedy& remedy, const oracle::State& state,
                       std::size_t connection) {
  std::size_t directions = 0;
  for (const BlockingDirection& direction : spec.blocking->directions)
    directions += direction.vector ? 2 : 1;
  ASSERT_EQ(remedy.directions.size(), directions);
  for (const BlockedDirection& direction : remedy.directions) {
    ASSERT_FALSE(direction.entries.empty());
    EXPECT_FALSE(direction.in_the_way.empty());
    EXPECT_FALSE(direction.moved.empty());
    ProblemSpec changed = spec;
    for (const std::size_t entry : direction.entries)
      changed.blocking->blocked[entry].directions.clear();
    EXPECT_FALSE(
        oracle::World(changed).facts(state, connection).broken.contains(oracle::Rule::Blocking));
  }
}

TEST(ExplainConnection, AgreesWithTheOracleInEveryState) {
  std::map<std::string, std::size_t> seen;
  std::size_t legal = 0, dead = 0, later = 0, never = 0;
  for (std::uint64_t seed = 0; seed < some_of(240U); ++seed) {
    const ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const oracle::World world(spec);
    if (world.start_infeasible()) continue;
    const oracle::OracleResult truth = oracle::brute_force(spec);
    std::size_t looked_at = 0;
    for (const auto& [state, value] : truth.best_to_go) {
      if (++looked_at % 5 != 0 && state != world.start()) continue;
      for (std::size_t c = 0; c < problem.num_connections(); ++c) {
        if (!state[c]) continue;
        SCOPED_TRACE("connection " + std::to_string(c));
        const oracle::Facts facts = world.facts(state, c);
        const ConnectionExplanation found = explain_connection(
            problem, oracle::set_of(state), static_cast<ConnectionIndex>(c), Budget{});
        ASSERT_EQ(found.legal, facts.legal());
        if (found.legal) {
          ++legal;
          oracle::State next = state;
          next[c] = false;
          const bool goes_on = std::isfinite(truth.best_to_go.at(next)) ||
                               std::ranges::none_of(next, [](bool open) { return open; });
          ASSERT_TRUE(found.plan_exists.has_value());
          EXPECT_EQ(*found.plan_exists, goes_on);
          dead += goes_on ? 0 : 1;
          continue;
        }
        std::set<std::string> violated;
        ASSERT_EQ(found.remedies.size(), found.violations.size());
        for (std::size_t i = 0; i < found.violations.size(); ++i) {
          const Remedy& remedy = found.remedies[i];
          EXPECT_EQ(remedy.constraint, found.violations[i].constraint);
          EXPECT_FALSE(remedy.message.empty());
          const std::string name(constraint_name(remedy.constraint));
          violated.insert(name);
          ++seen[name];
          if (name == "blocking") {
            expect_directions(spec, remedy, state, c);
          } else if (name == "precedence") {
            EXPECT_EQ(remedy.first.empty(), found.violations[i].too_late);
          } else {
            expect_least(spec, remedy, state, c);
          }
        }
        EXPECT_EQ(violated, names_of(facts.broken));
        const auto fewest = fewest_steps(world, state, c);
        ASSERT_EQ(found.later == ConnectionExplanation::Later::Legal, fewest.has_value());
        ASSERT_EQ(found.later == ConnectionExplanation::Later::Never, !fewest.has_value());
        (fewest ? later : never) += 1;
        if (!fewest) continue;
        EXPECT_TRUE(found.fewest);
        EXPECT_EQ(found.after.size(), *fewest);
        oracle::State reached = state;
        for (const ConnectionIndex step : found.after) {
          ASSERT_TRUE(reached.at(step));
          EXPECT_TRUE(world.facts(reached, step).legal());
          reached.at(step) = false;
        }
        EXPECT_TRUE(world.facts(reached, c).legal());
        if (HasFailure()) return;
      }
    }
  }
  EXPECT_GE(legal, more_than(500U));
  EXPECT_GE(dead, more_than(50U));
  EXPECT_GE(later, more_than(200U));
  EXPECT_GE(never, more_than(50U));
  for (const char* name :
       {"precedence", "max_subassemblies", "max_moved_parts", "max_moved_mass", "blocking"})
    EXPECT_GE(seen[name], more_than(20U)) << name;
}

TEST(ExplainConnection, SaysWhichPartsAreInTheWay) {
  const Problem problem(instances::sandwich());
  ConnectionSet open = ConnectionSet::all(3);
  open.erase(0);  // 1-3 went first: a dead end
  const ConnectionExplanation found = explain_connection(problem, open, 1, Budget{});
  ASSERT_EQ(found.violations.size(), 1U);
  EXPECT_EQ(found.remedies[0].message,
            R"(fewest parts are in the way along +x: "2" in the way of "1" (blocking.blocked[0]))");
  EXPECT_EQ(found.later, ConnectionExplanation::Later::Never);
}

TEST(ExplainConnection, OneThatIsGoneCannotBeHandled) {
  const Problem problem(instances::chain_of_three());
  ConnectionSet open = ConnectionSet::all(2);
  open.erase(0);
  const ConnectionExplanation found = explain_connection(problem, open, 0, Budget{});
  EXPECT_FALSE(found.legal);
  EXPECT_EQ(found.violations.at(0).constraint, Constraint::NotOpen);
  EXPECT_EQ(found.later, ConnectionExplanation::Later::Never);
}

// The last of 40 in a chain of precedence among 80 others: too many states for a search by breadth.
TEST(ExplainConnection, FindsLaterStepsInLargeProblemsToo) {
  std::vector<std::pair<int, int>> pairs;
  for (int p = 1; p <= 120; ++p) pairs.emplace_back(p, p + 1);
  ProblemSpec spec = instances::assembly(121, pairs);
  for (int i = 0; i < 40; ++i) {
    spec.precedence.push_back({std::to_string(3 * i + 4) + "-" + std::to_string(3 * i + 5),
                               {std::to_string(3 * i + 1) + "-" + std::to_string(3 * i + 2)},
                               {}});
    if (3 * i + 5 > 118) break;
  }
  const Problem problem(spec);
  const ConnectionIndex last = problem.find_connection(spec.precedence.back().connection, "");
  const ConnectionExplanation found =
      explain_connection(problem, ConnectionSet::all(120), last, Budget{});
  EXPECT_EQ(found.later, ConnectionExplanation::Later::Legal);
  EXPECT_FALSE(found.fewest);
  EXPECT_EQ(found.after.size(), spec.precedence.size());
  std::vector<ConnectionIndex> sequence = found.after;
  sequence.push_back(last);
  for (ConnectionIndex c = 0; c < 120; ++c) {
    if (std::ranges::find(sequence, c) == sequence.end()) sequence.push_back(c);
  }
  EXPECT_TRUE(oracle::replay(spec, sequence).valid);
}

}  // namespace
}  // namespace orasp
