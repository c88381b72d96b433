#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "orasp/model/detail/connectivity.h"
#include "orasp/model/detail/rules.h"
#include "orasp/model/tolerance.h"
#include "orasp/model/transition_system.h"

/// What stands behind TransitionSystem and Expander, for the files that define their members.
namespace orasp {

namespace detail {

inline bool at_most(double value, double limit) {
  return value <= limit + kRelativeTolerance * std::abs(limit);
}

/// What a step is before its legality and reward are judged. A holds the connection's first part.
struct Facts {
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

}  // namespace detail

/// The rules, behind the header.
struct TransitionSystem::Rules : detail::Rules {
  using detail::Rules::Rules;
};

/// Scratch memory of one thread, and the rules applied to facts.
struct Expander::Scratch {
  const Problem& problem;
  const TransitionSystem::Rules& rules;

  std::vector<Action> actions;
  std::vector<std::unique_ptr<Formula>> formulas;  ///< by term
  /// By term, for formulas of sizes alone: values met so far, NaN before; at ((moved + kept)^2 / 4
  /// + moved) * 2 + completes.
  mutable std::vector<std::vector<double>> tables;
  std::vector<std::uint64_t> present_words;  ///< where what is there differs from the open set
  std::vector<std::uint64_t> present_batch;  ///< the same for several states
  detail::Connectivity connectivity;
  /// Parts of A and B of the step at hand; set by whoever makes its Facts, if rules.needs_sides.
  detail::Side a;
  detail::Side b;
  std::vector<unsigned char> mark;  ///< by part; all 0 between uses
  std::vector<PartIndex> fill_a;
  std::vector<PartIndex> fill_b;

  Scratch(const Problem& the_problem, const TransitionSystem::Rules& the_rules);

  [[nodiscard]] SetView present(SetView open);
  [[nodiscard]] std::span<const std::uint64_t> present_of_all(
      std::span<const std::uint64_t> states);
  [[nodiscard]] detail::Facts counts(ConnectionIndex c, std::size_t num_open) const;
  [[nodiscard]] detail::Facts removal_facts(ConnectionIndex c, std::size_t num_open);
  [[nodiscard]] detail::Facts joining_facts(ConnectionIndex c, std::size_t num_open);
  [[nodiscard]] detail::Facts flooded_facts(SetView open, ConnectionIndex c);

  [[nodiscard]] double mass(const detail::Side& side) const;
  [[nodiscard]] detail::Movement movement(const detail::Facts& facts) const;
  [[nodiscard]] DirectionMask free_directions();
  [[nodiscard]] bool separation_legal(const detail::Facts& facts);
  [[nodiscard]] std::optional<double> distance(bool a_moves, const Vector3& depot) const;
  [[nodiscard]] double reward(const detail::Facts& facts);
  [[nodiscard]] double counting_reward(const detail::Term& term, const detail::Facts& facts) const;
  [[nodiscard]] double sized_expression(const detail::Term& term, const detail::Facts& facts) const;
  [[nodiscard]] double checked(double reward, const detail::Facts& facts) const;
  [[nodiscard]] double moving_reward(const detail::Term& term, std::size_t index,
                                     const detail::Facts& facts, const detail::Movement& movement);
  [[nodiscard]] std::span<const Action> legal_actions(SetView open);
  [[nodiscard]] std::span<const Action> in_order(SetView open, std::span<Action> legal) const;
  [[nodiscard]] Step full_step(const detail::Facts& facts) const;
  [[nodiscard]] bool constraints_met(SetView open, ConnectionIndex c);
  [[nodiscard]] bool ruled_out_first(SetView open, ConnectionIndex c) const;
  [[nodiscard]] std::optional<ConnectionIndex> waiting(SetView open, ConnectionIndex c);
};

[[gnu::always_inline]] inline detail::Facts Expander::Scratch::counts(ConnectionIndex c,
                                                                      std::size_t num_open) const {
  detail::Facts facts;
  facts.connection = c;
  facts.before = num_open + rules.num_kept;
  if (rules.assembly) facts.before = problem.num_connections() - facts.before;
  facts.after = rules.assembly ? facts.before + 1 : facts.before - 1;
  facts.completes = num_open == 1;
  return facts;
}

}  // namespace orasp
