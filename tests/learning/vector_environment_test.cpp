// Episodes in arrays: masks, rewards and ends are what the rules say, whatever was remembered.

#include "orasp/learning/vector_environment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/scenarios.h"
#include "orasp/learning/environment.h"
#include "orasp/model/error.h"
#include "orasp/model/random.h"
#include "orasp/model/validate.h"
#include "tests/instances.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"
#include "tests/wide_problems.h"

namespace orasp {
namespace {

/// An environment with buffers of its own.
struct World {
  explicit World(const TransitionSystem& system, std::size_t episodes,
                 const VectorEnvironmentOptions& options = {})
      : environment(system, episodes, options),
        observations(episodes * environment.observation_size(), -1),
        bytes(observations.size(), 9),
        masks(episodes * environment.num_actions(), 9),
        rewards(episodes, 9),
        terminated(episodes, 9),
        truncated(episodes, 9),
        finals(observations.size(), -1),
        final_bytes(observations.size(), 9),
        returns(episodes, 9),
        lengths(episodes, 9),
        actions(episodes, 0) {
    environment.reset(buffers());
  }

  EpisodeBuffers buffers() {
    return {.observations = observations,
            .observation_bytes = bytes,
            .masks = masks,
            .rewards = rewards,
            .terminated = terminated,
            .truncated = truncated,
            .final_observations = finals,
            .final_observation_bytes = final_bytes,
            .returns = returns,
            .lengths = lengths};
  }
  void step() { environment.step(actions, buffers()); }
  void random_step() {
    environment.sample(actions);
    step();
  }
  [[nodiscard]] std::vector<float> observation(std::size_t i) const {
    return row(observations, i, environment.observation_size());
  }
  [[nodiscard]] std::vector<std::uint8_t> mask(std::size_t i) const {
    return row(masks, i, environment.num_actions());
  }
  template <class Number>
  static std::vector<Number> row(const std::vector<Number>& all, std::size_t i, std::size_t size) {
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(i * size);
    return {first, first + static_cast<std::ptrdiff_t>(size)};
  }

  VectorEnvironment environment;
  std::vector<float> observations;
  std::vector<std::uint8_t> bytes;
  std::vector<std::uint8_t> masks;
  std::vector<double> rewards;
  std::vector<std::uint8_t> terminated;
  std::vector<std::uint8_t> truncated;
  std::vector<float> finals;
  std::vector<std::uint8_t> final_bytes;
  std::vector<double> returns;
  std::vector<std::int64_t> lengths;
  std::vector<std::int64_t> actions;
};

std::string message_of(const auto& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

bool near(double a, double b) {
  return std::abs(a - b) <= 1e-9 * std::max({1.0, std::abs(a), std::abs(b)});
}

TEST(VectorEnvironment, ObservesAndMasksByHand) {
  // Three connections in a row: the middle one must not be first.
  ProblemSpec spec = instances::assembly(4, {{1, 2}, {2, 3}, {3, 4}});
  spec.precedence.push_back({.connection = "2-3", .after = {"1-2"}, .after_any = {}});
  const Problem problem(spec);
  const TransitionSystem system(problem);
  World world(system, 2);
  EXPECT_EQ(world.environment.num_actions(), 3U);
  EXPECT_EQ(world.environment.observation_size(), 3U);
  EXPECT_EQ(world.environment.max_steps(), 3U);
  EXPECT_EQ(world.observation(0), (std::vector<float>{1, 1, 1}));
  EXPECT_EQ(world.mask(1), (std::vector<std::uint8_t>{1, 0, 1}));
  EXPECT_EQ(world.rewards, (std::vector<double>{0, 0}));

  // Off an end: a part and a chain of three. 0.0967 + 0.1368.
  world.actions = {0, 2};
  world.step();
  EXPECT_EQ(world.observation(0), (std::vector<float>{0, 1, 1}));
  EXPECT_EQ(world.observation(1), (std::vector<float>{1, 1, 0}));
  EXPECT_EQ(world.bytes, (std::vector<std::uint8_t>{0, 1, 1, 1, 1, 0}));
  EXPECT_EQ(world.mask(0), (std::vector<std::uint8_t>{0, 1, 1}));
  EXPECT_EQ(world.mask(1), (std::vector<std::uint8_t>{1, 0, 0}));
  EXPECT_DOUBLE_EQ(world.rewards[0], -0.2335);
  EXPECT_EQ(world.terminated, (std::vector<std::uint8_t>{0, 0}));
  EXPECT_EQ(world.truncated, (std::vector<std::uint8_t>{0, 0}));
  EXPECT_EQ(world.environment.length(0), 1U);
}

TEST(VectorEnvironment, BeginsTheNextEpisodeInTheSameStep) {
  const Problem problem(instances::chain_of_three());
  const TransitionSystem system(problem);
  World world(system, 2);
  world.actions = {0, 1};
  world.step();
  world.actions = {1, 0};
  world.step();
  // 0.7785, the only reward there is; observed is the start of the next episode.
  EXPECT_EQ(world.terminated, (std::vector<std::uint8_t>{1, 1}));
  EXPECT_EQ(world.truncated, (std::vector<std::uint8_t>{0, 0}));
  EXPECT_NEAR(world.returns[0], 0.7785, 1e-12);
  EXPECT_NEAR(world.returns[1], 0.7785, 1e-12);
  EXPECT_EQ(world.lengths, (std::vector<std::int64_t>{2, 2}));
  EXPECT_EQ(world.observation(0), (std::vector<float>{1, 1}));
  EXPECT_EQ(world.finals, (std::vector<float>{0, 0, 0, 0}));
  EXPECT_EQ(world.final_bytes, (std::vector<std::uint8_t>{0, 0, 0, 0}));
  EXPECT_EQ(world.environment.length(0), 0U);
  EXPECT_EQ(world.environment.total(0), 0);
  const auto best = world.environment.best();
  ASSERT_TRUE(best.has_value());
  EXPECT_NEAR(best->reward, 0.7785, 1e-12);
  ASSERT_EQ(best->plan.size(), 2U);
  EXPECT_EQ(best->plan[0].connections, std::vector<ConnectionIndex>{0}) << "the first of several";
}

TEST(VectorEnvironment, BeginsTheNextEpisodeInTheNextStep) {
  const Problem problem(instances::one_connection());
  const TransitionSystem system(problem);
  World world(system, 1, {.autoreset = Autoreset::NextStep});
  world.step();
  EXPECT_EQ(world.terminated, std::vector<std::uint8_t>{1});
  EXPECT_EQ(world.rewards, std::vector<double>{1});
  EXPECT_EQ(world.mask(0), std::vector<std::uint8_t>{0});
  EXPECT_TRUE(world.environment.done(0));
  world.environment.sample(world.actions);
  EXPECT_EQ(world.actions, std::vector<std::int64_t>{0}) << "nothing is legal";
  world.actions = {77};  // whatever it is
  world.step();
  EXPECT_EQ(world.terminated, std::vector<std::uint8_t>{0});
  EXPECT_EQ(world.rewards, std::vector<double>{0});
  EXPECT_EQ(world.mask(0), std::vector<std::uint8_t>{1});
  EXPECT_FALSE(world.environment.done(0));
}

TEST(VectorEnvironment, LeavesEpisodesOverWhereNothingResetsThem) {
  const Problem problem(instances::chain_of_three());
  const TransitionSystem system(problem);
  World world(system, 2, {.autoreset = Autoreset::Off});
  for (const std::int64_t action : {0, 1}) {
    world.actions = {action, action};
    world.step();
  }
  EXPECT_TRUE(world.environment.done(0));
  EXPECT_EQ(message_of([&] { world.step(); }), "episode 0 is over; reset it before its next step");
  const std::vector<std::uint8_t> first{1, 0};
  world.environment.reset(first, world.buffers());
  EXPECT_FALSE(world.environment.done(0));
  EXPECT_EQ(world.terminated, (std::vector<std::uint8_t>{0, 1}));
  EXPECT_EQ(message_of([&] { world.step(); }), "episode 1 is over; reset it before its next step");
}

TEST(VectorEnvironment, TruncatesAtADeadEnd) {
  // 1-3 first is a dead end (tests/instances.h).
  const Problem problem(instances::sandwich());
  const TransitionSystem system(problem);
  World world(system, 2);
  world.actions = {0, 1};
  world.step();
  EXPECT_EQ(world.truncated, (std::vector<std::uint8_t>{1, 0}));
  EXPECT_EQ(world.terminated, (std::vector<std::uint8_t>{0, 0}));
  EXPECT_EQ(World::row(world.finals, 0, 3), (std::vector<float>{0, 1, 1}));
  EXPECT_EQ(World::row(world.finals, 1, 3), (std::vector<float>{-1, -1, -1})) << "left as it was";
  EXPECT_EQ(world.lengths[0], 1);
  EXPECT_EQ(world.lengths[1], 9) << "left as it was";
  EXPECT_EQ(world.observation(0), (std::vector<float>{1, 1, 1}));
  EXPECT_FALSE(world.environment.best().has_value());
}

TEST(VectorEnvironment, RefusesAnIllegalActionAndLeavesAllAsItWas) {
  ProblemSpec spec = instances::assembly(4, {{1, 2}, {2, 3}, {3, 4}});
  spec.precedence.push_back({.connection = "2-3", .after = {"1-2"}, .after_any = {}});
  const Problem problem(spec);
  const TransitionSystem system(problem);
  World world(system, 2);
  world.actions = {0, 2};
  world.step();
  const std::vector<float> observed = world.observations;
  world.actions = {1, 1};
  EXPECT_EQ(message_of([&] { world.step(); }),
            "actions[1] is 1: connection \"2-3\" cannot be handled now: \"2-3\" may be removed "
            "only after \"1-2\"");
  world.actions = {0, 0};
  EXPECT_EQ(message_of([&] { world.step(); }),
            "actions[0] is 0: connection \"1-2\" cannot be handled now: \"1-2\" was removed "
            "before");
  world.actions = {1, 3};
  EXPECT_EQ(message_of([&] { world.step(); }),
            "actions[1] is 3: there is no action 3; actions are 0 to 2");
  world.actions = {-1, 0};
  EXPECT_EQ(message_of([&] { world.step(); }),
            "actions[0] is -1: there is no action -1; actions are 0 to 2");
  EXPECT_EQ(world.observations, observed);
  EXPECT_EQ(world.environment.length(0), 1U);
  EXPECT_EQ(world.environment.length(1), 1U);
  EXPECT_FALSE(world.environment.legal(1, 1));
  EXPECT_TRUE(world.environment.legal(1, 0));
  EXPECT_EQ(world.environment.obstacle(1, 0), "");
  world.actions = {1, 0};
  world.step();
  EXPECT_EQ(world.environment.length(1), 2U);
}

TEST(VectorEnvironment, RefusesBuffersOfOtherSizes) {
  const Problem problem(instances::chain_of_three());
  const TransitionSystem system(problem);
  World world(system, 2);
  world.rewards.resize(3);
  EXPECT_EQ(message_of([&] { world.step(); }), "rewards: 3 numbers are given, 2 are needed");
  world.rewards.resize(2);
  world.masks.resize(3);
  EXPECT_EQ(message_of([&] { world.step(); }), "masks: 3 numbers are given, 4 are needed");
  world.masks.resize(4);
  world.actions.resize(1);
  EXPECT_EQ(message_of([&] { world.step(); }), "actions: 1 numbers are given, 2 are needed");
}

TEST(VectorEnvironment, RefusesWhatNoEpisodeCanBegin) {
  const auto refusal = [](const ProblemSpec& spec) {
    const Problem problem(spec);
    const TransitionSystem system(problem);
    return message_of([&] { VectorEnvironment(system, 1); });
  };
  EXPECT_EQ(refusal(instances::nothing()), "no episode can begin: nothing is left to be done");
  EXPECT_TRUE(refusal(instances::locked_ring()).starts_with("no episode can begin: "));
  EXPECT_EQ(refusal(instances::chain_of_three()), "nothing was thrown");
  ProblemSpec parts = instances::chain_of_three();
  parts.action = StepKind::Part;
  EXPECT_EQ(refusal(parts),
            "action: the environment knows steps that take one connection each; here they take "
            "parts off, and those are too many to be numbered");
}

TEST(VectorEnvironment, StartsWhereItIsTold) {
  const Problem problem = load_scenario("hubble");
  const TransitionSystem system(problem);
  World world(system, 3);
  world.environment.seed(5);
  for (int i = 0; i < 4; ++i) world.random_step();
  std::vector<std::int64_t> first;
  for (const PlanStep& step : world.environment.plan(1))
    first.push_back(world.environment.action_of(step));
  const std::vector<float> there = world.observation(1);
  world.environment.start_after(first);
  world.environment.observe(world.buffers());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(world.observation(i), there);
    EXPECT_EQ(world.environment.total(i), 0);
    EXPECT_EQ(world.environment.plan(i).size(), 4U);
  }
  // The next episode starts there too, and a plan is that of the whole.
  for (std::size_t i = 4; i < problem.num_connections(); ++i) world.random_step();
  EXPECT_EQ(world.terminated, (std::vector<std::uint8_t>{1, 1, 1}));
  EXPECT_EQ(world.observation(2), there);
  EXPECT_EQ(world.lengths[0], 15);
  const Evaluation whole = evaluate(system, world.environment.best()->plan);
  EXPECT_TRUE(whole.valid);
  world.environment.start_after({});
  EXPECT_FALSE(world.environment.best().has_value()) << "it was of another start";
  EXPECT_EQ(message_of([&] {
              world.environment.start_after(std::vector<std::int64_t>{first[0], first[0]});
            }).substr(0, 22),
            "the first steps, [1]: ");
}

TEST(VectorEnvironment, SamplesEachLegalActionEquallyOftenAndFromTheSeed) {
  ProblemSpec spec = instances::assembly(5, {{1, 2}, {2, 3}, {3, 4}, {4, 5}});
  spec.precedence.push_back({.connection = "2-3", .after = {"1-2"}, .after_any = {}});
  const Problem problem(spec);
  const TransitionSystem system(problem);
  constexpr std::size_t kEpisodes = 3000;
  World world(system, kEpisodes);
  const auto draw = [&](std::uint64_t seed) {
    world.environment.seed(seed);
    world.environment.sample(world.actions);
    return world.actions;
  };
  const std::vector<std::int64_t> once = draw(7);
  EXPECT_NE(draw(8), once);
  EXPECT_EQ(draw(7), once);
  // Three are legal: 1000 times each, with a deviation of 26.
  for (const std::int64_t action : {0, 2, 3})
    EXPECT_NEAR(static_cast<double>(std::ranges::count(once, action)), 1000, 130);
  EXPECT_EQ(std::ranges::count(once, 1), 0);
}

TEST(VectorEnvironment, AnErrorOfARewardLeavesAllAsItWas) {
  Callable callable;
  bool fails = false;
  callable.reward = [&fails](const Step& step) {
    const bool now = fails && step.after == 1;
    return now ? std::numeric_limits<double>::infinity() : 1.0;
  };
  const Problem problem = Problem(instances::greedy_trap()).with_objective({"callable", callable});
  const TransitionSystem system(problem);
  World world(system, 2);
  fails = true;
  world.actions = {0, 1};
  EXPECT_THROW(world.step(), InputError);
  EXPECT_EQ(world.environment.length(0), 0U);
  EXPECT_EQ(world.observation(0), (std::vector<float>{1, 1, 1}));
  fails = false;
  world.step();
  EXPECT_EQ(world.rewards, (std::vector<double>{1, 1}));
  EXPECT_EQ(world.environment.length(0), 1U);
}

/// Plays random episodes beside Environment, which asks the Expander in each step.
struct Counts {
  std::size_t finished = 0;
  std::size_t dead_ends = 0;
  std::size_t steps = 0;
};
void play_beside_environment(const TransitionSystem& system, std::size_t episodes,
                             std::size_t steps, std::uint64_t seed,
                             const VectorEnvironmentOptions& options, Counts& counts) {
  Environment slow(system, episodes);
  if (system.infeasibility() || slow.over(0)) return;
  World world(system, episodes, options);
  world.environment.seed(seed);
  std::vector<std::vector<ConnectionIndex>> sequences(episodes);
  std::vector<float> row(system.num_connections());
  for (std::size_t s = 0; s < steps; ++s) {
    world.random_step();
    for (std::size_t i = 0; i < episodes; ++i) {
      const ConnectionIndex c = static_cast<ConnectionIndex>(world.actions[i]);
      sequences[i].push_back(c);
      ++counts.steps;
      ASSERT_EQ(world.rewards[i], slow.step(i, c));
      ASSERT_EQ(world.terminated[i] != 0, slow.done(i));
      ASSERT_EQ(world.truncated[i] != 0, slow.dead_end(i));
      if (slow.over(i)) {
        ASSERT_EQ(world.returns[i], slow.total(i));
        ASSERT_EQ(world.lengths[i], static_cast<std::int64_t>(sequences[i].size()));
        slow.observe(i, row);
        ASSERT_EQ(World::row(world.finals, i, row.size()), row);
        if (slow.done(i)) {
          ++counts.finished;
          const Evaluation plan = evaluate(system, std::span<const ConnectionIndex>(sequences[i]));
          ASSERT_TRUE(plan.valid);
          ASSERT_TRUE(near(plan.reward, world.returns[i]));
          ASSERT_GE(world.environment.best()->reward, world.returns[i]);
        } else {
          ++counts.dead_ends;
        }
        slow.reset(i);
        sequences[i].clear();
      }
      slow.observe(i, row);
      ASSERT_EQ(world.observation(i), row);
      slow.mask(i, row);
      const std::vector<std::uint8_t> mask = world.mask(i);
      ASSERT_TRUE(std::ranges::equal(mask, row));
    }
  }
}

void play_beside_environment(const Problem& problem, std::size_t episodes, std::size_t steps,
                             std::uint64_t seed, const VectorEnvironmentOptions& options,
                             Counts& counts) {
  play_beside_environment(TransitionSystem(problem), episodes, steps, seed, options, counts);
}

TEST(VectorEnvironment, SaysWhatEnvironmentSaysOnRandomProblems) {
  Counts counts;
  for (std::uint64_t seed = 1; seed <= some_of<std::uint64_t>(150); ++seed) {
    SCOPED_TRACE(seed);
    const Problem problem(random_problem(seed));
    ASSERT_NO_FATAL_FAILURE(play_beside_environment(problem, 6, 20, seed, {}, counts));
    const Problem larger(larger_random_problem(seed));
    ASSERT_NO_FATAL_FAILURE(play_beside_environment(larger, 3, 30, seed, {}, counts));
    for (const Direction direction : {Direction::Assembly, Direction::Disassembly}) {
      if (problem.direction() == direction) continue;
      const Problem turned = problem.with_direction(direction);
      ASSERT_NO_FATAL_FAILURE(play_beside_environment(turned, 3, 20, seed, {}, counts));
    }
  }
  EXPECT_GT(counts.finished, more_than<std::size_t>(2000));
  EXPECT_GT(counts.dead_ends, more_than<std::size_t>(50));
}

TEST(VectorEnvironment, SaysWhatEnvironmentSaysOnScenarios) {
  Counts counts;
  for (const char* const name :
       {"lattice", "hubble", "hubble-upc", "iss", "table-hemnes", "grid:4x4", "chain:65"}) {
    SCOPED_TRACE(name);
    const Problem problem = load_scenario(name);
    ASSERT_NO_FATAL_FAILURE(play_beside_environment(problem, 16, 70, 3, {}, counts));
    if (problem.spec().direction == Direction::Assembly) continue;
    const Problem assembly = problem.with_direction(Direction::Assembly);
    ASSERT_NO_FATAL_FAILURE(play_beside_environment(assembly, 16, 70, 3, {}, counts));
  }
  EXPECT_GT(counts.finished, 100U);
}

TEST(VectorEnvironment, SaysWhatEnvironmentSaysInTheMiddleOfTheWork) {
  Counts counts;
  for (std::uint64_t seed = 1; seed <= some_of<std::uint64_t>(150); ++seed) {
    SCOPED_TRACE(seed);
    const Problem problem(random_problem(seed));
    SplitMix64 random(seed);
    Situation now = Situation::whole(problem.num_connections());
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
      if (random.below(5) == 0) now.inaccessible.insert(c);
      if (random.below(6) == 0) now.not_next.insert(c);
      if (random.below(6) == 0) now.late.insert(c);
    }
    const TransitionSystem system(problem, now);
    ASSERT_NO_FATAL_FAILURE(play_beside_environment(system, 4, 16, seed, {}, counts));
  }
  EXPECT_GT(counts.finished, more_than<std::size_t>(500));
}

TEST(VectorEnvironment, TakesMoreThan64Connections) {
  Counts counts;
  const Problem problem = load_scenario("jwst");
  ASSERT_GT(problem.num_connections(), 192U);
  ASSERT_NO_FATAL_FAILURE(
      play_beside_environment(problem, 2, problem.num_connections() + 3, 1, {}, counts));
  EXPECT_EQ(counts.finished, 2U);
}

TEST(VectorEnvironment, SaysTheSameWhateverItForgets) {
  const Problem problem = load_scenario("hubble");
  const TransitionSystem system(problem);
  constexpr std::size_t kEpisodes = 8;
  constexpr std::uint64_t kLimit = std::uint64_t{1} << 15U;
  World all(system, kEpisodes);
  World little(system, kEpisodes, {.max_bytes = kLimit});
  World nothing(system, kEpisodes, {.max_bytes = 0});
  std::uint64_t most = 0;
  for (int s = 0; s < 2000; ++s) {
    all.random_step();
    for (World* const other : {&little, &nothing}) {
      other->random_step();
      ASSERT_EQ(other->actions, all.actions) << "step " << s;
      ASSERT_EQ(other->rewards, all.rewards);
      ASSERT_EQ(other->masks, all.masks);
      ASSERT_EQ(other->observations, all.observations);
      ASSERT_EQ(other->terminated, all.terminated);
    }
    most = std::max(most, little.environment.bytes());
  }
  EXPECT_EQ(all.environment.forgotten(), 0U);
  EXPECT_EQ(nothing.environment.forgotten(), 2000U);
  EXPECT_GT(little.environment.forgotten(), 10U);
  EXPECT_LT(little.environment.forgotten(), 1000U);
  // What one step may add: the states of all episodes, each with up to 19 actions, and an index.
  EXPECT_LT(most, kLimit + kEpisodes * (19 * 16 + 64) + (std::uint64_t{1} << 14U));
  EXPECT_LE(all.environment.remembered(), 12096U) << "H has so many states";
  EXPECT_LE(all.environment.expanded(), 12096U) << "each is expanded once";
  EXPECT_EQ(all.environment.best()->reward, little.environment.best()->reward);
  ASSERT_NO_FATAL_FAILURE({
    Counts counts;
    play_beside_environment(load_scenario("iss"), 4, 40, 1, {.max_bytes = 4096}, counts);
  });
}

/// Plays random episodes of a problem whose states and steps are more than connections.
struct WideCounts {
  std::size_t finished = 0;
  std::size_t dead_ends = 0;
  std::size_t stopped = 0;     ///< plans that ended because they were told to
  std::size_t left = 0;        ///< plans that left connections
  std::size_t directions = 0;  ///< steps that chose one
  std::size_t contexts = 0;    ///< observations with a context
};
void play_wide(const Problem& problem, std::uint64_t seed, WideCounts& counts) {
  const TransitionSystem system(problem);
  Expander expander(system);
  if (system.infeasibility() || system.ends(system.start_state()) ||
      expander.legal_actions(system.start_state()).empty())
    return;
  constexpr std::size_t kEpisodes = 4;
  World world(system, kEpisodes, {.autoreset = Autoreset::Off});
  VectorEnvironment& environment = world.environment;
  environment.seed(seed);
  // The states that the Expander walks through by the same actions.
  using Words = std::vector<std::uint64_t>;
  const Words start(system.start_state().begin(), system.start_state().end());
  std::vector<Words> states(kEpisodes, start);
  std::map<std::vector<float>, Words> state_of_observation;
  for (std::size_t s = 0; s < 24; ++s) {
    environment.sample(world.actions);
    std::vector<std::pair<double, Words>> expected;
    for (std::size_t i = 0; i < kEpisodes; ++i) {
      std::set<std::int64_t> legal;
      for (const Action& action : expander.legal_actions(states[i])) {
        const PlanStep step = expander.plan_step(action);
        const std::int64_t number = environment.action_of(step);
        EXPECT_TRUE(legal.insert(number).second) << "two actions have one number";
        const PlanStep back = environment.plan_step(number);
        ASSERT_EQ(back.connections, step.connections);
        ASSERT_EQ(back.direction, step.direction);
        if (number != world.actions[i]) continue;
        Words next(system.words());
        expander.successor(states[i], action, next);
        expected.emplace_back(action.reward, next);
        if (step.direction) ++counts.directions;
        if (step.connections.empty()) ++counts.stopped;
      }
      for (std::size_t a = 0; a < environment.num_actions(); ++a)
        ASSERT_EQ(world.mask(i)[a] != 0, legal.contains(static_cast<std::int64_t>(a)));
      // What is observed is the state.
      const auto [known, is_new] = state_of_observation.emplace(world.observation(i), states[i]);
      ASSERT_EQ(known->second, states[i]);
      const std::vector<float> row = world.observation(i);
      for (std::size_t c = problem.num_connections(); c < row.size(); ++c)
        if (row[c] == 1) ++counts.contexts;
    }
    ASSERT_EQ(expected.size(), kEpisodes);
    world.step();
    std::vector<std::uint8_t> over(kEpisodes, 0);
    for (std::size_t i = 0; i < kEpisodes; ++i) {
      ASSERT_EQ(world.rewards[i], expected[i].first);
      states[i] = expected[i].second;
      ASSERT_EQ(world.terminated[i] != 0, system.ends(states[i]));
      if (world.terminated[i] == 0 && world.truncated[i] == 0) continue;
      over[i] = 1;
      if (world.terminated[i] != 0) {
        ++counts.finished;
        const Evaluation plan = evaluate(system, environment.plan(i));
        ASSERT_TRUE(plan.valid) << plan.violations.front().violation.message;
        ASSERT_TRUE(near(plan.reward, world.returns[i])) << plan.reward << " " << world.returns[i];
        if (!plan.stays.empty()) ++counts.left;
      } else {
        ++counts.dead_ends;
      }
      states[i] = start;
    }
    environment.reset(over, world.buffers());
  }
}

TEST(VectorEnvironment, TakesGoalsAndCostsBetweenSteps) {
  WideCounts counts;
  for (std::uint64_t seed = 0; seed < some_of<std::uint64_t>(600); ++seed) {
    SCOPED_TRACE(seed);
    ProblemSpec spec = wide_random_problem(seed);
    if (spec.action == StepKind::Part) continue;
    const Problem problem(spec);
    ASSERT_NO_FATAL_FAILURE(play_wide(problem, seed, counts));
  }
  EXPECT_GT(counts.finished, more_than<std::size_t>(1000));
  EXPECT_GT(counts.dead_ends, more_than<std::size_t>(10));
  EXPECT_GT(counts.stopped, more_than<std::size_t>(100));
  EXPECT_GT(counts.left, more_than<std::size_t>(100));
  EXPECT_GT(counts.directions, more_than<std::size_t>(100));
  EXPECT_GT(counts.contexts, more_than<std::size_t>(1000));
}

TEST(VectorEnvironment, NamesWhatAContextIs) {
  ProblemSpec spec = instances::chain_of_three();
  spec.connections[0].attributes = {{"tool", "driver"}};
  spec.connections[1].attributes = {{"tool", "pliers"}};
  Changeover change;
  change.attribute = "tool";
  spec.objective = {"changeover", change};
  const Problem problem(spec);
  const TransitionSystem system(problem);
  World world(system, 1);
  EXPECT_EQ(world.environment.observation_size(), 4U);
  EXPECT_EQ(world.environment.column_name(1), "open 2-3");
  EXPECT_EQ(world.environment.column_name(2), "tool driver");
  EXPECT_EQ(world.environment.column_name(3), "tool pliers");
  EXPECT_EQ(world.observation(0), (std::vector<float>{1, 1, 0, 0}));
  world.actions = {0};
  world.step();
  EXPECT_EQ(world.observation(0), (std::vector<float>{0, 1, 1, 0}));
  world.actions = {1};
  world.step();
  EXPECT_EQ(world.rewards, std::vector<double>{-1});
}

}  // namespace
}  // namespace orasp
