// Seconds of one replanning query: each open connection of a problem becomes inaccessible at each
// of some steps of its plan.
//
//     build/release/benchmarks/orasp_replanning [PROBLEM [EVERY]]     (hubble, every step)
//
//     build/release/benchmarks/orasp_replanning reweigh [PROBLEM]     (hubble-free)
//
// Seconds of generating H and of replacing its rewards, one thread, under each objective without
// parameters.
//
// The first prints one line: queries, how many are held, proved, the median, the 99th percentile
// and the longest.

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/execution/replanner.h"
#include "orasp/graph/state_graph.h"
#include "orasp/io/scenarios.h"
#include "orasp/task/budget.h"

namespace {

using namespace orasp;

int reweigh(const std::string& name) {
  ProblemSpec spec = load_scenario(name).spec();
  for (std::size_t i = 0; i < spec.parts.size(); ++i) {
    if (!spec.parts[i].position)
      spec.parts[i].position = Vector3{static_cast<double>(i % 5), static_cast<double>(i / 5), 1};
  }
  const Problem problem(spec);
  const TransitionSystem system(problem);
  StateGraph graph = StateGraph::build(system, Budget{});
  std::printf("| objective | generate, s | reweigh, s | ratio |\n| --- | --- | --- | --- |\n");
  for (const std::string_view type : kPlainObjectiveTypes) {
    if (type == "expression" || type == "sum") continue;
    const Problem other = problem.with_objective(Objective::named(type));
    const TransitionSystem other_system(other);
    double generated = 1e9;
    double replaced = 1e9;
    for (int i = 0; i < 3; ++i) {
      const Stopwatch build;
      const StateGraph fresh = StateGraph::build(other_system, Budget{});
      generated = std::min(generated, build.seconds());
      const Stopwatch watch;
      if (graph.reweigh(other_system, Budget{}) != StateGraph::Reweighed::Done) return 1;
      replaced = std::min(replaced, watch.seconds());
    }
    std::printf("| %s | %.3f | %.3f | %.1f |\n", std::string(type).c_str(), generated, replaced,
                generated / replaced);
    // The graph must not outlive the system that it names.
    if (graph.reweigh(system, Budget{}) != StateGraph::Reweighed::Done) return 1;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "hubble";
  if (name == "reweigh") return reweigh(argc > 2 ? argv[2] : "hubble-free");
  std::size_t every = 1;
  if (argc > 2) {
    const std::string text = argv[2];
    std::from_chars(text.data(), text.data() + text.size(), every);
  }
  const Problem problem = load_scenario(name);
  Replanner replanner(problem);
  const Result plan = replanner.plan();
  std::vector<double> seconds;
  std::size_t proved = 0;
  std::size_t infeasible = 0;
  for (std::size_t step = 0; step < plan.sequence.size(); ++step) {
    const ConnectionSet open = replanner.situation().open;
    for (ConnectionIndex c = 0; step % every == 0 && c < problem.num_connections(); ++c) {
      if (!open.contains(c)) continue;
      replanner.set_accessible(c, false);
      const Stopwatch watch;
      const Result answer = replanner.plan(Budget::with_time_limit(10));
      seconds.push_back(watch.seconds());
      if (answer.status == Status::Optimal) ++proved;
      if (answer.status == Status::Infeasible) ++infeasible;
      replanner.set_accessible(c, true);
    }
    replanner.done(plan.sequence[step]);
  }
  std::ranges::sort(seconds);
  if (seconds.empty()) return 0;
  std::printf(
      "%s: %zu queries, H %s, %zu optimal, %zu infeasible, us: median %.2f, 99 %% %.1f, most "
      "%.1f\n",
      name.c_str(), seconds.size(), replanner.holds_graph() ? "held" : "not held", proved,
      infeasible, 1e6 * seconds[seconds.size() / 2], 1e6 * seconds[seconds.size() * 99 / 100],
      1e6 * seconds.back());
  return 0;
}
