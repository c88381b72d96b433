#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

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
  double elapsed = 0;  ///< s, of all that was handled before; where the objective asks for it
};

/// Which side moves, and how large it is. Where both hold a base part, neither does, and what is
/// kept is both.
struct Movement {
  bool moves = false;
  bool a_moves = false;
  std::uint32_t moved_parts = 0;
  std::uint32_t kept_parts = 0;
  double moved_mass = 0;
  double kept_mass = 0;
};

/// What the steps before left behind, and what the step at hand adds, for objectives that look
/// back.
struct StepMemory {
  /// By attribute (ProblemTotals::attributes): 0 for none, else a place among its values and 1. The
  /// last value that a step had, and that of this step.
  std::span<const std::uint32_t> in_force{};
  std::span<const std::uint32_t> here{};
  /// Where the step before was done, if there was one, and where this one is.
  std::optional<Vector3> last_place{};
  std::optional<Vector3> place{};
};

/// The pieces A and B of the step at hand, and what is seen by looking inside them.
struct StepPieces {
  const ProblemTotals& totals;
  Side a;
  Side b;
  /// Where an objective looks back.
  const StepMemory* memory = nullptr;
  /// Of a step that takes parts off: all that it handles, and the sizes of the pieces that the rest
  /// falls into. Else empty.
  std::span<const ConnectionIndex> several{};
  std::span<const std::uint32_t> rest_sizes{};

  [[nodiscard]] double mass(const Side& side) const;
  [[nodiscard]] bool has_base(const Side& side) const;
  /// s, of all that the step handles.
  [[nodiscard]] double duration(const StepFacts& facts) const;
  /// A number of the user's own, added up over all that the step handles.
  [[nodiscard]] double number(const StepFacts& facts, const std::string& name) const;
  /// The sum of a number of the user's own over the parts of a side.
  [[nodiscard]] double sum(const Side& side, const std::string& number) const;
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
