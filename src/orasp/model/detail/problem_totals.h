#pragma once

#include <vector>

#include "orasp/model/detail/connectivity.h"
#include "orasp/model/problem.h"

namespace orasp::detail {

/// What objectives need to know of all parts of a problem together. Refers to the problem and to
/// its graph.
struct ProblemTotals {
  const Problem& problem;
  const AssemblyGraph& graph;
  bool assembly = false;  ///< the direction of planning
  bool uniform_mass = true;
  bool no_positions = true;
  double part_mass = 0;          ///< kg, of the first part
  double total_mass = 0;         ///< kg
  std::vector<double> lightest;  ///< kg, by number of parts: the least that so many parts can weigh
  std::vector<double> heaviest;  ///< and the most

  ProblemTotals(const Problem& the_problem, const AssemblyGraph& the_graph);
  /// The greatest distance of a part to `depot`, in metres; 0 where no part has a position.
  [[nodiscard]] double farthest(const Vector3& depot) const;
};

}  // namespace orasp::detail
