#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/model/transition_system.h"
#include "orasp/symmetry/orbit_form.h"

namespace orasp {

/// Whether a method takes states that differ by an exchange of equal parts for one.
enum class SymmetryUse {
  Auto,  ///< where there is a symmetry and it is worth while
  On,    ///< always; refused where nothing is known of the symmetry
  Off,
};

/// The exchanges of parts and connections that leave a problem as it is (symmetry/problem_graph.h),
/// and the one state that stands for all states into which they take one another.
///
/// From states that an exchange takes into one another the same is still to be earned, by plans
/// that the exchange takes into one another. So H need hold one of them.
///
///     const Symmetry symmetry(system);
///     OrbitForm form = symmetry.form();      // one for each thread
///     form.canonical(words);                 // the state that stands for it
class Symmetry {
 public:
  /// Finds them. Milliseconds, and less where it is seen at once that all connections differ.
  explicit Symmetry(const TransitionSystem& system);

  /// Why nothing is known; a clause that goes on from the name of a method.
  [[nodiscard]] const std::optional<std::string>& obstacle() const { return obstacle_; }
  /// Whether no exchange is used: there is none, or nothing is known.
  [[nodiscard]] bool trivial() const { return form_.trivial(); }
  [[nodiscard]] const OrbitForm& form() const { return form_; }
  /// Exchanges of connections of which all others are made, more perhaps than are used.
  [[nodiscard]] const std::vector<Permutation>& generators() const { return generators_; }
  /// The same for parts: takes sets of parts to the one that stands for them.
  [[nodiscard]] OrbitForm form_of_parts() const { return {parts_, part_generators_}; }
  /// How many exchanges are used: at most so many times fewer states are there. As a number that
  /// may be rounded.
  [[nodiscard]] double order() const;
  /// "6 exchanges of equal parts"; empty where trivial.
  [[nodiscard]] std::string text() const;

 private:
  std::optional<std::string> obstacle_;
  std::size_t parts_ = 0;
  std::vector<Permutation> generators_;
  std::vector<Permutation> part_generators_;
  OrbitForm form_;
};

/// The number of all exchanges of connections that leave the problem as it is, as a product: so
/// many sequences are the same up to symmetry. Nothing where it is not known.
[[nodiscard]] std::optional<std::vector<std::uint32_t>> symmetry_order(
    const TransitionSystem& system);

/// The symmetry that a method is to use, as it was asked; nothing where it is to do without.
/// @throws Refusal of `method` where it was asked for and nothing is known.
[[nodiscard]] std::optional<Symmetry> symmetry_for(const TransitionSystem& system, SymmetryUse use,
                                                   std::string_view method);
/// Why the symmetry that was asked for cannot be used; empty where it can, or was not asked for.
[[nodiscard]] std::optional<std::string> symmetry_obstacle(const TransitionSystem& system,
                                                           SymmetryUse use);

/// The plan for which the steps of `sequence` stand: each was made in the state that stands for the
/// one that the steps before led to. @returns legal steps from the start that earn the same.
/// O(steps * (cost of an expansion + steps * cost of a form)).
[[nodiscard]] std::vector<ConnectionIndex> true_sequence(const TransitionSystem& system,
                                                         OrbitForm form,
                                                         std::span<const ConnectionIndex> sequence);

}  // namespace orasp
