#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "orasp/model/detail/connectivity.h"
#include "orasp/model/problem.h"

namespace orasp::detail {

/// The values of an attribute that objectives look back at.
struct AttributeValues {
  std::string name;
  std::vector<std::string> values;  ///< each once
  /// By connection: 0 where it has no value, else a place in `values` and 1. Empty for the
  /// direction in which a piece leaves, which is no connection's own.
  std::vector<std::uint32_t> of_connection;
};

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
  /// Whether the side that moves is told by sizes and masses alone: no part is fixed, and steps
  /// take one connection.
  bool moves_by_size = true;
  std::vector<std::string> own_numbers;     ///< their names, each once, ascending
  std::vector<AttributeValues> attributes;  ///< those that the objective looks back at
  bool looks_at_places = false;             ///< the objective looks back at where steps were done

  ProblemTotals(const Problem& the_problem, const AssemblyGraph& the_graph);
  /// The greatest distance of a part to `depot`, in metres; 0 where no part has a position.
  [[nodiscard]] double farthest(const Vector3& depot) const;
  /// The place of an attribute in `attributes`, which has it.
  [[nodiscard]] std::size_t attribute(const std::string& name) const;
};

}  // namespace orasp::detail
