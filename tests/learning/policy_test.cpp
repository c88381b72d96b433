// A policy of plain weights as a planner: numbers by hand, any state, any newly forbidden
// connection.

#include "orasp/learning/policy.h"

#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/scenarios.h"
#include "orasp/model/error.h"
#include "orasp/model/random.h"
#include "tests/instances.h"
#include "tests/oracle.h"

namespace orasp {
namespace {

/// Three connections, a hidden layer of two units.
Policy by_hand() {
  Policy policy;
  policy.layers = {
      {.inputs = 3, .outputs = 2, .weights = {1, -1, 2, 0, 3, 1}, .bias = {0.5F, -0.5F}},
      {.inputs = 2, .outputs = 3, .weights = {1, 2, 3, 10, 20, 30}, .bias = {0, 0, 1}}};
  policy.scale = 2;
  return policy;
}

/// Prefers connections in this order, whatever the state.
Policy that_prefers(const std::vector<ConnectionIndex>& order) {
  DenseLayer layer{.inputs = order.size(), .outputs = order.size(), .weights = {}, .bias = {}};
  layer.weights.assign(order.size() * order.size(), 0);
  layer.bias.resize(order.size());
  for (std::size_t rank = 0; rank < order.size(); ++rank)
    layer.bias[order[rank]] = -static_cast<float>(rank);
  return {.layers = {layer}, .scale = 1, .adds_reward = false};
}

TEST(PolicyEvaluator, ForwardByHand) {
  const Policy policy = by_hand();
  PolicyEvaluator evaluator(policy);
  const std::uint64_t first_and_last = 0b101;
  // Hidden: 0.5 + 1 + 3 = 4.5 and -0.5 - 1 + 1 = -0.5, cut to 0. Out: 4.5 * (1, 2, 3) + (0, 0, 1).
  auto out = evaluator.outputs(SetView(&first_and_last, 1));
  EXPECT_EQ(std::vector<float>(out.begin(), out.end()), (std::vector<float>{4.5F, 9, 14.5F}));
  const std::uint64_t last = 0b100;
  // 3.5 and 0.5: 3.5 * (1, 2, 3) + 0.5 * (10, 20, 30) + (0, 0, 1).
  out = evaluator.outputs(SetView(&last, 1));
  EXPECT_EQ(std::vector<float>(out.begin(), out.end()), (std::vector<float>{8.5F, 17, 26.5F}));
}

TEST(PolicyEvaluator, ScalesAndAddsTheStepsReward) {
  Policy policy = by_hand();
  const std::uint64_t state = 0b101;
  const std::vector<Action> actions = {{0, 25}, {2, 1}};
  std::vector<double> values(2);
  PolicyEvaluator(policy).values(SetView(&state, 1), actions, values);
  EXPECT_EQ(values, (std::vector<double>{9, 29}));
  EXPECT_EQ(PolicyEvaluator(policy).choose(SetView(&state, 1), actions), 1U);
  policy.adds_reward = true;
  PolicyEvaluator(policy).values(SetView(&state, 1), actions, values);
  EXPECT_EQ(values, (std::vector<double>{34, 30}));
  EXPECT_EQ(PolicyEvaluator(policy).choose(SetView(&state, 1), actions), 0U);
}

TEST(FollowPolicy, KeepsToTheRulesWhateverThePolicyWants) {
  const Problem problem = load_scenario("lattice");
  const TransitionSystem system(problem);
  SplitMix64 random(1);
  for (int i = 0; i < 20; ++i) {
    std::vector<ConnectionIndex> order;
    for (ConnectionIndex c = 0; c < system.num_connections(); ++c) order.push_back(c);
    for (std::size_t k = order.size(); k > 1; --k) std::swap(order[k - 1], order[random.below(k)]);
    const Result result = follow_policy(system, that_prefers(order), Budget{});
    ASSERT_TRUE(result.has_plan());
    const oracle::OracleReplay replay = oracle::replay(problem.spec(), result.sequence);
    EXPECT_TRUE(replay.valid);
    EXPECT_NEAR(replay.reward, result.reward, 1e-9);
    ASSERT_TRUE(result.bound.has_value());
    EXPECT_GE(*result.bound, 0.0735 - 1e-9);
  }
}

TEST(FollowPolicy, GoesBackFromADeadEnd) {
  // A policy that wants what leads nowhere first.
  const ProblemSpec spec = instances::sandwich();
  const Problem problem(spec);
  const TransitionSystem system(problem);
  const bool feasible = oracle::brute_force(spec).feasible;
  for (const std::vector<ConnectionIndex>& order :
       {std::vector<ConnectionIndex>{0, 1, 2}, {2, 1, 0}, {1, 0, 2}}) {
    if (system.num_connections() != order.size()) continue;
    EXPECT_EQ(follow_policy(system, that_prefers(order), Budget{}).has_plan(), feasible);
  }
}

TEST(FollowPolicy, AnswersFromAnyStateUnderForbiddenConnections) {
  const Problem problem = load_scenario("hubble-free");
  const TransitionSystem system(problem);
  std::vector<ConnectionIndex> order;
  for (ConnectionIndex c = 0; c < system.num_connections(); ++c) order.push_back(c);
  const Policy policy = that_prefers(order);
  ConnectionSet from = system.start();
  from.erase(0);
  from.erase(5);
  ConnectionSet forbidden(system.num_connections());
  forbidden.insert(1);
  forbidden.insert(5);  // no longer there: forbidding it means nothing
  const Result result = follow_policy(system, policy, from, forbidden, Budget{});
  ASSERT_TRUE(result.has_plan());
  ASSERT_EQ(result.sequence.size(), system.num_connections() - 3);
  EXPECT_EQ(result.sequence.front(), 2U);
  for (const ConnectionIndex c : result.sequence) {
    EXPECT_NE(c, 0U);
    EXPECT_NE(c, 1U);
    EXPECT_NE(c, 5U);
  }
}

TEST(FollowPolicy, RefusesAPolicyOfAnotherSize) {
  const Problem problem = load_scenario("lattice");
  const TransitionSystem system(problem);
  EXPECT_THROW(static_cast<void>(follow_policy(system, that_prefers({0, 1, 2}), Budget{})),
               InputError);
}

/// Of pieces: what the evaluator says is what the network says of the same steps, and a policy for
/// another problem is refused.
TEST(PolicyEvaluator, AnswersForPieces) {
  const Problem problem = load_scenario("lattice");
  const TransitionSystem system(problem);
  Policy policy{.layers = {},
                .pieces = PiecePolicy{.connections = problem.num_connections(),
                                      .hidden = {4},
                                      .weights = std::vector<float>(PiecePolicy::num_weights({4}))},
                .scale = 2,
                .adds_reward = true};
  EXPECT_EQ(policy.num_connections(), problem.num_connections());
  EXPECT_FALSE(policy.empty());
  EXPECT_TRUE(Policy().empty());
  EXPECT_THROW(PolicyEvaluator{policy}, InputError);
  PolicyEvaluator evaluator(policy, system);
  Expander expander(system);
  const auto legal = expander.legal_actions(system.start().view());
  const std::vector<Action> actions(legal.begin(), legal.end());
  std::vector<double> values(actions.size());
  evaluator.values(system.start().view(), actions, values);
  for (std::size_t i = 0; i < actions.size(); ++i) EXPECT_EQ(values[i], actions[i].reward);
  // A number of 0.5 for each piece that is there: all steps that separate nothing leave one.
  const std::size_t linear = PiecePolicy::num_weights({4}) - PiecePolicy::kStep -
                             PiecePolicy::kFeatures * PiecePolicy::kOutputs;
  policy.pieces->weights[linear] = 0.5F;
  evaluator.values(system.start().view(), actions, values);
  for (std::size_t i = 0; i < actions.size(); ++i)
    EXPECT_EQ(values[i], actions[i].reward + 2 * 0.5);
  const Problem other = load_scenario("4brick");
  const TransitionSystem small(other);
  EXPECT_THROW(follow_policy(small, policy, Budget{}), InputError);
}

}  // namespace
}  // namespace orasp
