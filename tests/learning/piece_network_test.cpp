// The network over pieces: what it sees against flood fill, its slopes, and training that learns.

#include "orasp/learning/piece_network.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/io/objective_json.h"
#include "orasp/io/policy_file.h"
#include "orasp/io/problem_source.h"
#include "orasp/io/scenarios.h"
#include "orasp/learning/dqn.h"
#include "orasp/model/error.h"
#include "orasp/model/random.h"
#include "orasp/model/validate.h"
#include "orasp/planners/automatic.h"
#include "orasp/planners/greedy.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

constexpr std::size_t kFeatures = PiecePolicy::kFeatures;
using Row = std::vector<float>;

PiecePolicy random_policy(std::size_t connections, bool of_rewards, std::uint64_t seed) {
  PiecePolicy policy{.connections = connections,
                     .hidden = {7, 5},
                     .of_rewards = of_rewards,
                     .weights = std::vector<float>(PiecePolicy::num_weights({7, 5}))};
  SplitMix64 random(seed);
  for (float& weight : policy.weights) weight = static_cast<float>(2 * random.uniform() - 1);
  return policy;
}

/// The features of one piece by their definition: parts as they hang together, and the connections
/// within.
Row features_by_hand(const Problem& problem, const std::set<PartIndex>& parts,
                     const ConnectionSet& present) {
  double mass = 0;
  double total = 0;
  for (const Part& part : problem.parts()) total += part.mass;
  std::map<PartIndex, double> degree;
  bool base = false;
  for (const PartIndex p : parts) {
    mass += problem.parts()[p].mass;
    degree[p] = 0;
    base = base || problem.in_base(p);
  }
  double connections = 0;
  for_each_connection(present.view(), [&](ConnectionIndex c) {
    const auto& [a, b] = problem.ends(c);
    if (a == b || !parts.contains(a)) return;
    connections += 1;
    degree[a] += 1;
    degree[b] += 1;
  });
  double leaves = 0;
  double squares = 0;
  for (const auto& [part, many] : degree) {
    leaves += many == 1 ? 1 : 0;
    squares += many * many;
  }
  const auto n = static_cast<double>(parts.size());
  const double cycles = connections - n + 1;
  const double star = n * (n - 1);
  const auto all_parts = static_cast<double>(problem.num_parts());
  const std::vector<double> numbers = {
      1,
      n / all_parts,
      connections / static_cast<double>(problem.num_connections()),
      std::log2(n) / 4,
      std::log2(1 + connections) / 4,
      std::log2(1 + cycles) / 4,
      n == 1 ? 1.0 : 0.0,
      n == 2 ? 1.0 : 0.0,
      n == 3 ? 1.0 : 0.0,
      n == 4 ? 1.0 : 0.0,
      n == 5 ? 1.0 : 0.0,
      n == 6 ? 1.0 : 0.0,
      leaves / n,
      n > 1 ? squares / star : 0.0,
      n > 2 && cycles == 0 && squares == star ? 1.0 : 0.0,
      cycles == 0 ? 1.0 : 0.0,
      cycles == 1 ? 1.0 : 0.0,
      total > 0 ? mass / total : 0.0,
      total > 0 ? std::min(4.0, mass / n * all_parts / total) : 0.0,
      base ? 1.0 : 0.0};
  return {numbers.begin(), numbers.end()};
}

std::set<PartIndex> piece_of(const Problem& problem, const ConnectionSet& present, PartIndex from) {
  std::set<PartIndex> piece = {from};
  for (bool grows = true; grows;) {
    grows = false;
    for_each_connection(present.view(), [&](ConnectionIndex c) {
      const auto& [a, b] = problem.ends(c);
      if (piece.contains(a) == piece.contains(b)) return;
      piece.insert(a);
      piece.insert(b);
      grows = true;
    });
  }
  return piece;
}

/// Rows as they stand, so that they can be compared whatever their order: rounded, since sums of
/// masses may differ in their last digits.
std::multiset<std::vector<long>> rounded(const std::vector<Row>& rows) {
  std::multiset<std::vector<long>> all;
  for (const Row& row : rows) {
    std::vector<long> one;
    for (const float number : row) one.push_back(std::lround(1e4 * static_cast<double>(number)));
    all.insert(one);
  }
  return all;
}

std::vector<Row> pieces_by_hand(const Problem& problem, const ConnectionSet& present) {
  std::vector<Row> rows;
  std::set<PartIndex> seen;
  for (std::size_t p = 0; p < problem.num_parts(); ++p) {
    const auto part = static_cast<PartIndex>(p);
    if (seen.contains(part)) continue;
    const std::set<PartIndex> piece = piece_of(problem, present, part);
    seen.insert(piece.begin(), piece.end());
    if (piece.size() > 1) rows.push_back(features_by_hand(problem, piece, present));
  }
  return rows;
}

/// What the observer says is there after a step, and what is: on random problems of both
/// directions, every open connection of states on random walks.
TEST(PieceObserver, SeesThePiecesThatAStepLeaves) {
  std::size_t separations = 0;
  std::size_t joins = 0;
  for (std::uint64_t seed = 0; seed < some_of<std::uint64_t>(400); ++seed) {
    const Problem problem(random_problem(seed));
    const TransitionSystem system(problem);
    if (system.wide() || system.num_connections() == 0) continue;
    PieceObserver observer(system);
    SplitMix64 random(seed);
    ConnectionSet open = system.start();
    while (!open.empty()) {
      std::vector<ConnectionIndex> connections;
      for_each_connection(open.view(), [&](ConnectionIndex c) { connections.push_back(c); });
      PieceSteps steps;
      observer.describe(open.view(), connections, steps);
      ASSERT_EQ(steps.steps.size(), connections.size());
      for (std::size_t i = 0; i < connections.size(); ++i) {
        const PieceSteps::Step& step = steps.steps[i];
        std::vector<std::uint32_t> numbers(steps.pieces);
        for (const std::uint32_t row : step.before) {
          if (row == PieceSteps::kNone) continue;
          const auto found = std::ranges::find(numbers, row);
          ASSERT_NE(found, numbers.end()) << "a piece goes that was not there";
          numbers.erase(found);
        }
        for (const std::uint32_t row : step.after) {
          if (row != PieceSteps::kNone) numbers.push_back(row);
        }
        const auto row_at = [&](std::uint32_t row) {
          const auto begin = steps.rows.begin() + static_cast<std::ptrdiff_t>(row * kFeatures);
          return Row(begin, begin + kFeatures);
        };
        std::vector<Row> rows;
        for (const std::uint32_t row : numbers) rows.push_back(row_at(row));
        ConnectionSet after = open;
        after.erase(connections[i]);
        const ConnectionSet present = system.present(after.view());
        EXPECT_EQ(rounded(rows), rounded(pieces_by_hand(problem, present))) << "seed " << seed;

        // The two sides, where the step separates (or joins).
        Expander expander(system);
        const Step said = expander.step(open.view(), connections[i]);
        EXPECT_EQ(said.separates, step.sides[0] != PieceSteps::kNone) << "seed " << seed;
        EXPECT_EQ(said.completes, step.last && !system.completes_first()) << "seed " << seed;
        if (!said.separates) continue;
        ++(system.takes_apart() ? separations : joins);
        const ConnectionSet apart = system.takes_apart() ? present : system.present(open.view());
        const auto side = [&](const std::vector<PartIndex>& parts) {
          return features_by_hand(problem, {parts.begin(), parts.end()}, apart);
        };
        EXPECT_EQ(rounded({row_at(step.sides[0]), row_at(step.sides[1])}),
                  rounded({side(said.a), side(said.b)}))
            << "seed " << seed;
      }
      open.erase(connections[random.below(connections.size())]);
    }
  }
  EXPECT_GE(separations, least_of<std::size_t>(1000));
  EXPECT_GE(joins, least_of<std::size_t>(1000));
}

/// A step's number depends on nothing but the pieces that are there afterwards: two orders of the
/// same steps end at the same number.
TEST(PieceNetwork, TheNumberIsThatOfWhatIsLeft) {
  const Problem problem = load_scenario("hubble-upc");
  const TransitionSystem system(problem);
  PieceObserver observer(system);
  PieceEvaluator evaluator;
  const PiecePolicy policy = random_policy(problem.num_connections(), false, 1);
  SplitMix64 random(2);
  const auto number = [&](ConnectionSet open, ConnectionIndex c) {
    PieceSteps steps;
    observer.describe(open.view(), std::span(&c, 1), steps);
    return evaluator.numbers(policy, steps)[0];
  };
  for (int i = 0; i < 200; ++i) {
    ConnectionSet open = system.start();
    for (std::size_t c = 0; c < problem.num_connections(); ++c) {
      if (random.uniform() < 0.4) open.erase(static_cast<ConnectionIndex>(c));
    }
    std::vector<ConnectionIndex> left;
    for_each_connection(open.view(), [&](ConnectionIndex c) { left.push_back(c); });
    if (left.size() < 3) continue;
    const ConnectionIndex first = left[random.below(left.size())];
    const ConnectionIndex second = left[random.below(left.size())];
    if (first == second) continue;
    ConnectionSet one = open;
    one.erase(first);
    ConnectionSet other = open;
    other.erase(second);
    EXPECT_NEAR(number(one, second), number(other, first), 1e-3);
  }
}

TEST(PieceNetwork, SlopesAreThoseOfTheNumbers) {
  for (const bool of_rewards : {false, true}) {
    const Problem problem = load_scenario("lattice");
    const TransitionSystem system(problem);
    PieceObserver observer(system);
    PieceSteps steps;
    ConnectionSet open = system.start();
    std::vector<ConnectionIndex> all;
    for_each_connection(open.view(), [&](ConnectionIndex c) { all.push_back(c); });
    observer.describe(open.view(), all, steps);
    for (std::size_t i = 0; i + 1 < all.size(); ++i) open.erase(all[i]);
    observer.describe(open.view(), std::span(all).last(1), steps);  // the last step of all
    PiecePolicy policy = random_policy(problem.num_connections(), of_rewards, 3);
    std::vector<float> slope(steps.steps.size());
    SplitMix64 random(4);
    for (float& number : slope) number = static_cast<float>(random.uniform() - 0.5);
    PieceEvaluator evaluator;
    std::vector<float> gradient(policy.weights.size());
    static_cast<void>(evaluator.numbers(policy, steps));
    evaluator.backward(policy, steps, slope, gradient);
    const auto sum = [&](const PiecePolicy& asked) {
      const std::span<const float> numbers = evaluator.numbers(asked, steps);
      double total = 0;
      for (std::size_t i = 0; i < slope.size(); ++i)
        total += static_cast<double>(numbers[i]) * static_cast<double>(slope[i]);
      return total;
    };
    for (std::size_t w = 0; w < policy.weights.size(); ++w) {
      constexpr float kMove = 2e-3F;
      PiecePolicy more = policy;
      PiecePolicy less = policy;
      more.weights[w] += kMove;
      less.weights[w] -= kMove;
      const double expected = (sum(more) - sum(less)) / (2 * static_cast<double>(kMove));
      EXPECT_NEAR(static_cast<double>(gradient[w]), expected,
                  0.02 * std::max(1.0, std::abs(expected)))
          << "weight " << w << (of_rewards ? ", of rewards" : "");
    }
  }
}

/// One gradient step by hand is not worth more than this: steps towards a target come nearer, the
/// slow copy follows at its rate, and another network goes on from the state as the first does.
TEST(PieceNetwork, LearnsAndRestores) {
  const Problem problem = load_scenario("lattice");
  const TransitionSystem system(problem);
  NetworkOptions options;
  options.connections = problem.num_connections();
  options.hidden = {8};
  options.target_rate = 0.25;
  options.learning_rate = 0.01;
  PieceNetwork first(system, options, true);
  options.seed = 2;
  PieceNetwork second(system, options, true);
  const std::size_t n = options.connections;
  const std::vector<float> states(n, 1.0F);
  const std::vector<std::int64_t> actions = {3};
  const std::vector<float> targets = {2.5F};
  std::vector<float> values(n);
  first.values(states, values);
  EXPECT_EQ(values, std::vector<float>(n, 0.0F)) << "untrained it prefers nothing";
  EXPECT_NEAR(first.learn(states, actions, targets), 2.0, 1e-6) << "smooth L1 of 2.5";
  first.values(states, values);
  std::vector<float> slow(n);
  first.target_values(states, slow);
  EXPECT_GT(values[3], slow[3]);
  EXPECT_GT(slow[3], 0);
  double loss = 2;
  for (int i = 0; i < 200; ++i) loss = first.learn(states, actions, targets);
  EXPECT_LT(loss, 1e-3);
  second.restore(first.state());
  EXPECT_EQ(first.policy(), second.policy());
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(first.learn(states, actions, targets), second.learn(states, actions, targets));
  EXPECT_EQ(first.state(), second.state());
  std::vector<float> state = first.state();
  state.pop_back();
  EXPECT_THROW(second.restore(state), InputError);
}

/// Chains whose pieces of two parts are dear, of four cheap: greedy takes ends off and comes to
/// pieces of two at once, the best plans halve.
Problem halving(const std::string& name) {
  ProblemEdits edits;
  edits.objective = parse_objective(
      "{\"type\":\"expression\",\"formula\":\"-separates*(moved_parts+kept_parts)\"}", "");
  return edited(find_problem(name), edits);
}

DqnOptions over_pieces() {
  DqnOptions options;
  options.inputs = NetworkInputs::Pieces;
  options.stop_when_proved = false;
  options.seed = 3;
  return options;
}

/// What a training must reach that learns from experience alone: with and without the steps' own
/// rewards, from a policy that is far off (greedy earns less than half).
TEST(TrainOverPieces, EndsFarAboveWhereItBegan) {
  for (const bool known : {true, false}) {
    SCOPED_TRACE(known ? "rewards known" : "rewards not known");
    const Problem problem = halving("chain:16");
    const TransitionSystem system(problem);
    const double optimum = automatic(system, 0, {}).reward;
    const double quick = greedy(system, {}).reward;
    ASSERT_LT(quick, 1.5 * optimum);
    DqnOptions options = over_pieces();
    options.known_reward = known;
    options.imitation = 0;
    options.returns = false;  // values come from the network alone
    options.episodes = 400;
    std::vector<TrainingRecord> log;
    TrainingHooks hooks;
    hooks.log = [&](const TrainingRecord& record) { log.push_back(record); };
    const Training training = train(system, options, Budget{}, hooks);
    const TrainingRecord& last = training.record;
    EXPECT_NEAR(last.greedy, optimum, 1e-9) << "the network at the end, not the best one";
    EXPECT_LT(log.front().greedy, optimum - 0.5) << "least squares alone would not do";
    EXPECT_LE(last.greedy, last.best_greedy);
    EXPECT_LE(last.best_greedy, optimum + 1e-9);
    ASSERT_GE(log.size(), 20U);
    const auto mean_loss = [&](std::size_t from, std::size_t to) {
      double sum = 0;
      for (std::size_t i = from; i < to; ++i) sum += log[i].loss;
      return sum / static_cast<double>(to - from);
    };
    EXPECT_LT(mean_loss(log.size() - log.size() / 10, log.size()), mean_loss(0, log.size() / 10));

    const Result followed = follow_policy(system, training.trained.policy, Budget{});
    EXPECT_EQ(followed.reward, training.trained.reward);
    EXPECT_TRUE(evaluate(problem, std::span<const ConnectionIndex>(followed.sequence)).valid);
    // The same seed, the same run; another seed, another.
    options.episodes = 120;
    const Training once = train(system, options, Budget{});
    const Training again = train(system, options, Budget{});
    EXPECT_EQ(once.trained.policy, again.trained.policy);
    EXPECT_EQ(once.trained.training.network, again.trained.training.network);
    options.seed = 4;
    EXPECT_NE(train(system, options, Budget{}).trained.policy, once.trained.policy);
  }
}

/// Nothing is kept that is worse than the plan that takes the best step each time.
TEST(TrainOverPieces, KeepsNothingWorseThanGreedy) {
  for (const char* name : {"hubble-upc", "lattice", "tree:20:4"}) {
    const Problem problem = load_scenario(name);
    const TransitionSystem system(problem);
    DqnOptions options = over_pieces();
    options.episodes = 72;
    EXPECT_GE(train(system, options, Budget{}).trained.reward, greedy(system, {}).reward) << name;
  }
}

TEST(TrainOverPieces, GoesOnWhereItStopped) {
  const Problem problem = load_scenario("lattice");
  const TransitionSystem system(problem);
  DqnOptions options = over_pieces();
  options.episodes = 104;
  const Training first = train(system, options, Budget{});
  const PolicyFile read = parse_policy(
      policy_bytes({.problem_digest = "abc", .problem_name = "lattice", .trained = first.trained}));
  EXPECT_EQ(read.trained.policy, first.trained.policy);
  EXPECT_EQ(read.trained.training.network, first.trained.training.network);
  options.episodes = 160;
  const Training second = train(system, options, Budget{}, {}, &read.trained);
  EXPECT_EQ(second.record.episodes, 160U);
  EXPECT_GT(second.record.updates, first.record.updates);
  EXPECT_GE(second.trained.reward, first.trained.reward);
  options.inputs = NetworkInputs::Connections;
  options.hidden = {32, 32};
  EXPECT_THROW(train(system, options, Budget{}, {}, &read.trained), InputError);
}

/// Every kind of problem: plans are legal, and both directions train.
TEST(TrainOverPieces, TrainsOnRandomProblems) {
  std::size_t trained = 0;
  for (std::uint64_t seed = 0; seed < some_of<std::uint64_t>(60); ++seed) {
    const Problem problem(random_problem(seed));
    const TransitionSystem system(problem);
    if (system.wide() || system.num_connections() < 3) continue;
    DqnOptions options = over_pieces();
    options.episodes = 72;
    options.known_reward = seed % 2 == 0;
    const Training training = train(system, options, Budget{});
    if (!training.result.has_plan()) continue;
    const auto& plan = training.result.sequence;
    EXPECT_TRUE(evaluate(problem, std::span<const ConnectionIndex>(plan)).valid) << "seed " << seed;
    if (training.trained.policy.empty()) continue;
    ++trained;
    EXPECT_EQ(follow_policy(system, training.trained.policy, Budget{}).has_plan(), true);
  }
  EXPECT_GE(trained, least_of<std::size_t>(10));
}

TEST(RestLimits, NoPlanEarnsMoreOrLess) {
  std::size_t finite = 0;
  for (std::uint64_t seed = 0; seed < some_of<std::uint64_t>(300); ++seed) {
    const Problem problem(random_problem(seed));
    const TransitionSystem system(problem);
    if (system.wide() || system.num_connections() == 0) continue;
    const RestLimits limits = rest_limits(system);
    ASSERT_EQ(limits.least.size(), problem.num_connections() + 1);
    Expander expander(system);
    SplitMix64 random(seed);
    ConnectionSet open = system.start();
    std::vector<double> rewards;
    while (!open.empty()) {
      const auto actions = expander.legal_actions(open.view());
      if (actions.empty()) break;
      const Action action = actions[random.below(actions.size())];
      rewards.push_back(action.reward);
      open.erase(action.connection);
    }
    if (!open.empty()) continue;
    double rest = 0;
    for (std::size_t k = 1; k <= rewards.size(); ++k) {
      rest += rewards[rewards.size() - k];
      EXPECT_LE(rest, limits.greatest[k] + 1e-9) << "seed " << seed;
      EXPECT_GE(rest, limits.least[k] - 1e-9) << "seed " << seed;
      finite += std::isfinite(limits.greatest[k]) && std::isfinite(limits.least[k]) ? 1 : 0;
    }
  }
  EXPECT_GE(finite, least_of<std::size_t>(500));
}

}  // namespace
}  // namespace orasp
