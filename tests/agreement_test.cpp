// Every planner against brute force on seeded random problems (tests/random_problems.h,
// tests/oracle.h). A failing seed is named by SCOPED_TRACE; random_problem(seed) is that problem.

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "orasp/bounds/bound_kinds.h"
#include "orasp/bounds/connection_bound.h"
#include "orasp/bounds/piece_bound.h"
#include "orasp/catalogue.h"
#include "orasp/graph/graph_size.h"
#include "orasp/graph/state_graph.h"
#include "orasp/mip/mip.h"
#include "orasp/model/error.h"
#include "orasp/planners/and_or.h"
#include "orasp/planners/greedy.h"
#include "tests/checks.h"
#include "tests/fault.h"
#include "tests/oracle.h"
#include "tests/random_problems.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kInstrumented = true;
#else
constexpr bool kInstrumented = false;
#endif
// Connections of the largest problem that the integer program is asked for.
constexpr std::size_t kMostForBaseline = kInstrumented ? 3 : 5;
constexpr int kBlocks = 12;
constexpr std::uint64_t kSeedsInBlock = 60;
constexpr std::uint64_t kSeeds = kBlocks * kSeedsInBlock;

/// All seeds, a block a test.
class Agreement : public testing::TestWithParam<int> {
 protected:
  void for_each_seed(
      const std::function<void(const ProblemSpec&, const oracle::OracleResult&)>& check) {
    for (std::uint64_t i = 0; i < some_of(kSeedsInBlock); ++i) {
      const ProblemSpec spec =
          random_problem(static_cast<std::uint64_t>(GetParam()) * kSeedsInBlock + i);
      SCOPED_TRACE(spec.name);
      check(spec, oracle::brute_force(spec));
      if (HasFailure()) return;
    }
  }
};

INSTANTIATE_TEST_SUITE_P(Seeds, Agreement, testing::Range(0, kBlocks));

void expect_graph(const Problem& problem, const oracle::OracleResult& truth, unsigned threads) {
  SCOPED_TRACE("H with " + std::to_string(threads) + " threads");
  const TransitionSystem system(problem);
  Budget budget;
  budget.threads = threads;
  const StateGraph graph = StateGraph::build(system, budget);
  EXPECT_EQ(graph.stop(), Stop::None);
  EXPECT_EQ(graph.num_states(), truth.states);
  EXPECT_EQ(graph.num_actions(), truth.actions);
  ASSERT_EQ(graph.num_layers(), truth.layers.size());

  const GraphSize size = graph_size(graph);
  EXPECT_EQ(size.states, truth.states);
  EXPECT_EQ(size.actions, truth.actions);
  EXPECT_EQ(size.dead_ends, truth.dead_ends);
  EXPECT_EQ(size.tree_nodes, std::to_string(truth.tree_nodes));
  EXPECT_EQ(size.sequences, std::to_string(truth.sequences));
  ASSERT_EQ(size.layers.size(), truth.layers.size());
  for (std::size_t k = 0; k < size.layers.size(); ++k) {
    EXPECT_EQ(size.layers[k].states, truth.layers[k].first);
    EXPECT_EQ(size.layers[k].actions, truth.layers[k].second);
  }

  std::set<oracle::State> met;
  for (StateId s = 0; s < graph.num_states(); ++s) {
    const oracle::State state = oracle::state_of(graph.state(s), problem.num_connections());
    EXPECT_TRUE(truth.best_to_go.contains(state));
    EXPECT_TRUE(met.insert(state).second) << "state " << s << " is there twice";
    for (ActionId a = graph.begin(s); a < graph.end(s); ++a) {
      oracle::State next = state;
      next.at(graph.connection(a)) = false;
      EXPECT_EQ(oracle::state_of(graph.state(graph.successor(a)), problem.num_connections()), next);
    }
  }
  EXPECT_EQ(graph.goal().has_value(), truth.sequences > 0);
}

TEST_P(Agreement, StateGraphIsTheOraclesGraph) {
  for_each_seed([](const ProblemSpec& spec, const oracle::OracleResult& truth) {
    const Problem problem(spec);
    expect_graph(problem, truth, 1);
    expect_graph(problem, truth, 2);
  });
}

TEST_P(Agreement, EveryPlannerIsRightAboutEveryProblem) {
  for_each_seed([](const ProblemSpec& spec, const oracle::OracleResult& truth) {
    const Problem problem(spec);
    Budget two_threads;
    two_threads.threads = 2;
    for (const Planner* const planner : one_robot_planners()) {
      // A training takes seconds under a sanitizer; planner_contract_test.cpp does some of them.
      if (planner->role == Role::Learner && !planner->exact && kInstrumented) continue;
      // CBC takes seconds for larger ones; mip_test.cpp has some of these.
      if (planner->role == Role::Baseline && problem.num_connections() > kMostForBaseline) continue;
      SCOPED_TRACE(std::string(planner->name));
      if (const auto reason = obstacle(problem, planner->name, quick_options())) {
        const std::string fault =
            fault_of([&] { return solve(problem, planner->name, quick_options()); });
        // A method that lacks what it needs may still see that there is no plan at all.
        if (truth.feasible || fault != "no fault") {
          EXPECT_EQ(fault, *reason);
        }
        if (reason->find("needs a bound") != std::string::npos) {
          EXPECT_FALSE(range_is_known(spec.objective)) << *reason;
        }
        continue;
      }
      const Result result = solve(problem, planner->name, quick_options());
      expect_honest(problem, truth, *planner, result);
      expect_same_answer(result, solve(problem, planner->name, quick_options(), two_threads));
    }
  });
}

TEST_P(Agreement, ValuesOfEveryStateAreTheOracles) {
  for_each_seed([](const ProblemSpec& spec, const oracle::OracleResult& truth) {
    if (oracle::World(spec).start_infeasible()) return;  // settled without values
    const Problem problem(spec);
    const TransitionSystem system(problem);
    if (system.infeasibility()) return;
    const StateGraph graph = StateGraph::build(system, Budget{});
    const std::vector<double> to_go = value_iteration(graph, {}, Budget{}).values;
    const std::vector<double> from_start = bellman_ford(graph, {}, Budget{}).values;
    ASSERT_EQ(to_go.size(), graph.num_states());
    ASSERT_EQ(from_start.size(), graph.num_states());
    for (StateId s = 0; s < graph.num_states(); ++s) {
      const oracle::State state = oracle::state_of(graph.state(s), problem.num_connections());
      const double left = truth.best_to_go.at(state);
      const double gained = truth.best_from_start.at(state);
      if (std::isfinite(left)) {
        EXPECT_NEAR(to_go[s], left, reward_tolerance(left));
      } else {
        EXPECT_EQ(to_go[s], left);
      }
      EXPECT_NEAR(from_start[s], gained, reward_tolerance(gained));
    }
  });
}

// Admissible: never below the best that is left. Consistent: along an action it falls by at least
// the reward.
TEST_P(Agreement, ConnectionBoundIsAdmissibleAndConsistentInEveryState) {
  for_each_seed([](const ProblemSpec& spec, const oracle::OracleResult& truth) {
    const Problem problem(spec);
    const TransitionSystem system(problem);
    ConnectionBound bound(system);
    const oracle::World world(spec);
    for (const auto& [state, value] : truth.best_to_go) {
      const double here = bound(oracle::set_of(state).view());
      EXPECT_FALSE(std::isnan(here));
      if (range_is_known(spec.objective)) {
        EXPECT_TRUE(std::isfinite(here));
      }
      EXPECT_GE(here, value - reward_tolerance(here));
      for (const oracle::Facts& action : world.legal_facts(state)) {
        oracle::State next = state;
        next[action.connection] = false;
        const double there = bound(oracle::set_of(next).view());
        if (std::isfinite(here)) {
          EXPECT_GE(here - there, action.reward - reward_tolerance(here));
        }
      }
    }
    EXPECT_EQ(bound(ConnectionSet(problem.num_connections()).view()), 0);
  });
}

// The same for the bounds from pieces, where they say anything; and what is claimed of plans that
// meet them.
TEST_P(Agreement, PieceBoundsAreAdmissibleAndConsistentInEveryState) {
  for_each_seed([](const ProblemSpec& spec, const oracle::OracleResult& truth) {
    const Problem problem(spec);
    const TransitionSystem system(problem);
    const oracle::World world(spec);
    for (const PieceBound::Kind kind :
         {PieceBound::Kind::Sizes, PieceBound::Kind::Parts, PieceBound::Kind::Both}) {
      SCOPED_TRACE("kind " + std::to_string(static_cast<int>(kind)));
      PieceBound bound(system, kind);
      if (!bound.known()) continue;
      for (const auto& [state, value] : truth.best_to_go) {
        const ConnectionSet open = oracle::set_of(state);
        const double here = bound(open.view());
        ASSERT_TRUE(std::isfinite(here));
        EXPECT_GE(here, value - reward_tolerance(here));
        std::vector<Action> actions;
        std::vector<double> theres;
        for (const oracle::Facts& action : world.legal_facts(state)) {
          oracle::State next = state;
          next[action.connection] = false;
          actions.push_back({static_cast<ConnectionIndex>(action.connection), action.reward});
          theres.push_back(bound(oracle::set_of(next).view()));
          EXPECT_GE(here - theres.back(), action.reward - reward_tolerance(here));
        }
        // What a search is told of the successors is the same.
        std::vector<double> told(actions.size());
        bound.of_successors(open.view(), here, actions, told);
        for (std::size_t i = 0; i < actions.size(); ++i)
          EXPECT_NEAR(told[i], theres[i], reward_tolerance(here));
      }
      const Planner& planner = find_planner("greedy");
      Result guided = guided_greedy(system, bound, Budget{});
      guided.method = planner.name;
      expect_honest(problem, truth, planner, guided);
      const Result at_bound = plan_at_bound(system, bound, Budget{});
      EXPECT_TRUE(at_bound.status != Status::Infeasible || !truth.feasible);
      EXPECT_TRUE(at_bound.status != Status::Optimal || problem.num_connections() == 0);
      if (at_bound.has_plan()) {
        EXPECT_TRUE(oracle::replay(spec, at_bound.sequence).valid);
        EXPECT_LE(at_bound.reward, truth.best + reward_tolerance(truth.best));
      }
    }
  });
}

/// Calls check(state, what is there in it, best reward from the start to it) for the states of an
/// assembly, with the connections that are there as the open ones: its states backwards.
template <class Check>
void for_each_state_backwards(const oracle::OracleResult& truth, Check&& check) {
  for (const auto& [state, gained] : truth.best_from_start) {
    oracle::State there = state;
    there.flip();
    check(state, oracle::set_of(there), gained);
  }
}

// Backwards the steps of an assembly are the same, and what they earn.
TEST_P(Agreement, AnAssemblyBackwardsHasTheSameSteps) {
  for_each_seed([](const ProblemSpec& spec, const oracle::OracleResult& truth) {
    if (spec.direction != Direction::Assembly) return;
    const Problem problem(spec);
    const TransitionSystem system(problem);
    const TransitionSystem backwards = system.backwards();
    EXPECT_EQ(backwards.infeasibility().has_value(), system.infeasibility().has_value());
    const oracle::World world(spec);
    Expander expander(backwards);
    // The steps into each state that can be reached.
    std::map<oracle::State, std::map<std::size_t, double>> into;
    for (const auto& [state, gained] : truth.best_from_start) {
      for (const oracle::Facts& step : world.legal_facts(state)) {
        oracle::State next = state;
        next[step.connection] = false;
        into[next][step.connection] = step.reward;
      }
    }
    for_each_state_backwards(truth, [&](const oracle::State& state, const ConnectionSet& there,
                                        double) {
      std::map<std::size_t, double> steps = into[state];
      for (const Action& action : expander.legal_actions(there.view())) {
        oracle::State before = state;
        before[action.connection] = true;
        const auto found = steps.find(action.connection.value());
        if (found == steps.end()) {
          EXPECT_FALSE(truth.best_from_start.contains(before));  // a state that cannot be reached
          continue;
        }
        EXPECT_NEAR(action.reward, found->second, reward_tolerance(action.reward));
        const Step step = expander.step(there.view(), action.connection);
        EXPECT_NEAR(step.reward, action.reward, reward_tolerance(action.reward));
        EXPECT_EQ(step.completes, std::ranges::count(state, true) == 0);
        EXPECT_EQ(step.after, there.size());
        steps.erase(found);
      }
      EXPECT_TRUE(steps.empty());
    });
  });
}

// The bounds backwards: of what a plan earns up to a state.
TEST_P(Agreement, BoundsOfAnAssemblyBackwardsAreAdmissibleAndConsistent) {
  for_each_seed([](const ProblemSpec& spec, const oracle::OracleResult& truth) {
    if (spec.direction != Direction::Assembly) return;
    const Problem problem(spec);
    const TransitionSystem backwards = TransitionSystem(problem).backwards();
    Expander expander(backwards);
    for (const std::string_view name : kBoundNames) {
      SCOPED_TRACE(std::string(name));
      const std::unique_ptr<Bound> bound = make_bound(backwards, bound_called(name));
      if (!bound->known()) continue;
      for_each_state_backwards(
          truth, [&](const oracle::State&, const ConnectionSet& there, double gained) {
            const double here = (*bound)(there.view());
            ASSERT_TRUE(std::isfinite(here));
            EXPECT_GE(here, gained - reward_tolerance(here));
            const auto span = expander.legal_actions(there.view());
            const std::vector<Action> actions(span.begin(), span.end());
            std::vector<double> told(actions.size());
            bound->of_successors(there.view(), here, actions, told);
            for (std::size_t i = 0; i < actions.size(); ++i) {
              ConnectionSet next = there;
              next.erase(actions[i].connection);
              const double rest = (*bound)(next.view());
              EXPECT_GE(here - rest, actions[i].reward - reward_tolerance(here));
              EXPECT_NEAR(told[i], rest, reward_tolerance(here));
            }
          });
    }
  });
}

// With precedence alone, stated as `after`, `made_after` or `after_any`, both directions have the
// same states and steps, no step leads to where the goal cannot be reached, and what a step could
// not be followed by was not legal.
TEST_P(Agreement, PrecedenceAloneLeavesNoDeadEnds) {
  for (std::uint64_t seed = 0; seed < some_of(kSeeds / kBlocks); ++seed) {
    ProblemSpec spec = random_problem(seed * kBlocks + static_cast<std::uint64_t>(GetParam()));
    SCOPED_TRACE(spec.name);
    spec.limits = {};
    spec.blocking.reset();
    for (Connection& connection : spec.connections) connection.on_failure = {};
    for (Precedence& entry : spec.precedence) entry.made_after_any.clear();
    spec.direction = Direction::Disassembly;
    const oracle::OracleResult down = oracle::brute_force(spec);
    spec.direction = Direction::Assembly;
    const oracle::OracleResult up = oracle::brute_force(spec);
    const Problem problem(spec);
    const TransitionSystem system(problem);
    EXPECT_EQ(system.infeasibility().has_value(), !up.feasible);
    if (!up.feasible) continue;
    EXPECT_EQ(up.states, down.states);
    EXPECT_EQ(up.actions, down.actions);
    EXPECT_EQ(up.sequences, down.sequences);
    EXPECT_EQ(up.dead_ends, 0);
    EXPECT_EQ(down.dead_ends, 0);
    const StateGraph graph = StateGraph::build(system, Budget{});
    EXPECT_EQ(graph.num_states(), up.states);
    EXPECT_EQ(graph.num_actions(), up.actions);
  }
}

// What searches do with each bound must not change what they find.
TEST_P(Agreement, EveryBoundLeadsToTheSameReward) {
  for_each_seed([](const ProblemSpec& spec, const oracle::OracleResult& truth) {
    const Problem problem(spec);
    const TransitionSystem system(problem);
    for (const std::string_view name : kBoundNames) {
      SCOPED_TRACE(std::string(name));
      Options options;
      options.bound = bound_called(name);
      if (!make_bound(system, options.bound)->known()) continue;
      for (const char* method : {"orasp-search", "a-star", "beam"}) {
        const Planner& planner = find_planner(method);
        expect_honest(problem, truth, planner, solve(problem, planner.name, options));
      }
    }
  });
}

TEST_P(Agreement, OracleAgreesWithPlainEnumeration) {
  for_each_seed([](const ProblemSpec& spec, const oracle::OracleResult& truth) {
    if (spec.connections.size() > 6) return;
    const oracle::OracleResult tree = oracle::enumerate(spec);
    EXPECT_EQ(tree.feasible, truth.feasible);
    EXPECT_EQ(tree.tree_nodes, truth.tree_nodes);
    EXPECT_EQ(tree.sequences, truth.sequences);
    if (tree.feasible) {
      EXPECT_NEAR(tree.best, truth.best, 1e-9);
      EXPECT_NEAR(tree.worst, truth.worst, 1e-9);
    }
  });
}

/// Adds the types of an objective and of what it sums.
void add_types(const Objective& objective, bool inside_sum, std::set<std::string>& features) {
  features.insert("objective " + objective.type + (inside_sum ? " in a sum" : ""));
  if (const auto* cost = std::get_if<PieceCost>(&objective.parameters);
      cost != nullptr && objective.type == "piece_cost") {
    if (cost->completion < 0) features.insert("negative completion");
    if (!cost->pieces.contains(1)) features.insert("a size without a cost");
  }
  if (const auto* sum = std::get_if<WeightedSum>(&objective.parameters)) {
    for (const WeightedObjective& term : sum->terms) {
      if (term.weight < 0) features.insert("negative weight");
      if (term.weight == 0) features.insert("weight 0");
      if (term.objective.type == "sum") features.insert("sum in a sum");
      add_types(term.objective, true, features);
    }
  }
}

std::set<std::string> features_of(const ProblemSpec& spec, const oracle::OracleResult& truth) {
  std::set<std::string> features;
  const oracle::World world(spec);
  add_types(spec.objective, false, features);
  features.insert(spec.direction == Direction::Assembly ? "assembly" : "disassembly");
  features.insert(std::to_string(spec.connections.size()) + " connections");
  features.insert(truth.feasible ? "feasible" : "infeasible");
  if (world.start_infeasible()) features.insert("infeasible start");
  if (truth.feasible && truth.dead_ends > 0) features.insert("feasible with dead ends");
  const Problem sized(spec);
  const TransitionSystem sized_system(sized);
  const auto reason = sized_system.infeasibility();
  if (!truth.feasible && !world.start_infeasible() && !reason) {
    features.insert("infeasible, found by search only");
  }
  if (PieceBound(sized_system, PieceBound::Kind::Sizes).known())
    features.insert("bound from sizes");
  if (PieceBound(sized_system, PieceBound::Kind::Parts).known())
    features.insert("bound from what is moved");
  if (truth.feasible && truth.best - truth.worst > 1e-6)
    features.insert("plans of different rewards");

  std::map<std::string, int> entries;
  for (const Precedence& entry : spec.precedence) {
    if (!entry.after.empty()) features.insert("after");
    if (!entry.after_any.empty()) features.insert("after_any");
    if (!entry.made_after.empty()) features.insert("made_after");
    if (!entry.made_after_any.empty()) features.insert("made_after_any");
    if (++entries[entry.connection] > 1) features.insert("several entries on one connection");
  }
  if (reason && reason->constraint == Constraint::Precedence) features.insert("precedence cycle");

  const Limits& limits = spec.limits;
  const int number = (limits.max_subassemblies ? 1 : 0) + (limits.max_moved_parts ? 1 : 0) +
                     (limits.max_moved_mass ? 1 : 0);
  const std::string alone = number == 1 ? " alone" : "";
  if (limits.max_subassemblies) features.insert("max_subassemblies" + alone);
  if (limits.max_moved_parts) features.insert("max_moved_parts" + alone);
  if (limits.max_moved_mass) features.insert("max_moved_mass" + alone);
  if (number == 3) features.insert("all limits");
  if (spec.blocking) {
    const auto& directions = spec.blocking->directions;
    const auto named = std::ranges::count_if(directions, [](const BlockingDirection& direction) {
      return direction.vector.has_value();
    });
    if (named > 1) features.insert("blocking with too many directions for a mask");
    if (named == 1) features.insert("blocking with a named direction");
    if (named <= 1)
      features.insert("blocking with " +
                      std::to_string(directions.size() + static_cast<std::size_t>(named)) +
                      " directions");
  }

  std::set<std::set<std::string>> pairs;
  for (const Connection& connection : spec.connections) {
    if (connection.parts[0] == connection.parts[1]) {
      features.insert("self-connection");
    } else if (!pairs.insert({connection.parts[0], connection.parts[1]}).second) {
      features.insert("parallel connections");
    }
  }
  std::set<std::string> joined;
  for (const Connection& connection : spec.connections)
    joined.insert(connection.parts.begin(), connection.parts.end());
  for (const Part& part : spec.parts) {
    features.insert(part.position ? "a position" : "no position");
    if (!joined.contains(part.id)) features.insert("part without a connection");
  }

  // What happens in its states: several pieces at the start, steps that each rule forbids, ties of
  // the moved piece.
  const std::array<std::string, 7> rules = {"precedence (after)",
                                            "precedence (after_any)",
                                            "precedence (made_after_any)",
                                            "max_subassemblies",
                                            "max_moved_parts",
                                            "max_moved_mass",
                                            "blocking"};
  for (const auto& [state, value] : truth.best_to_go) {
    for (std::size_t c = 0; c < state.size(); ++c) {
      if (!state[c]) continue;
      const oracle::Facts facts = world.facts(state, c);
      for (const oracle::Rule rule : facts.broken) {
        features.insert("a step forbidden by " + rules[static_cast<std::size_t>(rule)]);
        if (facts.broken.size() == 1) {
          features.insert("a step forbidden by nothing but " +
                          rules[static_cast<std::size_t>(rule)]);
        }
      }
      if (facts.separates && facts.a.size() == facts.b.size()) {
        features.insert(facts.moved_mass == facts.kept_mass ? "tie of the moved piece"
                        : std::abs(facts.moved_mass - facts.kept_mass) < 1e-9
                            ? "tie of the moved piece by rounding"
                            : "moved piece by mass");
      }
      if (facts.separates && facts.moved.size() > 1)
        features.insert("a moved piece of several parts");
    }
  }
  const Problem problem(spec);
  const TransitionSystem system(problem);
  if (system.subassemblies(system.start().view()) > 1) features.insert("several start pieces");
  return features;
}

// The comparison is worth what the problems are worth: each feature must occur often among the
// seeds.
TEST(RandomProblems, HaveEveryFeatureAmongTheSeeds) {
  if (percent_of_seeds() < 100) GTEST_SKIP() << "it is a question about all seeds";
  std::map<std::string, int> seen;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const ProblemSpec spec = random_problem(seed);
    for (const std::string& feature : features_of(spec, oracle::brute_force(spec))) ++seen[feature];
  }
  std::map<std::string, int> wanted = {
      {"assembly", 200},
      {"disassembly", 200},
      {"feasible", 300},
      {"infeasible", 60},
      {"infeasible start", 10},
      {"infeasible, found by search only", 40},
      {"feasible with dead ends", 15},
      {"plans of different rewards", 150},
      {"bound from sizes", 100},
      {"bound from what is moved", 40},
      {"after", 150},
      {"after_any", 60},
      {"several entries on one connection", 40},
      {"precedence cycle", 15},
      {"max_subassemblies", 60},
      {"max_subassemblies alone", 20},
      {"max_moved_parts", 60},
      {"max_moved_parts alone", 20},
      {"max_moved_mass", 60},
      {"max_moved_mass alone", 20},
      {"all limits", 30},
      {"blocking with 2 directions", 30},
      {"blocking with 4 directions", 30},
      {"blocking with 6 directions", 30},
      {"blocking with a named direction", 30},
      {"blocking with too many directions for a mask", 8},
      {"self-connection", 30},
      {"parallel connections", 60},
      {"part without a connection", 60},
      {"several start pieces", 30},
      {"a position", 100},
      {"no position", 100},
      {"negative completion", 15},
      {"a size without a cost", 10},
      {"negative weight", 15},
      {"weight 0", 5},
      {"sum in a sum", 3},
      {"a moved piece of several parts", 60},
      {"tie of the moved piece", 100},
      {"tie of the moved piece by rounding", 3},
      {"moved piece by mass", 60},
  };
  for (const std::string_view type : kPlainObjectiveTypes)
    wanted["objective " + std::string(type)] = 40;
  for (const std::string_view type : kPlainObjectiveTypes)
    wanted["objective " + std::string(type) + " in a sum"] = 3;
  wanted["objective callable"] = 40;
  for (int n = 0; n <= 8; ++n) wanted[std::to_string(n) + " connections"] = 15;
  for (const char* rule :
       {"precedence (after)", "precedence (after_any)", "precedence (made_after_any)",
        "max_subassemblies", "max_moved_parts", "max_moved_mass", "blocking"}) {
    wanted["a step forbidden by " + std::string(rule)] = 20;
    wanted["a step forbidden by nothing but " + std::string(rule)] = 10;
  }
  for (const auto& [feature, least] : wanted) EXPECT_GE(seen[feature], least) << feature;
  if (HasFailure()) {
    for (const auto& [feature, times] : seen) std::printf("%5d  %s\n", times, feature.c_str());
  }
}

}  // namespace
}  // namespace orasp
