// Where the time goes: expanding states, building H, each planner on it. `threads` is the last
// argument of each name.
//
//   build/release/benchmarks/orasp_benchmarks --benchmark_filter=graph
//
// Google Benchmark prints the machine; the figures in docs/performance.md say the commit.

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "orasp/model/random.h"
#include "orasp/orasp.h"

namespace {

/// One answer of a policy: a pass of the network of the paper's shape, as plain weights.
void ask_policy(benchmark::State& state, const std::string& name) {
  const orasp::Problem problem = orasp::load_scenario(name);
  const orasp::TransitionSystem system(problem);
  const std::size_t n = system.num_connections();
  orasp::Policy policy;
  orasp::SplitMix64 random(1);
  const std::size_t hidden = std::max<std::size_t>(128, n);
  for (const auto& [inputs, outputs] : {std::pair(n, hidden), {hidden, hidden}, {hidden, n}}) {
    orasp::DenseLayer layer{.inputs = inputs, .outputs = outputs, .weights = {}, .bias = {}};
    layer.weights.resize(inputs * outputs);
    layer.bias.resize(outputs);
    for (float& weight : layer.weights) weight = static_cast<float>(random.uniform() - 0.5);
    policy.layers.push_back(std::move(layer));
  }
  orasp::PolicyEvaluator evaluator(policy);
  const orasp::ConnectionSet start = system.start();
  for (auto _ : state) benchmark::DoNotOptimize(evaluator.outputs(start.view()).data());
}
BENCHMARK_CAPTURE(ask_policy, hubble, "hubble-upc");
BENCHMARK_CAPTURE(ask_policy, iss, "iss-upc");
BENCHMARK_CAPTURE(ask_policy, jwst, "jwst-upc");

/// Random episodes side by side, with masks and observations. The actions were drawn in a first
/// round, so that what is measured finds its states remembered, as far as memory allows.
void step_episodes(benchmark::State& state, const std::string& name, std::size_t rounds) {
  const orasp::Problem problem = orasp::load_scenario(name);
  const orasp::TransitionSystem system(problem);
  const auto episodes = static_cast<std::size_t>(state.range(0));
  orasp::VectorEnvironment world(system, episodes);
  std::vector<float> observations(episodes * world.observation_size());
  std::vector<std::uint8_t> masks(episodes * world.num_actions());
  std::vector<double> rewards(episodes);
  std::vector<std::uint8_t> terminated(episodes);
  std::vector<std::uint8_t> truncated(episodes);
  orasp::EpisodeBuffers buffers;
  buffers.observations = observations;
  buffers.masks = masks;
  buffers.rewards = rewards;
  buffers.terminated = terminated;
  buffers.truncated = truncated;
  world.reset(buffers);
  std::vector<std::int64_t> actions(rounds * episodes);
  for (std::size_t r = 0; r < rounds; ++r) {
    const auto row = std::span(actions).subspan(r * episodes, episodes);
    world.sample(row);
    world.step(row, buffers);
  }
  const std::uint64_t expanded = world.expanded();
  for (auto _ : state) {
    world.reset(buffers);
    for (std::size_t r = 0; r < rounds; ++r)
      world.step(std::span(actions).subspan(r * episodes, episodes), buffers);
  }
  const auto steps = static_cast<double>(rounds * episodes);
  state.counters["steps/s"] =
      benchmark::Counter(steps, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["bytes"] = static_cast<double>(world.bytes());
  state.counters["expanded"] = static_cast<double>(world.expanded() - expanded);
}
BENCHMARK_CAPTURE(step_episodes, hubble, "hubble", 190)
    ->Arg(1)
    ->Arg(1024)
    ->Unit(benchmark::kMillisecond);
// The first steps, whose states are all remembered; then to the end, where memory does not suffice.
BENCHMARK_CAPTURE(step_episodes, jwst_first, "jwst", 64)->Arg(1024)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(step_episodes, jwst, "jwst", 256)->Arg(1024)->Unit(benchmark::kMillisecond);

orasp::Budget budget_with(std::int64_t threads) {
  orasp::Budget budget;
  budget.threads = static_cast<unsigned>(threads);
  return budget;
}

void expand(benchmark::State& state, const std::string& name) {
  const orasp::Problem problem = orasp::load_scenario(name);
  const orasp::TransitionSystem system(problem);
  const orasp::StateGraph graph = orasp::StateGraph::build(system, {});
  std::vector<std::uint64_t> states;
  for (orasp::StateId s = 0; s < graph.num_states(); ++s) {
    states.insert(states.end(), graph.state(s).begin(), graph.state(s).end());
  }
  orasp::Expander expander(system);
  for (auto _ : state) {
    double sum = 0;
    expander.for_each_expansion(states, [&](std::size_t, std::span<const orasp::Action> actions) {
      for (const orasp::Action& action : actions) sum += action.reward;
    });
    benchmark::DoNotOptimize(sum);
  }
  state.counters["actions/s"] = benchmark::Counter(static_cast<double>(graph.num_actions()),
                                                   benchmark::Counter::kIsIterationInvariantRate);
}

void build_graph(benchmark::State& state, const std::string& name, const std::string& objective) {
  const orasp::Problem problem =
      orasp::load_scenario(name).with_objective(orasp::Objective::named(objective));
  const orasp::TransitionSystem system(problem);
  const orasp::Budget budget = budget_with(state.range(0));
  double actions = 0;
  double states = 0;
  double bytes = 0;
  for (auto _ : state) {
    const orasp::StateGraph graph = orasp::StateGraph::build(system, budget);
    actions = static_cast<double>(graph.num_actions());
    states = static_cast<double>(graph.num_states());
    bytes = static_cast<double>(graph.bytes());
  }
  state.counters["actions/s"] =
      benchmark::Counter(actions, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["states"] = states;
  state.counters["bytes"] = bytes;
}

void run_planner(benchmark::State& state, const std::string& name, const std::string& method) {
  const orasp::Problem problem = orasp::load_scenario(name);
  const orasp::Budget budget = budget_with(state.range(0));
  double reward = 0;
  for (auto _ : state) reward = orasp::solve(problem, method, {}, budget).reward;
  state.counters["reward"] = reward;
}

void on_held_graph(benchmark::State& state, const std::string& name, const std::string& method) {
  const orasp::Problem problem = orasp::load_scenario(name);
  const orasp::TransitionSystem system(problem);
  const orasp::Budget budget = budget_with(state.range(0));
  const orasp::StateGraph graph = orasp::StateGraph::build(system, budget);
  for (auto _ : state) {
    const orasp::Result result = method == "dijkstra" ? orasp::dijkstra(graph, budget)
                                 : method == "bellman-ford"
                                     ? orasp::bellman_ford(graph, {}, budget)
                                     : orasp::value_iteration(graph, {}, budget);
    benchmark::DoNotOptimize(result.reward);
  }
}

void dense(benchmark::State& state, const std::string& name,
           orasp::DenseValueIterationOptions::Values values) {
  const orasp::Problem problem = orasp::load_scenario(name);
  const orasp::TransitionSystem system(problem);
  const orasp::Budget budget = budget_with(state.range(0));
  double actions = 0;
  double bytes = 0;
  for (auto _ : state) {
    const orasp::Result result = orasp::dense_value_iteration(system, {.values = values}, budget);
    actions = static_cast<double>(result.statistics.generated);
    bytes = static_cast<double>(result.statistics.peak_bytes);
  }
  state.counters["actions/s"] =
      benchmark::Counter(actions, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["bytes"] = bytes;
}

BENCHMARK_CAPTURE(expand, hubble_free, "hubble-free")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(expand, hubble_upc, "hubble-upc")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(expand, grid_3x5, "grid:3x5")->Unit(benchmark::kMillisecond);

#define ORASP_GRAPH(label, scenario, objective)              \
  BENCHMARK_CAPTURE(build_graph, label, scenario, objective) \
      ->Arg(1)                                               \
      ->Arg(2)                                               \
      ->UseRealTime()                                        \
      ->Unit(benchmark::kMillisecond)
ORASP_GRAPH(hubble, "hubble", "cubesat");
ORASP_GRAPH(hubble_free, "hubble-free", "cubesat");
ORASP_GRAPH(hubble_free_fuel, "hubble-free", "fuel");
ORASP_GRAPH(hubble_upc, "hubble-upc", "cubesat");
ORASP_GRAPH(grid_3x5, "grid:3x5", "cubesat");

// `iss` takes a minute and 8 GiB: benchmarks/whole_process.py --iss.
#define ORASP_DENSE(label, scenario, values)                                                   \
  BENCHMARK_CAPTURE(dense, label, scenario, orasp::DenseValueIterationOptions::Values::values) \
      ->Arg(1)                                                                                 \
      ->Arg(2)                                                                                 \
      ->UseRealTime()                                                                          \
      ->Unit(benchmark::kMillisecond)
ORASP_DENSE(hubble_free, "hubble-free", Double);
ORASP_DENSE(hubble_free_fixed_point, "hubble-free", FixedPoint);
ORASP_DENSE(tree_24, "tree:24:1", Double);
ORASP_DENSE(tree_24_fixed_point, "tree:24:1", FixedPoint);
ORASP_DENSE(grid_3x5, "grid:3x5", Double);

#define ORASP_HELD(label, method)                                \
  BENCHMARK_CAPTURE(on_held_graph, label, "hubble-free", method) \
      ->Arg(1)                                                   \
      ->Arg(2)                                                   \
      ->UseRealTime()                                            \
      ->Unit(benchmark::kMillisecond)
ORASP_HELD(value_iteration, "value-iteration");
ORASP_HELD(dijkstra, "dijkstra");
ORASP_HELD(bellman_ford, "bellman-ford");

#define ORASP_PLANNER(label, scenario, method)            \
  BENCHMARK_CAPTURE(run_planner, label, scenario, method) \
      ->Arg(1)                                            \
      ->Arg(2)                                            \
      ->UseRealTime()                                     \
      ->Unit(benchmark::kMillisecond)
ORASP_PLANNER(hubble_value_iteration, "hubble", "value-iteration");
ORASP_PLANNER(hubble_dijkstra, "hubble", "dijkstra");
ORASP_PLANNER(hubble_bellman_ford, "hubble", "bellman-ford");
ORASP_PLANNER(hubble_orasp_search, "hubble", "orasp-search");
ORASP_PLANNER(hubble_free_value_iteration, "hubble-free", "value-iteration");
ORASP_PLANNER(hubble_free_orasp_search, "hubble-free", "orasp-search");
ORASP_PLANNER(lattice_value_iteration, "lattice", "value-iteration");

}  // namespace
