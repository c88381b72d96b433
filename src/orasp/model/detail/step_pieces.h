#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "orasp/model/detail/connectivity.h"
#include "orasp/model/detail/problem_totals.h"
#include "orasp/model/transition_system.h"

namespace orasp::detail {

/// What a step is before its legality and reward are judged. A holds the connection's first part.
struct StepFacts {
  ConnectionIndex connection = 0;
  bool separates = false;
  bool completes = false;
  std::uint32_t a_parts = 0;
  std::uint32_t b_parts = 0;
  std::size_t before = 0;
  std::size_t after = 0;
  std::size_t subassemblies_apart = 0;   ///< without the connection
  std::size_t subassemblies_joined = 0;  ///< with it
};

/// Which side moves, and what it weighs.
struct Movement {
  bool a_moves = false;
  double moved_mass = 0;
  double kept_mass = 0;
};

/// The pieces A and B of the step at hand, and what is seen by looking inside them.
struct StepPieces {
  const ProblemTotals& totals;
  Side a;
  Side b;

  [[nodiscard]] double mass(const Side& side) const;
  [[nodiscard]] Movement movement(const StepFacts& facts) const;
  /// From the centroid of the side that moves to `depot`; empty where one of its parts has no
  /// position.
  [[nodiscard]] std::optional<double> distance(bool a_moves, const Vector3& depot) const;
  /// All of the step but its reward.
  [[nodiscard]] Step full_step(const StepFacts& facts) const;
  /// The reward that foreign code named. @throws InputError if it is no number, or
  /// too large to be added up.
  [[nodiscard]] double checked(double reward, const StepFacts& facts) const;
};

}  // namespace orasp::detail
