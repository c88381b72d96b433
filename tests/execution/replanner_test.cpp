// Problems met again in the middle (Situation, Replanner): every planner and the Replanner against
// brute force written from the sentences of model/situation.h, on random problems, states and
// changes.

#include "orasp/execution/replanner.h"

#include <algorithm>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/bounds/bound_kinds.h"
#include "orasp/catalogue.h"
#include "orasp/execution/waiting.h"
#include "orasp/explain/explain_problem.h"
#include "orasp/graph/state_graph.h"
#include "orasp/io/scenarios.h"
#include "orasp/mip/mip.h"
#include "orasp/model/random.h"
#include "orasp/model/validate.h"
#include "orasp/planners/automatic.h"
#include "orasp/planners/value_iteration.h"
#include "tests/checks.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();

/// What is left of a problem, worked out by definition.
class Truth {
 public:
  Truth(const ProblemSpec& spec, const Situation& now)
      : spec_(spec), world_(spec), now_(now), start_(oracle::state_of(now.open.view(), size())) {
    for (std::size_t c = 0; c < size(); ++c) {
      if (start_[c] && has(now.inaccessible, c)) ++kept_;
    }
    oracle::State never = start_;
    for (std::size_t c = 0; c < size(); ++c) never[c] = start_[c] && has(now.inaccessible, c);
    world_.give_up(never);
    best_ = cannot_begin() ? kNever : best(start_);
  }

  [[nodiscard]] double best() const { return best_; }

  /// Replays a plan: its reward, nothing if it breaks a rule or ends early.
  [[nodiscard]] std::optional<double> replay(const std::vector<ConnectionIndex>& sequence) const {
    oracle::State open = start_;
    double reward = 0;
    for (const ConnectionIndex c : sequence) {
      const auto legal = allowed(open);
      const auto found = std::ranges::find(legal, c.value(), &oracle::Facts::connection);
      if (found == legal.end()) return std::nullopt;
      reward += found->reward;
      open[c] = false;
    }
    if (static_cast<std::size_t>(std::ranges::count(open, true)) != kept_) return std::nullopt;
    return reward;
  }

  /// The best reward still to come from each state that can be reached.
  [[nodiscard]] const std::map<oracle::State, double>& values() const { return values_; }

 private:
  [[nodiscard]] std::size_t size() const { return spec_.connections.size(); }
  [[nodiscard]] static bool has(const ConnectionSet& set, std::size_t c) {
    return set.contains(static_cast<ConnectionIndex>(c));
  }

  [[nodiscard]] bool cannot_begin() const {
    if (static_cast<std::size_t>(std::ranges::count(start_, true)) > kept_ &&
        !world_.broken_at_start(start_).empty())
      return true;
    if (!spec_.limits.max_subassemblies ||
        static_cast<std::size_t>(std::ranges::count(start_, true)) == kept_)
      return false;
    oracle::State present = start_;
    if (spec_.direction == Direction::Assembly) {
      // The product when all is made.
      for (std::size_t c = 0; c < size(); ++c)
        present[c] = !(start_[c] && has(now_.inaccessible, c));
    }
    return world_.subassemblies(present) > *spec_.limits.max_subassemblies;
  }

  [[nodiscard]] std::vector<oracle::Facts> allowed(const oracle::State& open) const {
    std::vector<oracle::Facts> steps;
    for (std::size_t c = 0; c < size(); ++c) {
      if (!open[c] || has(now_.inaccessible, c)) continue;
      if (open == start_ && has(now_.not_next, c)) continue;
      oracle::Facts facts = world_.facts(open, c, kept_);
      if (facts.legal()) steps.push_back(std::move(facts));
    }
    const auto late = [&](const oracle::Facts& step) { return has(now_.late, step.connection); };
    const bool others = std::ranges::any_of(steps, [&](const oracle::Facts& step) {
      if (late(step)) return false;
      oracle::State next = open;
      next[step.connection] = false;
      return reaches_end(next);
    });
    if (others) std::erase_if(steps, late);
    return steps;
  }

  /// Whether the rest can be done from here, in any order.
  [[nodiscard]] bool reaches_end(const oracle::State& open) const {
    if (static_cast<std::size_t>(std::ranges::count(open, true)) == kept_) return true;
    const auto known = reaches_.find(open);
    if (known != reaches_.end()) return known->second;
    bool reaches = false;
    for (std::size_t c = 0; c < size() && !reaches; ++c) {
      if (!open[c] || has(now_.inaccessible, c) || !world_.facts(open, c, kept_).legal()) continue;
      oracle::State next = open;
      next[c] = false;
      reaches = reaches_end(next);
    }
    return reaches_[open] = reaches;
  }

  double best(const oracle::State& open) {
    if (static_cast<std::size_t>(std::ranges::count(open, true)) == kept_) return 0;
    const auto known = values_.find(open);
    if (known != values_.end()) return known->second;
    double most = kNever;
    for (const oracle::Facts& step : allowed(open)) {
      oracle::State next = open;
      next[step.connection] = false;
      most = std::max(most, step.reward + best(next));
    }
    return values_[open] = most;
  }

  const ProblemSpec& spec_;
  oracle::World world_;
  Situation now_;
  oracle::State start_;
  std::size_t kept_ = 0;
  double best_ = 0;
  std::map<oracle::State, double> values_;
  mutable std::map<oracle::State, bool> reaches_;
};

/// Each connection with a chance of one in `in`.
ConnectionSet some(std::size_t connections, std::uint64_t in, SplitMix64& random) {
  ConnectionSet set(connections);
  for (std::size_t c = 0; c < connections; ++c) {
    if (random.below(in) == 0) set.insert(static_cast<ConnectionIndex>(c));
  }
  return set;
}

/// A random state, mostly one that legal steps lead to, and random things in the way.
Situation random_situation(const Problem& problem, SplitMix64& random) {
  const std::size_t n = problem.num_connections();
  Situation now = Situation::whole(n);
  if (random.below(4) == 0) {
    now.open = some(n, 2, random);
  } else {
    const TransitionSystem system(problem);
    Expander expander(system);
    for (std::uint64_t k = random.below(n / 2 + 1); k > 0; --k) {
      const auto legal = expander.legal_actions(now.open.view());
      if (legal.empty()) break;
      now.open.erase(legal[random.below(legal.size())].connection);
    }
  }
  if (random.below(3) != 0) now.inaccessible = some(n, 4, random);
  if (random.below(2) == 0) now.not_next = some(n, 3, random);
  if (random.below(3) == 0) now.late = some(n, 4, random);
  return now;
}

void expect_right(const Truth& truth, const Result& result) {
  if (truth.best() == kNever) {
    EXPECT_EQ(result.status, Status::Infeasible);
    EXPECT_FALSE(result.notes.empty());
    return;
  }
  ASSERT_EQ(result.status, Status::Optimal);
  EXPECT_NEAR(result.reward, truth.best(), reward_tolerance(truth.best()));
  EXPECT_NEAR(result.bound.value_or(kNever), truth.best(), reward_tolerance(truth.best()));
  const auto replayed = truth.replay(result.sequence);
  ASSERT_TRUE(replayed.has_value());
  EXPECT_NEAR(*replayed, truth.best(), reward_tolerance(truth.best()));
}

constexpr int kBlocks = 8;
constexpr std::uint64_t kSeedsInBlock = 60;

class InTheMiddle : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Seeds, InTheMiddle, testing::Range(0, kBlocks));

TEST_P(InTheMiddle, EveryExactPlannerAgreesWithBruteForce) {
  for (std::uint64_t i = 0; i < some_of(kSeedsInBlock); ++i) {
    const std::uint64_t seed = static_cast<std::uint64_t>(GetParam()) * kSeedsInBlock + i;
    const ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    SplitMix64 random(seed + 1);
    for (int round = 0; round < 3; ++round) {
      const Situation now = random_situation(problem, random);
      const Truth truth(spec, now);
      const TransitionSystem system(problem, now);
      const Task task(problem, now);
      for (const Planner* const planner : one_robot_planners()) {
        SCOPED_TRACE(planner->name);
        if (!planner->exact || planner->role == Role::Learner) continue;
        if (planner->role == Role::Baseline && (round > 0 || problem.num_connections() > 4))
          continue;
        if (obstacle(task, planner->name, quick_options())) continue;
        expect_right(truth, solve(task, planner->name, quick_options()));
      }
      expect_right(truth, automatic(system, 1, Budget{}));
      if (testing::Test::HasFailure()) return;
    }
  }
}

TEST_P(InTheMiddle, BoundsAreAdmissibleAndConsistentWhereConnectionsAreKept) {
  for (std::uint64_t i = 0; i < some_of(kSeedsInBlock); ++i) {
    const std::uint64_t seed = static_cast<std::uint64_t>(GetParam()) * kSeedsInBlock + i;
    const ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    SplitMix64 random(seed + 2);
    const Situation now = random_situation(problem, random);
    const Truth truth(spec, now);
    const TransitionSystem system(problem, now);
    Expander expander(system);
    for (const BoundKind kind : {BoundKind::None, BoundKind::Connections, BoundKind::Sizes,
                                 BoundKind::Parts, BoundKind::Best}) {
      const auto bound = make_bound(system, kind);
      if (!bound->known()) continue;
      for (const auto& [state, value] : truth.values()) {
        ConnectionSet open = oracle::set_of(state);
        for_each_connection(system.kept().view(), [&](ConnectionIndex c) { open.erase(c); });
        const double here = (*bound)(open.view());
        const double slack = reward_tolerance(here);
        ASSERT_GE(here, value - slack);
        const auto span = expander.legal_actions(open.view());
        const std::vector<Action> legal(span.begin(), span.end());
        std::vector<double> after(legal.size());
        bound->of_successors(open.view(), here, legal, after);
        for (std::size_t a = 0; a < legal.size(); ++a) {
          ConnectionSet next = open;
          next.erase(legal[a].connection);
          EXPECT_NEAR(after[a], (*bound)(next.view()), slack);
          EXPECT_GE(here, legal[a].reward + after[a] - slack);
        }
        if (testing::Test::HasFailure()) return;
      }
    }
  }
}

TEST_P(InTheMiddle, ReplannerEqualsBruteForceThroughChangesOfEveryKind) {
  std::map<std::string, int> changes;
  for (std::uint64_t i = 0; i < some_of(kSeedsInBlock); ++i) {
    const std::uint64_t seed = static_cast<std::uint64_t>(GetParam()) * kSeedsInBlock + i;
    ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    if (problem.num_connections() == 0) continue;
    SplitMix64 random(seed + 3);
    Replanner replanner(problem);
    Replanner searching(problem, {.most_actions = -1});
    EXPECT_FALSE(searching.holds_graph());
    const auto change = [&](auto&& apply) {
      apply(replanner);
      apply(searching);
    };
    for (int step = 0; step < 12; ++step) {
      const auto c = static_cast<ConnectionIndex>(random.below(problem.num_connections()));
      const auto part = static_cast<PartIndex>(random.below(problem.num_parts()));
      const bool yes = random.below(3) != 0;
      switch (random.below(7)) {
        case 0: {
          const Result plan = replanner.plan();
          if (plan.sequence.empty()) continue;
          change([&](Replanner& r) { r.done(plan.sequence.front()); });
          ++changes["done by the plan"];
          break;
        }
        case 1: change([&](Replanner& r) { r.set_done(c, yes); }); break;
        case 2: change([&](Replanner& r) { r.set_accessible(c, !yes); }); break;
        case 3: change([&](Replanner& r) { r.set_possible_next(c, !yes); }); break;
        case 4: change([&](Replanner& r) { r.set_lost(part, yes); }); break;
        case 5: change([&](Replanner& r) { r.set_late(part, yes); }); break;
        default: {
          spec.limits = problem.limits();
          if (yes) spec.limits.max_subassemblies = 1 + random.below(3);
          if (random.below(3) == 0) spec.limits.max_moved_parts = 1 + random.below(3);
          change([&](Replanner& r) { r.set_limits(spec.limits); });
          ++changes["limits"];
          break;
        }
      }
      const Situation now = replanner.situation();
      EXPECT_EQ(now, searching.situation());
      const Truth truth(spec, now);
      expect_right(truth, replanner.plan());
      expect_right(truth, searching.plan());
      ++changes[truth.best() == kNever ? "infeasible" : "feasible"];
      if (testing::Test::HasFailure()) return;
    }
  }
  if (percent_of_seeds() == 100) {
    EXPECT_EQ(changes.size(), 4U);
  }
}

ConnectionSet connections_of(const Problem& problem, PartIndex part) {
  ConnectionSet set(problem.num_connections());
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    if (std::ranges::count(problem.ends(c), part) > 0) set.insert(c);
  }
  return set;
}

// Whatever part is lost at whatever moment: if the job can be finished with it at all, what does
// not wait can be done, the rest after it, and nothing more could be done before.
TEST(Waiting, LeavesAWayToTheEndWheneverThereIsOne) {
  std::map<std::string, int> seen;
  for (std::uint64_t seed = 0; seed < some_of(400U); ++seed) {
    ProblemSpec spec = random_problem(seed);
    for (Connection& connection : spec.connections) connection.on_failure = {};
    for (const Direction direction : {Direction::Disassembly, Direction::Assembly}) {
      spec.direction = direction;
      SCOPED_TRACE(spec.name);
      const Problem problem(spec);
      SplitMix64 random(seed + 11);
      Situation now = Situation::whole(problem.num_connections());
      const TransitionSystem system(problem);
      Expander expander(system);
      for (std::uint64_t k = random.below(problem.num_connections() / 2 + 1); k > 0; --k) {
        const auto legal = expander.legal_actions(now.open.view());
        if (legal.empty()) break;
        now.open.erase(legal[random.below(legal.size())].connection);
      }
      const Truth job(spec, now);
      for (PartIndex part = 0; part < problem.num_parts(); ++part) {
        const ConnectionSet missing = connections_of(problem, part);
        const Waiting answer = waiting_for(problem, now, missing, Budget{});
        const ConnectionSet& waiting = answer.connections;
        bool touched = false;
        for_each_connection(missing.view(),
                            [&](ConnectionIndex c) { touched = touched || now.open.contains(c); });
        if (!touched) {
          ASSERT_TRUE(answer.status == Status::Feasible && waiting.empty());
          continue;
        }
        ASSERT_EQ(answer.status, job.best() != kNever ? Status::Feasible : Status::Infeasible);
        if (answer.status != Status::Feasible) {
          ++seen["never"];
          continue;
        }
        Situation before = now;
        before.inaccessible = waiting;
        const Result plan = solve(Task(problem, before), "auto", quick_options());
        ASSERT_EQ(plan.status, Status::Optimal);
        // From there the rest can be done, and without the part nothing more.
        Situation rest = now;
        for (const ConnectionIndex c : plan.sequence) {
          EXPECT_FALSE(missing.contains(c));
          rest.open.erase(c);
        }
        EXPECT_EQ(rest.open, waiting);
        EXPECT_NE(Truth(spec, rest).best(), kNever);
        for_each_connection(rest.open.view(), [&](ConnectionIndex c) {
          if (missing.contains(c) || !expander.legal(rest.open.view(), c)) return;
          Situation next = rest;
          next.open.erase(c);
          EXPECT_EQ(Truth(spec, next).best(), kNever);
        });
        std::size_t lost = 0;
        for_each_connection(rest.open.view(),
                            [&](ConnectionIndex c) { lost += missing.contains(c) ? 1 : 0; });
        ++seen[lost < rest.open.size() ? "others wait" : "nothing else waits"];
        if (testing::Test::HasFailure()) return;
      }
    }
  }
  EXPECT_GE(seen["never"], more_than(200));
  EXPECT_GE(seen["others wait"], more_than(200));
  EXPECT_GE(seen["nothing else waits"], more_than(500));
}

// A pen: the ink lies in the body between head and button, and the cap goes over the head.
TEST(Waiting, ThePenIsNotShutWithoutItsInkAndNotCappedWithoutItsHead) {
  ProblemSpec spec;
  spec.parts = {{.id = "body"}, {.id = "ink"}, {.id = "head"}, {.id = "button"}, {.id = "cap"}};
  spec.connections = {{.parts = {"body", "ink"}},
                      {.parts = {"body", "head"}},
                      {.parts = {"body", "button"}},
                      {.parts = {"body", "cap"}}};
  spec.precedence = {{.connection = "body-cap", .made_after = {"body-head"}}};
  spec.blocking = Blocking{{"+x", "-x"}, {{"ink", "head", {"+x"}}, {"ink", "button", {"-x"}}}};
  spec.direction = Direction::Assembly;
  const Problem problem(spec);
  const Situation now = Situation::whole(4);
  const auto waits = [&](const std::string& part) {
    const auto waiting =
        waiting_for(problem, now, connections_of(problem, problem.find_part(part, "")), Budget{});
    std::set<std::string> ids;
    for_each_connection(waiting.connections.view(),
                        [&](ConnectionIndex c) { ids.insert(problem.connection_id(c)); });
    return ids;
  };
  EXPECT_EQ(waits("head"), (std::set<std::string>{"body-head", "body-cap"}));
  EXPECT_EQ(waits("button"), (std::set<std::string>{"body-button"}));
  EXPECT_EQ(waits("cap"), (std::set<std::string>{"body-cap"}));
  // One end may be shut, not both; the button leaves more to do.
  const std::set<std::string> without_ink = waits("ink");
  EXPECT_TRUE(without_ink.contains("body-ink"));
  EXPECT_TRUE(without_ink.contains("body-head") != without_ink.contains("body-button"));
}

// An arm joint: both horns are screwed on before the motor goes into the frame.
TEST(Waiting, TheMotorWaitsForItsHorns) {
  ProblemSpec spec;
  spec.parts = {
      {.id = "frame"}, {.id = "motor"}, {.id = "top horn"}, {.id = "bottom horn"}, {.id = "cover"}};
  spec.connections = {{.id = "top", .parts = {"motor", "top horn"}},
                      {.id = "bottom", .parts = {"motor", "bottom horn"}},
                      {.id = "motor", .parts = {"frame", "motor"}},
                      {.id = "cover", .parts = {"frame", "cover"}}};
  spec.precedence = {{.connection = "motor", .made_after = {"top", "bottom"}},
                     {.connection = "cover", .made_after = {"motor"}}};
  spec.direction = Direction::Assembly;
  const Problem problem(spec);
  Replanner replanner(problem);
  replanner.set_late(problem.find_part("top horn", ""), true);
  EXPECT_EQ(replanner.plan().sequence, (std::vector<ConnectionIndex>{1, 0, 2, 3}));
  replanner.set_late(problem.find_part("top horn", ""), false);
  replanner.set_lost(problem.find_part("top horn", ""), true);
  EXPECT_EQ(replanner.plan().sequence, std::vector<ConnectionIndex>{1});
  replanner.done(1);
  EXPECT_TRUE(replanner.plan().sequence.empty());
  replanner.set_lost(problem.find_part("top horn", ""), false);
  EXPECT_EQ(replanner.plan().sequence, (std::vector<ConnectionIndex>{0, 2, 3}));
}

TEST(Replanner, ConflictsAreFoundWhereAndOnlyWhereThereIsNoPlan) {
  int named = 0;
  for (std::uint64_t seed = 0; seed < some_of(kBlocks * kSeedsInBlock); ++seed) {
    const ProblemSpec spec = random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    SplitMix64 random(seed + 4);
    const Situation now = random_situation(problem, random);
    const ProblemExplanation why = explain_problem(problem, now, Budget{});
    const bool feasible = Truth(spec, now).best() != kNever;
    ASSERT_EQ(why.status, feasible ? Status::Feasible : Status::Infeasible);
    EXPECT_EQ(why.conflict.empty(), feasible);
    // Any one of the inaccessible connections that a smallest conflict names, made accessible,
    // changes what it says.
    for (const ConflictItem& item : why.conflict) {
      if (item.constraint != Constraint::Inaccessible) continue;
      ++named;
      const std::string id = item.message.substr(1, item.message.find('"', 1) - 1);
      const ConnectionIndex c = problem.find_connection(id, "");
      EXPECT_TRUE(now.inaccessible.contains(c) && now.open.contains(c));
      Situation without = now;
      without.inaccessible.erase(c);
      for (const ConflictItem& other : explain_problem(problem, without, Budget{}).conflict)
        EXPECT_NE(other.message, item.message);
    }
  }
  if (percent_of_seeds() == 100) {
    EXPECT_GT(named, 0);
  }
}

// 1-2-3 in a row, at most one subassembly of two parts may ... by hand: with 1-2 inaccessible,
// removing 2-3 completes and earns 1; on its own, removing 1-2 then 2-3 earns -(0.0967 + 0.1248) +
// 1.
TEST(Replanner, ByHand) {
  ProblemSpec spec;
  spec.parts.resize(3);
  for (std::size_t i = 0; i < 3; ++i) spec.parts[i].id = std::to_string(i + 1);
  spec.connections.resize(2);
  spec.connections[0].parts = {"1", "2"};
  spec.connections[1].parts = {"2", "3"};
  const Problem problem(spec);
  Replanner replanner(problem);
  EXPECT_NEAR(replanner.plan().reward, 1 - 0.0967 - 0.1248, 1e-12);
  replanner.set_accessible(0, false);
  Result plan = replanner.plan();
  EXPECT_EQ(plan.sequence, std::vector<ConnectionIndex>{1});
  EXPECT_EQ(plan.reward, 1);
  replanner.set_lost(2, true);  // nothing is left to do
  plan = replanner.plan();
  EXPECT_EQ(plan.status, Status::Optimal);
  EXPECT_TRUE(plan.sequence.empty());
  EXPECT_EQ(plan.reward, 0);
  replanner.set_lost(2, false);
  replanner.set_accessible(0, true);
  replanner.set_late(0, true);
  EXPECT_EQ(replanner.plan().sequence, (std::vector<ConnectionIndex>{1, 0}));
  replanner.set_late(0, false);
  replanner.set_possible_next(0, false);
  EXPECT_EQ(replanner.plan().sequence, (std::vector<ConnectionIndex>{1, 0}));
  replanner.set_possible_next(1, false);
  EXPECT_EQ(replanner.plan().status, Status::Infeasible);
  replanner.done(1);  // the operator did it all the same: what could not be next may be again
  EXPECT_EQ(replanner.plan().sequence, std::vector<ConnectionIndex>{0});
  EXPECT_EQ(replanner.plan().reward, 1);
}

TEST(Replanner, ASituationOfAnotherProblemIsRefused) {
  const Problem problem = load_scenario("lattice");
  Situation now = Situation::whole(problem.num_connections());
  now.late = ConnectionSet(3);
  EXPECT_THROW(TransitionSystem(problem, now), InputError);
}

void expect_same_graph(const StateGraph& one, const StateGraph& other) {
  ASSERT_EQ(one.num_states(), other.num_states());
  ASSERT_EQ(one.num_actions(), other.num_actions());
  for (ActionId a = 0; a < one.num_actions(); ++a) ASSERT_EQ(one.reward(a), other.reward(a));
}

TEST(Reweighing, EqualsGeneratingOnRandomProblemsUnderEveryObjective) {
  int done = 0;
  int differs = 0;
  for (std::uint64_t seed = 0; seed < some_of(300U); ++seed) {
    ProblemSpec spec = seed % 2 == 0 ? random_problem(seed) : larger_random_problem(seed);
    SCOPED_TRACE(spec.name);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    StateGraph graph = StateGraph::build(system, Budget{});
    SplitMix64 random(seed + 5);
    std::string type = "callable";
    const std::uint64_t which = random.below(kPlainObjectiveTypes.size() + 1);
    if (which < kPlainObjectiveTypes.size()) type = kPlainObjectiveTypes[which];
    const bool positions =
        std::ranges::all_of(spec.parts, [](const Part& part) { return part.position.has_value(); });
    if (!positions && (type == "travel" || type == "sum")) type = "time";
    spec.objective = random_objective(type, seed);
    for (Connection& connection : spec.connections)
      connection.duration = static_cast<double>(random.below(9));
    for (Part& part : spec.parts) part.mass = static_cast<double>(1 + random.below(3));
    const Problem other(spec);
    const TransitionSystem other_system(other);
    const StateGraph fresh = StateGraph::build(other_system, Budget{});
    Budget budget;
    budget.threads = 1 + static_cast<unsigned>(seed % 3);
    if (graph.reweigh(other_system, budget) == StateGraph::Reweighed::Done) {
      ++done;
      expect_same_graph(graph, fresh);
      EXPECT_EQ(&graph.system(), &other_system);
    } else {
      // Masses changed what is legal: the graph is the old one still.
      ++differs;
      EXPECT_TRUE(spec.limits.max_moved_mass || spec.blocking);
      EXPECT_EQ(&graph.system(), &system);
      expect_same_graph(graph, StateGraph::build(system, Budget{}));
    }
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GE(done, more_than(200));
  EXPECT_GT(differs, 0);
}

TEST(Reweighing, HubbleFreeAmongAllObjectivesEqualsFreshSolves) {
  ProblemSpec spec = load_scenario("hubble-free").spec();
  for (std::size_t i = 0; i < spec.parts.size(); ++i)
    spec.parts[i].position = Vector3{static_cast<double>(i % 5), static_cast<double>(i / 5), 1};
  Budget budget;
  budget.threads = 2;
  Replanner replanner(Problem(spec), {}, budget);
  const std::size_t looked_at = some_of(kPlainObjectiveTypes.size());  // H is large
  for (const std::string_view type : std::span(kPlainObjectiveTypes).first(looked_at)) {
    if (type == "expression" || type == "sum") {
      spec.objective = random_objective(type, 1);
    } else {
      spec.objective = Objective::named(type);
    }
    SCOPED_TRACE(type);
    const Problem problem(spec);
    EXPECT_TRUE(replanner.reweigh(problem, budget));
    const TransitionSystem system(problem);
    const Result fresh = value_iteration(StateGraph::build(system, budget), {}, budget);
    const Result plan = replanner.plan();
    ASSERT_EQ(plan.status, Status::Optimal);
    EXPECT_NEAR(plan.reward, fresh.reward, reward_tolerance(fresh.reward));
  }
}

// Each connection of hubble, at each step of its plan.
TEST(Replanner, EachConnectionOfHubbleInaccessibleAtEachStepEqualsAFreshSolve) {
  const Problem problem = load_scenario("hubble");
  Replanner replanner(problem);
  ASSERT_TRUE(replanner.holds_graph());
  const Result plan = replanner.plan();
  ASSERT_EQ(plan.sequence.size(), 19U);
  for (std::size_t step = 0; step < plan.sequence.size(); ++step) {
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
      replanner.set_accessible(c, false);
      const Result answer = replanner.plan();
      const TransitionSystem left(problem, replanner.situation());
      const Result fresh = value_iteration(left, {}, Budget{});
      ASSERT_EQ(answer.status, fresh.status);
      if (fresh.has_plan()) {
        ASSERT_NEAR(answer.reward, fresh.reward, 1e-12);
        EXPECT_TRUE(evaluate(left, std::span<const ConnectionIndex>(answer.sequence)).valid);
      }
      replanner.set_accessible(c, true);
    }
    replanner.done(plan.sequence[step]);
  }
}

}  // namespace
}  // namespace orasp
