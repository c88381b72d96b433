#include "orasp/planners/symmetric_graph.h"

#include "orasp/graph/graph_estimate.h"
#include "orasp/graph/wide_graph_builder.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/memory_limit.h"

namespace orasp {

namespace {

/// H of fewer states is built as it is.
constexpr double kSmall = 20'000;

/// The symmetry that is used; nothing where none is.
std::optional<Symmetry> worthwhile(const TransitionSystem& system, SymmetryUse use, double least,
                                   const Budget& budget, std::string_view method) {
  const bool automatic = use == SymmetryUse::Auto;
  if (automatic && estimate_without_constraints(system).states < kSmall) return std::nullopt;
  std::optional<Symmetry> symmetry = symmetry_for(system, use, method);
  if (!symmetry || !automatic) return symmetry;
  const double saving = symmetry->form().saving();
  if (saving < least) return std::nullopt;
  const GraphEstimate all = estimate_graph(system);
  // The builder needs more for each state while it works.
  constexpr double kMore = 4;
  const bool fits = all.bytes * kMore / saving <= static_cast<double>(allowed_bytes(budget));
  if (all.states < kSmall || !fits) return std::nullopt;
  return symmetry;
}

}  // namespace

std::optional<Result> on_symmetric_graph(const TransitionSystem& system, SymmetryUse use,
                                         double least, const Budget& budget,
                                         std::string_view method,
                                         const std::function<Result(const StateGraph&)>& plan) {
  const Stopwatch watch;
  if (system.infeasibility()) return std::nullopt;
  const std::optional<Symmetry> symmetry = worthwhile(system, use, least, budget, method);
  if (!symmetry) return std::nullopt;
  const StateGraph graph = WideGraphBuilder(system, symmetry->form(), budget).build();
  if (graph.stop() != Stop::None) {
    Result result =
        detail::stopped_with_quick_plan(system, method, graph.stop(), detail::statistics_of(graph));
    result.statistics.seconds = watch.seconds();
    return result;
  }
  Result result = plan(graph);
  if (result.status == Status::Optimal)
    result.sequence = true_sequence(system, symmetry->form(), result.sequence);
  result.values.clear();
  result.notes.push_back(symmetry->text());
  result.statistics.seconds = watch.seconds();
  return result;
}

std::optional<std::string> symmetric_graph_obstacle(const TransitionSystem& system, SymmetryUse use,
                                                    double least, const Budget& budget,
                                                    std::optional<std::string> without) {
  if (auto reason = symmetry_obstacle(system, use)) return reason;
  if (without && use != SymmetryUse::Off && worthwhile(system, use, least, budget, ""))
    return std::nullopt;
  return without;
}

}  // namespace orasp
