// One policy for many products: the network's slopes, learning that carries over to products not
// seen, and files that are refused.

#include "orasp/learning/graph_policy.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/catalogue.h"
#include "orasp/io/graph_policy_file.h"
#include "orasp/io/objective_json.h"
#include "orasp/io/problem_source.h"
#include "orasp/learning/imitation.h"
#include "orasp/model/error.h"
#include "orasp/model/random.h"
#include "orasp/planners/automatic.h"
#include "orasp/planners/greedy.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

/// Cuts that pay for the whole piece: greedy is bad at it, balance is good.
Problem balanced(const std::string& name) {
  ProblemEdits edits;
  edits.objective = parse_objective(
      "{\"type\":\"expression\",\"formula\":\"-separates*(moved_parts+kept_parts)\"}", "");
  return edited(find_problem(name), edits);
}

struct Product {
  Problem problem;
  TransitionSystem system;
  explicit Product(Problem given) : problem(std::move(given)), system(problem) {}
};

std::vector<std::unique_ptr<Product>> products(const std::vector<std::string>& names) {
  std::vector<std::unique_ptr<Product>> all;
  for (const std::string& name : names) all.push_back(std::make_unique<Product>(balanced(name)));
  return all;
}

Imitation imitated(const std::vector<std::unique_ptr<Product>>& all, std::size_t epochs) {
  std::vector<const TransitionSystem*> systems;
  for (const auto& product : all) systems.push_back(&product->system);
  ImitationOptions options;
  options.seed = 3;
  options.states = 12;
  options.most_epochs = epochs;
  return imitate(systems, options, {}, {});
}

GraphState seen_at_start(const TransitionSystem& system) {
  Expander expander(system);
  GraphObserver observer(system);
  const auto legal = expander.legal_actions(system.start().view());
  const std::vector<Action> actions(legal.begin(), legal.end());
  return observer.observe(system.start().view(), actions);
}

TEST(GraphPolicy, UntrainedIsGreedy) {
  for (const char* name : {"tree:12:1", "grid:3x3", "hubble", "iss-upc"}) {
    const Problem problem = find_problem(name);
    const TransitionSystem system(problem);
    const Result mine = follow_graph_policy(system, GraphPolicy::untrained(1), {});
    EXPECT_EQ(mine.sequence, greedy(system, {}).sequence) << name;
  }
}

TEST(GraphPolicy, SlopesAreThoseOfTheWorth) {
  const Product product(balanced("grid:3x4"));
  GraphState state = seen_at_start(product.system);
  state.blocking = state.connected;  // so that messages go along blocking too
  GraphPolicy policy = GraphPolicy::untrained(5);
  SplitMix64 random(6);
  for (float& weight : policy.weights) weight += static_cast<float>(0.6 * (random.uniform() - 0.5));
  GraphNetwork network;
  std::vector<float> slope;
  for (std::size_t i = 0; i < state.num_actions(); ++i)
    slope.push_back(static_cast<float>(random.uniform() - 0.5));
  const auto sum = [&] {
    double total = 0;
    const auto worth = network.worth(policy, state);
    for (std::size_t i = 0; i < worth.size(); ++i) total += double{worth[i]} * slope[i];
    return total;
  };
  static_cast<void>(sum());
  std::vector<float> gradient(policy.weights.size());
  network.backward(policy, state, slope, gradient);
  constexpr float kStep = 1e-3F;
  int checked = 0;
  for (std::size_t w = 0; w < policy.weights.size(); w += 11) {
    const float before = policy.weights[w];
    policy.weights[w] = before + kStep;
    const double above = sum();
    policy.weights[w] = before - kStep;
    const double below = sum();
    policy.weights[w] = before;
    const double expected = (above - below) / (2 * kStep);
    EXPECT_NEAR(gradient[w], expected, 0.02 + 0.05 * std::abs(expected)) << w;
    if (std::abs(expected) > 0.05) ++checked;
  }
  EXPECT_GT(checked, 20);
}

TEST(Imitation, EveryOptimalActionLosesNothing) {
  // Any connection in the middle of a ring of four may be first.
  const Product product(balanced("grid:2x2"));
  const auto states = label_states(product.system, 8, 1, {});
  ASSERT_FALSE(states.empty());
  for (const LabelledState& one : states) {
    EXPECT_EQ(one.loss.size(), one.state.num_actions());
    EXPECT_GE(std::ranges::count(one.loss, 0.0F), 1);
    for (const float loss : one.loss) EXPECT_LE(loss, 1.0F);
  }
}

TEST(Imitation, CarriesOverToProductsNotSeen) {
  const auto seen = products({"tree:8:1", "tree:9:2", "tree:10:3", "tree:11:4", "tree:12:5",
                              "tree:12:6", "tree:13:7", "tree:14:8"});
  const Imitation imitation = imitated(seen, 25);
  double policy = 0;
  double by_greedy = 0;
  double best = 0;
  for (const auto& product : products({"tree:30:21", "tree:36:22", "tree:40:23"})) {
    policy += follow_graph_policy(product->system, imitation.policy, {}).reward;
    by_greedy += greedy(product->system, {}).reward;
    const Result proved = automatic(product->system, 0, {});
    ASSERT_EQ(proved.status, Status::Optimal);
    best += proved.reward;
  }
  EXPECT_LE(policy, best + 1e-9);
  EXPECT_GE(policy, 1.1 * best) << "within 10 % of the proved value (rewards are below 0)";
  EXPECT_LT(by_greedy, 1.1 * best) << "else this shows nothing";
}

TEST(Imitation, TheSameSeedTheSamePolicy) {
  const auto seen = products({"tree:8:1", "tree:9:2", "grid:2x3"});
  EXPECT_EQ(imitated(seen, 3).policy.weights, imitated(seen, 3).policy.weights);
}

TEST(Imitation, LearnsOnFromItsOwnStatesAndFromAnEarlierPolicy) {
  const auto seen = products({"tree:8:1", "tree:9:2", "tree:10:3", "grid:2x4", "grid:3x3"});
  std::vector<const TransitionSystem*> systems;
  for (const auto& product : seen) systems.push_back(&product->system);
  ImitationOptions options;
  options.states = 10;
  options.most_epochs = 6;
  std::vector<ImitationRecord> log;
  const auto note = [&](const ImitationRecord& record) { log.push_back(record); };
  const Imitation first = imitate(systems, options, {}, note);
  const auto own = std::ranges::find(log, true, &ImitationRecord::own);
  ASSERT_NE(own, log.end()) << "it meets its own states";
  EXPECT_GT(own->states, log.front().states);
  EXPECT_GT(own->held_out_states, log.front().held_out_states);
  EXPECT_LE(first.best.held_out_loss, own->held_out_loss) << "never worse by them";

  // The same problems are held out for the same seed, so what was learned is seen again.
  const double untrained = log.front().held_out_loss;
  log.clear();
  const Imitation second = imitate(systems, options, {}, note, &first.policy);
  EXPECT_LT(log.front().held_out_loss, 0.8 * untrained);
  EXPECT_NE(second.policy.weights, GraphPolicy::untrained(options.seed).weights);
  options.most_epochs = 0;
  EXPECT_EQ(imitate(systems, options, {}, {}, &first.policy).policy.weights, first.policy.weights);
}

TEST(Imitation, OwnStatesAreThoseOfThePolicy) {
  // Untrained it is greedy, whose states are not those of the walks else.
  const Product product(balanced("tree:12:5"));
  const GraphPolicy policy = GraphPolicy::untrained(2);
  const auto own = label_states(product.system, 12, 1, {}, &policy);
  const auto others = label_states(product.system, 12, 1, {});
  const auto greedy_choice_is_wrong = [](const LabelledState& one) {
    const auto now = [&](std::size_t i) {
      return one.state.actions[i * GraphState::kActionFeatures];
    };
    std::size_t best = 0;
    for (std::size_t i = 1; i < one.loss.size(); ++i) best = now(i) > now(best) ? i : best;
    return one.loss[best] > 0;
  };
  ASSERT_FALSE(own.empty());
  EXPECT_FALSE(std::ranges::equal(own, others, {}, &LabelledState::loss, &LabelledState::loss));
  EXPECT_GT(std::ranges::count_if(own, greedy_choice_is_wrong), 0);
}

// Both directions, all constraints: the policy is a plan to begin with and proves nothing.
TEST(GraphPolicy, SearchesThatBeginWithItsPlanProveTheSame) {
  const auto policy = std::make_shared<const GraphPolicy>(GraphPolicy::untrained(4));
  int solved = 0;
  int none = 0;
  for (std::uint64_t seed = 0; seed < some_of(std::uint64_t{150}); ++seed) {
    const Problem problem(random_problem(seed));
    const TransitionSystem system(problem);
    if (system.wide() || problem.uncertain() || system.calls_out()) continue;
    for (const char* method : {"auto", "beam"}) {
      const Result without = solve(Task(problem), method, {}, {});
      Options options;
      options.graph_policy = policy;
      const Result with = solve(Task(problem), method, options, {});
      EXPECT_EQ(with.status, without.status) << method << seed;
      EXPECT_EQ(with.method, method);
      if (!without.has_plan()) {
        ++none;
        continue;
      }
      ++solved;
      EXPECT_NEAR(with.reward, without.reward, 1e-9) << method << seed;
    }
  }
  EXPECT_GT(solved, more_than(100));
  EXPECT_GT(none, more_than(10));
}

TEST(GraphPolicy, IsWhatDqnPlansWith) {
  const Problem problem = find_problem("tree:20:3");
  Options options;
  options.graph_policy = std::make_shared<const GraphPolicy>(GraphPolicy::untrained(1));
  const Result result = solve(Task(problem), "dqn", options, {});
  EXPECT_EQ(result.sequence, greedy(TransitionSystem(problem), {}).sequence);
  // A plan to begin with is never lost, however short the search.
  Budget none;
  none.max_expansions = 1;
  const Result searched = solve(Task(problem), "beam", options, none);
  EXPECT_GE(searched.reward, result.reward);
}

TEST(GraphPolicy, OneThatDoesNotFitIsRefused) {
  ProblemSpec spec = find_problem("4piece").spec();
  spec.connections.front().success = 0.5;
  spec.connections.front().on_failure.abort = -3;
  const Problem problem(std::move(spec));
  Options options;
  options.graph_policy = std::make_shared<const GraphPolicy>(GraphPolicy::untrained(1));
  EXPECT_THROW(static_cast<void>(solve(Task(problem), "auto", options, {})), InputError);
}

std::string refused_with(const std::string& bytes) {
  try {
    static_cast<void>(parse_graph_policy(bytes));
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(GraphPolicyFile, ComesBackAsItWas) {
  const GraphPolicyFile file{kind_of(balanced("tree:8:1")), 7, GraphPolicy::untrained(7)};
  const GraphPolicyFile read = parse_graph_policy(graph_policy_bytes(file));
  EXPECT_EQ(read.kind, file.kind);
  EXPECT_EQ(read.seed, 7U);
  EXPECT_EQ(read.policy.weights, file.policy.weights);
}

TEST(GraphPolicyFile, DamagedIsRefused) {
  const std::string bytes =
      graph_policy_bytes({kind_of(balanced("tree:8:1")), 7, GraphPolicy::untrained(7)});
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{20}, std::size_t{90}, bytes.size() / 2, bytes.size() - 1})
    EXPECT_FALSE(refused_with(bytes.substr(0, size)).empty()) << size;
  for (std::size_t at = 0; at < bytes.size(); at += 997) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    EXPECT_FALSE(refused_with(changed).empty()) << at;
  }
  EXPECT_FALSE(refused_with("{\"format\":\"orasp-policy/1\"}").empty());
}

TEST(GraphPolicyFile, BindsTheKindOfProblem) {
  const ProblemKind kind = kind_of(balanced("tree:8:1"));
  EXPECT_NO_THROW(require_kind(balanced("grid:9x9"), kind, "p"));
  EXPECT_THROW(require_kind(find_problem("tree:8:1"), kind, "p"), InputError);  // its objective
  EXPECT_THROW(require_kind(balanced("tree:8:1").with_direction(Direction::Assembly), kind, "p"),
               InputError);
  Limits limits;
  limits.max_moved_parts = 5;
  EXPECT_THROW(require_kind(balanced("tree:8:1").with_limits(limits), kind, "p"), InputError);
  EXPECT_THROW(kind_of_both(kind, kind_of(find_problem("tree:8:1"))), InputError);
}

}  // namespace
}  // namespace orasp
