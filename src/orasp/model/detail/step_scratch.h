#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "orasp/model/detail/connectivity.h"
#include "orasp/model/detail/rules.h"
#include "orasp/model/detail/step_pieces.h"
#include "orasp/model/objectives/objective_term.h"
#include "orasp/model/tolerance.h"
#include "orasp/model/transition_system.h"

/// What stands behind TransitionSystem and Expander, for the files that define their members.
namespace orasp {

namespace detail {

inline bool at_most(double value, double limit) {
  return value <= limit + kRelativeTolerance * std::abs(limit);
}

}  // namespace detail

/// The rules, behind the header.
struct TransitionSystem::Rules : detail::Rules {
  using detail::Rules::Rules;
};

/// Scratch memory of one thread, and the rules applied to facts.
struct Expander::Scratch {
  const Problem& problem;
  const TransitionSystem::Rules& rules;

  struct TermOfThread {
    double weight;
    const ObjectiveTerm* term;
    std::unique_ptr<const ObjectiveTerm> own;  ///< null where the term is shared by all threads
  };

  std::vector<Action> actions;
  /// The addends of the objective, for this thread.
  std::vector<TermOfThread> terms;
  /// Where the objective is nothing but costs by size, these.
  const SizeCosts* size_costs = nullptr;
  std::vector<std::uint64_t> present_words;  ///< where what is there differs from the open set
  std::vector<std::uint64_t> present_batch;  ///< the same for several states
  detail::Connectivity connectivity;
  /// A and B of the step at hand; set by whoever makes its facts, if rules.needs_sides.
  detail::StepPieces pieces;
  std::vector<unsigned char> mark;       ///< by part; all 0 between uses
  std::vector<std::uint64_t> free_bits;  ///< directions
  std::vector<PartIndex> fill_a;
  std::vector<PartIndex> fill_b;
  /// For late connections: steps in any order, and which states are known to lead to the goal.
  std::unique_ptr<Expander> in_any_order;
  std::unordered_map<ConnectionSet, bool> leads_to_goal;

  Scratch(const Problem& the_problem, const TransitionSystem::Rules& the_rules,
          const TransitionSystem* any_order);

  [[nodiscard]] SetView present(SetView open);
  [[nodiscard]] std::span<const std::uint64_t> present_of_all(
      std::span<const std::uint64_t> states);
  [[nodiscard]] detail::StepFacts counts(ConnectionIndex c, std::size_t num_open) const;
  [[nodiscard]] detail::StepFacts removal_facts(ConnectionIndex c, std::size_t num_open);
  [[nodiscard]] detail::StepFacts joining_facts(ConnectionIndex c, std::size_t num_open);
  [[nodiscard]] detail::StepFacts flooded_facts(SetView open, ConnectionIndex c);

  template <class Visit>
  void for_each_blocker_across(Visit&& visit);
  [[nodiscard]] bool some_direction_free();
  [[nodiscard]] std::span<const std::uint64_t> free_directions_of_few();
  [[nodiscard]] std::vector<DirectionIndex> free_directions_of_moved(
      const detail::StepFacts& facts);
  [[nodiscard]] bool separation_legal(const detail::StepFacts& facts);
  [[nodiscard]] double reward(const detail::StepFacts& facts) const;
  template <class Reward>
  [[nodiscard]] std::span<Action> removals(SetView open, Reward&& reward_of);
  [[nodiscard]] std::span<const Action> legal_actions(SetView open);
  [[nodiscard]] std::span<const Action> in_order(SetView open, std::span<Action> legal);
  [[nodiscard]] bool constraints_met(SetView open, ConnectionIndex c);
  [[nodiscard]] bool ruled_out_first(SetView open, ConnectionIndex c) const;
  [[nodiscard]] std::optional<ConnectionIndex> waiting(SetView open, ConnectionIndex c);
  [[nodiscard]] bool goes_on(SetView open, ConnectionIndex c);
  [[nodiscard]] std::optional<bool> goal_in_reach(ConnectionSet from);
};

[[gnu::always_inline]] inline detail::StepFacts Expander::Scratch::counts(
    ConnectionIndex c, std::size_t num_open) const {
  detail::StepFacts facts;
  facts.connection = c;
  facts.before = num_open + rules.num_kept;
  facts.completes = num_open == 1;
  if (rules.assembly) {
    // Backwards, the state that is left when c is off is the one in which it is made.
    facts.before = rules.making ? problem.num_connections() - facts.before : facts.before - 1;
    facts.after = facts.before + 1;
    if (!rules.making) facts.completes = num_open == rules.num_steps;
  } else {
    facts.after = facts.before - 1;
  }
  return facts;
}

}  // namespace orasp
