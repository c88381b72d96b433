// Targets on numbers worked out by hand; training with libtorch, where this build has it.

#include "orasp/learning/dqn.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/scenarios.h"
#include "orasp/learning/environment.h"
#include "orasp/learning/network.h"
#include "orasp/learning/replay_buffer.h"
#include "orasp/model/error.h"
#include "orasp/model/random.h"
#include "orasp/model/validate.h"
#include "orasp/planners/random_sequence.h"
#include "tests/instances.h"
#include "tests/oracle.h"

namespace orasp {
namespace {

/// Three steps over three connections. Rewards taken: -1, -2, -4. In the second state (0 and 2
/// open) 0 earns -2 and 2 earns -3; in the third only 2 is open and earns -4.
ReplayBuffer memory(bool dead_end = false) {
  ReplayBuffer::Episode steps(3);
  ConnectionSet open = ConnectionSet::all(3);
  steps.push(open.view(), std::vector<Action>{{0, -5}, {1, -1}, {2, -5}}, 1);
  open.erase(1);
  steps.push(open.view(), std::vector<Action>{{0, -2}, {2, -3}}, 0);
  open.erase(0);
  if (!dead_end) steps.push(open.view(), std::vector<Action>{{2, -4}}, 0);
  ReplayBuffer buffer(8, 3);
  buffer.add(steps, dead_end);
  return buffer;
}

DqnOptions plain() {
  DqnOptions options;
  options.n_step = 1;
  options.double_q = false;
  options.returns = false;
  options.known_reward = false;
  return options;
}

constexpr std::array<float, 3> kOnline = {1, 100,
                                          3};  // connection 1 is gone: its 100 must not count
constexpr std::array<float, 3> kTarget = {7, 100, 5};
constexpr std::array<float, 3> kNothing = {0, 0, 0};

TEST(TargetRule, RewardPlusTheMaximumOverLegalActions) {
  const ReplayBuffer replay = memory();
  const TargetRule rule(plain(), 1, {});
  ASSERT_EQ(rule.asked(replay, 0), 1U);
  EXPECT_FLOAT_EQ(rule.target(replay, 0, kOnline, kTarget), -1 + 7);
  EXPECT_FALSE(rule.asked(replay, 2).has_value()) << "the last step asks nobody";
  EXPECT_FLOAT_EQ(rule.target(replay, 2, {}, {}), -4);
}

TEST(TargetRule, DoubleQTakesTheNetworksChoiceAtTheTargetNetworksValue) {
  const ReplayBuffer replay = memory();
  DqnOptions options = plain();
  options.double_q = true;
  EXPECT_FLOAT_EQ(TargetRule(options, 1, {}).target(replay, 0, kOnline, kTarget), -1 + 5);
}

TEST(TargetRule, KnownRewardsAreAddedToTheNetworksNumbers) {
  const ReplayBuffer replay = memory();
  DqnOptions options = plain();
  options.known_reward = true;
  // In the second state 0 is worth 7 - 2 and 2 is worth 5 - 3; the step's own -1 is not learned.
  EXPECT_FLOAT_EQ(TargetRule(options, 1, {}).target(replay, 0, kOnline, kTarget), 5);
  EXPECT_FLOAT_EQ(TargetRule(options, 1, {}).target(replay, 2, {}, {}), 0);
}

TEST(TargetRule, DiscountAndSeveralSteps) {
  const ReplayBuffer replay = memory();
  DqnOptions options = plain();
  options.discount = 0.5;
  EXPECT_FLOAT_EQ(TargetRule(options, 1, {}).target(replay, 0, kOnline, kTarget), -1 + 0.5F * 7);
  options.n_step = 2;
  const TargetRule two(options, 1, {});
  ASSERT_EQ(two.asked(replay, 0), 2U);
  EXPECT_FLOAT_EQ(two.target(replay, 0, kOnline, kTarget), -1 - 0.5F * 2 + 0.25F * 5);
  EXPECT_FALSE(two.asked(replay, 1).has_value());
  EXPECT_FLOAT_EQ(two.target(replay, 1, {}, {}), -2 - 0.5F * 4);
  options.n_step = 0;  // all of the episode
  EXPECT_FALSE(TargetRule(options, 1, {}).asked(replay, 0).has_value());
  EXPECT_FLOAT_EQ(TargetRule(options, 1, {}).target(replay, 0, {}, {}), -1 - 1 - 1);
}

TEST(TargetRule, NeverBelowWhatTheEpisodeEarned) {
  const ReplayBuffer replay = memory();
  DqnOptions options = plain();
  options.returns = true;
  const std::array<float, 3> low = {-50, 0, -60};
  EXPECT_FLOAT_EQ(TargetRule(options, 1, {}).target(replay, 0, low, low), -7);
  options.returns = false;
  EXPECT_FLOAT_EQ(TargetRule(options, 1, {}).target(replay, 0, low, low), -51);
}

TEST(TargetRule, CentredAndScaled) {
  const ReplayBuffer replay = memory();
  const std::vector<double> baseline = {0, -4, -6, -10};
  const TargetRule rule(plain(), 2, baseline);
  EXPECT_DOUBLE_EQ(rule.value_of(1.5, 2), 2 * 1.5 - 6);
  EXPECT_DOUBLE_EQ(rule.number_of(rule.value_of(1.5, 2), 2), 1.5);
  // Best in the second state: 2 * 7 - 6 = 8; the target -1 + 8 in units of 2 above -10.
  EXPECT_FLOAT_EQ(rule.target(replay, 0, kOnline, kTarget), (7 + 10) / 2.0F);
  DqnOptions options = plain();
  options.known_reward = true;
  const TargetRule known(options, 2, baseline);
  // There 2 * 7 - 4 - 2 = 8; the rest after the step, in units of 2 above -6.
  EXPECT_FLOAT_EQ(known.target(replay, 0, kOnline, kTarget), (8 + 6) / 2.0F);
}

/// What the network says of the next state is cut to what rewards allow: neither runs away.
TEST(TargetRule, OverPiecesKeepsToWhatRewardsAllow) {
  const ReplayBuffer replay = memory();
  DqnOptions options = plain();
  options.inputs = NetworkInputs::Pieces;
  const RestLimits limits{{0, -1000, -1000, -1000}, {0, 5, 6.5, 8}};
  const auto target_of = [&](double scale, const RestLimits& cut, std::span<const float> says) {
    return TargetRule(options, scale, {0, 0, 0, 0}, cut).target(replay, 0, says, says);
  };
  // In the second state, of two open connections, the network says 7, more than the 6.5 allowed.
  EXPECT_FLOAT_EQ(target_of(1, limits, kTarget), -1 + 6.5F);
  const std::array<float, 3> low = {-50, 0, -60};
  const RestLimits narrow{{0, -6, -12, -18}, {0, 5, 6.5, 8}};
  EXPECT_FLOAT_EQ(target_of(1, narrow, low), -1 - 12);
  // Not below the least either, but where a dead end is worth less: ten times the scale.
  EXPECT_DOUBLE_EQ(TargetRule(options, 3, {0, 0, 0, 0}).dead_end(2), -30);
  EXPECT_FLOAT_EQ(target_of(3, narrow, low), (-1 - 30) / 3.0F);
  options.discount = 0.5;  // the limits are those of sums
  EXPECT_FLOAT_EQ(target_of(1, limits, kTarget), -1 + 0.5F * 7);
}

/// Over pieces a target's own rewards end at the next random step, and nothing is centred.
TEST(TargetRule, OverPiecesTheEpisodeCountsUpToARandomStep) {
  for (const bool random : {false, true}) {
    ReplayBuffer::Episode steps(3);
    ConnectionSet open = ConnectionSet::all(3);
    steps.push(open.view(), std::vector<Action>{{0, -5}, {1, -1}, {2, -5}}, 1, true);
    open.erase(1);
    steps.push(open.view(), std::vector<Action>{{0, -2}, {2, -3}}, 0, random);
    open.erase(0);
    steps.push(open.view(), std::vector<Action>{{2, -4}}, 0);
    ReplayBuffer replay(8, 3);
    replay.add(steps, false);
    DqnOptions options = plain();
    options.n_step = 0;
    options.inputs = NetworkInputs::Pieces;
    const TargetRule rule(options, 2, {0, -4, -6, -10});
    EXPECT_DOUBLE_EQ(rule.value_of(1.5, 2), 3) << "the baseline is for dead ends alone";
    if (random) {
      ASSERT_EQ(rule.asked(replay, 0), 1U);
      EXPECT_FLOAT_EQ(rule.target(replay, 0, kOnline, kTarget), (-1 + 2 * 7) / 2.0F);
    } else {
      EXPECT_FALSE(rule.asked(replay, 0).has_value());
      EXPECT_FLOAT_EQ(rule.target(replay, 0, {}, {}), (-1 - 2 - 4) / 2.0F);
    }
  }
}

TEST(TargetRule, ADeadEndIsWorseThanAnythingSeen) {
  const ReplayBuffer replay = memory(true);
  DqnOptions options = plain();
  options.returns = true;  // what a failed episode earned is no lower bound
  const std::vector<double> baseline = {0, -4, -6, -10};
  const TargetRule rule(options, 2, baseline);
  EXPECT_DOUBLE_EQ(rule.dead_end(1), -4 - 10 * 2);
  EXPECT_FLOAT_EQ(rule.target(replay, 1, {}, {}), static_cast<float>((-2 - 24 + 6) / 2.0));
}

TEST(Train, RefusesValuesThatMakeNoSense) {
  const Problem problem(instances::greedy_trap());
  const TransitionSystem system(problem);
  DqnOptions options;
  options.discount = 1.5;
  EXPECT_THROW(train(system, options, Budget{}), InputError);
  options = {};
  options.learning_rate = 0;
  EXPECT_THROW(train(system, options, Budget{}), InputError);
}

TEST(Train, RefusesANetworkThatDoesNotFit) {
  const Problem problem = load_scenario("chain:3000");
  const TransitionSystem system(problem);
  Budget budget;
  budget.max_bytes = std::uint64_t{64} << 20;
  DqnOptions options;
  options.inputs = NetworkInputs::Connections;
  EXPECT_THROW(train(system, options, budget), InputError);
}

// One process: libtorch takes 0.6 s to load.
class WithNetwork : public testing::Test {
 protected:
  void SetUp() override {
    if (!network_available()) GTEST_SKIP() << "built without libtorch";
  }
};

/// The loss and one step by hand: two inputs, no hidden layer, outputs at 0, so y = 0.
void learn_by_hand() {
  NetworkOptions options;
  options.connections = 2;
  options.target_rate = 0.25;
  options.learning_rate = 0.1;
  const auto network = make_network(options);
  const std::vector<float> states = {1, 0, 1, 1};
  std::vector<float> values(4, -1);
  network->values(states, values);
  EXPECT_EQ(values, (std::vector<float>{0, 0, 0, 0}));
  // Smooth L1 of 3 is 2.5, of 0.5 is 0.125.
  const std::vector<std::int64_t> actions = {1, 0};
  const std::vector<float> targets = {3, -0.5F};
  EXPECT_NEAR(network->learn(states, actions, targets), (2.5 + 0.125) / 2, 1e-6);
  // AdamW's first step is the learning rate towards the gradient's sign.
  network->values(states, values);
  EXPECT_NEAR(values[1], 0.2, 1e-3) << "bias and one weight, 0.1 each";
  EXPECT_NEAR(values[2], -0.3, 1e-3) << "bias and two weights";
  std::vector<float> slow(4);
  network->target_values(states, slow);
  EXPECT_NEAR(slow[1], 0.25 * 0.2, 1e-3);
  // What a policy holds answers the same.
  Policy policy{.layers = network->layers(), .scale = 1, .adds_reward = false};
  PolicyEvaluator evaluator(policy);
  const std::uint64_t first_only = 1;
  const auto plain_values = evaluator.outputs(SetView(&first_only, 1));
  EXPECT_NEAR(plain_values[0], values[0], 1e-6);
  EXPECT_NEAR(plain_values[1], values[1], 1e-6);
}

/// Another network goes on from the state as the first does.
void restore() {
  NetworkOptions options;
  options.connections = 5;
  options.hidden = {7, 6};
  options.zero_outputs = false;
  const auto first = make_network(options);
  options.seed = 2;
  const auto second = make_network(options);
  EXPECT_NE(first->layers(), second->layers());
  const std::vector<float> states = {1, 0, 1, 1, 0};
  const std::vector<std::int64_t> actions = {2};
  const std::vector<float> targets = {1};
  for (int i = 0; i < 3; ++i) first->learn(states, actions, targets);
  second->restore(first->state());
  EXPECT_EQ(first->layers(), second->layers());
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(first->learn(states, actions, targets), second->learn(states, actions, targets));
  EXPECT_EQ(first->state(), second->state());
  std::vector<float> state = first->state();
  state.pop_back();
  EXPECT_THROW(second->restore(state), InputError);
}

/// Both networks of two hidden layers answer as a policy does.
void policy_answers_as_the_network() {
  NetworkOptions options;
  options.connections = 9;
  options.hidden = {16, 12};
  options.zero_outputs = false;
  const auto network = make_network(options);
  const Policy policy{.layers = network->layers(), .scale = 1, .adds_reward = false};
  PolicyEvaluator evaluator(policy);
  std::vector<float> row(9);
  std::vector<float> values(9);
  for (std::uint64_t set = 1; set < 512; set += 37) {
    for (std::size_t c = 0; c < 9; ++c) row[c] = static_cast<float>(set >> c & 1U);
    network->values(row, values);
    const auto answers = evaluator.outputs(SetView(&set, 1));
    for (std::size_t c = 0; c < 9; ++c) EXPECT_NEAR(values[c], answers[c], 1e-5);
  }
}

TEST_F(WithNetwork, LearnsByHandRestoresAndAnswers) {
  learn_by_hand();
  restore();
  policy_answers_as_the_network();
  NetworkOptions options;
  options.connections = 2;
  options.device = "tpu";
  EXPECT_THROW(static_cast<void>(make_network(options)), InputError);
}

/// Without the two things that make an untrained network a good planner (the steps' own rewards,
/// and the best episode): what it then does well it has learned.
DqnOptions without_help() {
  DqnOptions options;
  options.seed = 3;
  options.known_reward = false;
  options.imitation = 0;
  return options;
}

/// What sequences from random states of a problem lose against the optimum: mean over `states` of
/// them.
struct Regret {
  double policy = 0;
  double random = 0;  ///< of a random sequence
};
Regret regret(const TransitionSystem& system, const Policy& policy, std::size_t states) {
  const oracle::OracleResult truth = oracle::brute_force(system.problem().spec());
  Environment world(system, 1);
  SplitMix64 random(1);
  const auto play_on = [&](std::size_t until) {
    while (!world.over(0) && world.num_open(0) > until) {
      const auto actions = world.actions(0);
      world.step(0, actions[random.below(actions.size())].connection);
    }
  };
  Regret sum;
  for (std::size_t i = 0; i < states; ++i) {
    world.reset(0);
    play_on(4 + i % (system.num_connections() - 3));
    const ConnectionSet state(system.num_connections(), world.open(0));
    const double best =
        truth.best_to_go.at(oracle::state_of(state.view(), system.num_connections()));
    sum.policy += best - follow_policy(system, policy, state,
                                       ConnectionSet(system.num_connections()), Budget{})
                             .reward;
    const double so_far = world.total(0);
    play_on(0);
    sum.random += best - (world.total(0) - so_far);
  }
  return {sum.policy / static_cast<double>(states), sum.random / static_cast<double>(states)};
}

/// On lattice one random sequence in 26 is optimal, so the best of 100 nearly always is: what
/// counts is what the policy earns from any state. A network that learns nothing, or the wrong
/// thing, does as badly as chance.
TEST_F(WithNetwork, LearnsLattice) {
  const Problem problem = load_scenario("lattice");
  const TransitionSystem system(problem);
  DqnOptions options = without_help();
  options.episodes = 3000;
  options.stop_when_proved = false;
  std::vector<TrainingRecord> log;
  TrainingHooks hooks;
  hooks.log = [&](const TrainingRecord& record) { log.push_back(record); };
  const Training training = train(system, options, Budget{}, hooks);
  EXPECT_NEAR(training.trained.reward, 0.0735, 1e-9);
  EXPECT_EQ(status_name(training.result.status), "optimal") << "it earns the bound";
  const Result followed = follow_policy(system, training.trained.policy, Budget{});
  EXPECT_EQ(followed.reward, training.trained.reward);
  EXPECT_TRUE(evaluate(problem, std::span<const ConnectionIndex>(followed.sequence)).valid);

  const Regret lost = regret(system, training.trained.policy, 200);
  EXPECT_GT(lost.random, 0.1);
  EXPECT_LT(lost.policy, 0.3 * lost.random);
  Policy untrained = training.trained.policy;
  for (DenseLayer& layer : untrained.layers) std::ranges::fill(layer.weights, 0.0F);
  EXPECT_GT(regret(system, untrained, 200).policy, 2 * lost.policy);
  ASSERT_GE(log.size(), 3U);
  EXPECT_GT(log.front().epsilon, log.back().epsilon);
  for (std::size_t i = 1; i < log.size(); ++i) {
    EXPECT_GE(log[i].best_greedy, log[i - 1].best_greedy);
    EXPECT_LE(log[i].best, *log[i].bound + 1e-9);
  }

  // The same seed, the same run; another seed, another.
  const Training again = train(system, options, Budget{});
  EXPECT_EQ(again.trained.policy, training.trained.policy);
  EXPECT_EQ(again.trained.training.network, training.trained.training.network);
  options.seed = 4;
  EXPECT_NE(train(system, options, Budget{}).trained.policy, training.trained.policy);
}

/// 60 % of the way from the best of 100 random sequences to the optimum, and more, within a
/// thousand episodes.
TEST_F(WithNetwork, BeatsTheBestOfAHundredRandomSequences) {
  const Problem problem = load_scenario("hubble-upc");
  const TransitionSystem system(problem);
  double random = -1e9;
  SplitMix64 seeds(1);
  for (int i = 0; i < 100; ++i)
    random = std::max(random, random_sequence(system, {.seed = seeds.next()}, Budget{}).reward);
  DqnOptions options = without_help();
  options.episodes = 1000;
  const Training training = train(system, options, Budget{});
  EXPECT_GT(training.trained.reward, random + 0.6 * (-0.9902 - random));
}

TEST_F(WithNetwork, GoesOnWhereItStopped) {
  const Problem problem = load_scenario("lattice");
  const TransitionSystem system(problem);
  DqnOptions options;
  options.episodes = 160;
  options.stop_when_proved = false;
  const Training first = train(system, options, Budget{});
  EXPECT_EQ(first.record.episodes, 160U);
  options.episodes = 320;
  const Training second = train(system, options, Budget{}, {}, &first.trained);
  EXPECT_EQ(second.record.episodes, 320U);
  EXPECT_GT(second.record.updates, first.record.updates);
  EXPECT_GE(second.trained.reward, first.trained.reward);
  EXPECT_GE(second.result.reward, first.result.reward);
  EXPECT_GE(second.record.seconds, first.record.seconds);

  TrainedPolicy foreign = first.trained;
  std::ranges::fill(foreign.training.best, ConnectionIndex{0});
  EXPECT_THROW(train(system, options, Budget{}, {}, &foreign), InputError);
  foreign = first.trained;
  foreign.training.hidden = {3};
  EXPECT_THROW(train(system, options, Budget{}, {}, &foreign), InputError);
}

TEST_F(WithNetwork, StopsWithTheBestSoFar) {
  const Problem problem = load_scenario("iss");
  const TransitionSystem system(problem);
  Budget budget;
  budget.max_expansions = 5000;
  const Training training = train(system, {}, budget);
  EXPECT_EQ(stop_name(training.result.stop), "expansion limit");
  EXPECT_EQ(status_name(training.result.status), "feasible");
  EXPECT_FALSE(training.trained.policy.empty());
  EXPECT_LE(training.trained.reward, training.result.reward);
}

TEST_F(WithNetwork, EveryVariantTrains) {
  const Problem problem(instances::greedy_trap());
  const TransitionSystem system(problem);
  for (int variant = 0; variant < 7; ++variant) {
    SCOPED_TRACE(variant);
    DqnOptions options;
    options.hidden = {64};
    if (variant == 1) options.double_q = false;
    if (variant == 2) options.n_step = 0;
    if (variant == 3) options.scale = false;
    if (variant == 4) options.curriculum = 0;
    if (variant == 5) options.known_reward = false;
    if (variant == 6) options.returns = false;
    EXPECT_NEAR(train(system, options, Budget{}).trained.reward, 0.5570, 1e-9);
  }
}

}  // namespace
}  // namespace orasp
