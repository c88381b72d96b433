#include "orasp/planners/detail/forest_blocks.h"

#include <limits>
#include <variant>

#include "orasp/graph/graph_estimate.h"
#include "orasp/model/detail/connectivity.h"

namespace orasp::detail {

namespace {}  // namespace

std::optional<DenseForest> dense_forest_of(const TransitionSystem& system) {
  const Problem& problem = system.problem();
  if (system.num_connections() < kLaneBits || !unconstrained(system) || !system.sees_sizes_only() ||
      system.sees_starting_pieces())
    return std::nullopt;
  const AssemblyGraph graph(problem);
  if (!graph.is_forest()) return std::nullopt;
  DenseForest forest;
  forest.assembly = problem.direction() == Direction::Assembly;
  forest.loops.assign(graph.loops().begin(), graph.loops().end());
  constexpr auto kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> slots(graph.num_slots(), kNone);
  for (const auto& edge : graph.forest()) {
    slots[edge.connection] = static_cast<std::uint32_t>(forest.slots++);
  }
  for (const auto& edge : graph.forest()) {
    std::uint32_t& parent = slots[edge.parent_slot];
    if (parent == kNone) parent = static_cast<std::uint32_t>(forest.slots++);
    forest.edges.push_back(
        {edge.connection, parent, problem.ends(edge.connection)[0] == edge.child});
  }
  return forest;
}

}  // namespace orasp::detail
