#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
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
  /// Where the objective is a function of many steps, it.
  const ObjectiveTerm* notes = nullptr;
  /// Whether it is asked about many states: their actions, and where those of each state end.
  bool asking_many = false;
  std::vector<Action> actions_of_many;
  std::vector<std::size_t> ends_of_many;
  std::vector<std::uint64_t> present_words;  ///< where what is there differs from the open set
  std::vector<std::uint64_t> present_batch;  ///< the same for several states
  detail::Connectivity connectivity;
  /// A and B of the step at hand; set by whoever makes its facts, if rules.needs_sides.
  detail::StepPieces pieces;
  /// Where the objective asks for it: the durations of what is handled in the state at hand.
  double handled_seconds = 0;
  std::vector<unsigned char> mark;       ///< by part; all 0 between uses
  std::vector<std::uint64_t> free_bits;  ///< directions
  std::vector<PartIndex> fill_a;
  std::vector<PartIndex> fill_b;
  /// For late connections: steps in any order, and which states are known to lead to the goal.
  std::unique_ptr<Expander> in_any_order;
  std::unordered_map<ConnectionSet, bool> leads_to_goal;

  Scratch(const Problem& the_problem, const TransitionSystem::Rules& the_rules,
          const TransitionSystem* any_order);

  // Where rules.wide: the legal actions of the state last expanded, what each takes, and where it
  // leads.
  struct Move {
    std::size_t first = 0;  ///< its connections stand in move_connections from here on
    std::size_t size = 0;
    std::optional<DirectionIndex> direction;
  };
  std::vector<Action> wide_legal;
  std::vector<Move> moves;
  std::vector<ConnectionIndex> move_connections;
  std::vector<std::uint64_t> move_successors;
  detail::StepMemory memory;
  std::vector<std::uint32_t> in_force;
  std::vector<std::uint32_t> here;
  std::vector<std::uint64_t> next_open;
  std::vector<std::uint32_t> rest_sizes;
  [[nodiscard]] std::span<const Action> wide_actions(SetView state);
  void connection_moves(SetView open);
  void part_moves(SetView open);
  [[nodiscard]] bool leaves_somewhere(std::span<const PartIndex> moved,
                                      std::span<const unsigned char> marked);
  [[nodiscard]] std::size_t subassemblies_of(SetView there) const;
  void making_part_moves(SetView open);
  struct TouchingPieces {
    std::vector<std::vector<PartIndex>> pieces;
    std::vector<std::vector<std::size_t>> touched;  ///< by piece, the numbers of others
  };
  [[nodiscard]] TouchingPieces touching_pieces(SetView there, SetView connections) const;
  void part_moves_to(SetView open, SetView wanted);
  void leave_list_if_told(std::uint64_t& asked) const;
  /// Where not empty: of the steps that take parts off or put them on, those that lead to a state
  /// in which this is open.
  std::vector<std::uint64_t> target;
  std::size_t subassemblies_now = 0;  ///< pieces of two or more parts before the moves listed
  /// Where the steps of one piece are listed (Expander::piece_steps): whether one completes.
  std::optional<bool> piece_completes;
  void offer_part(SetView open, std::span<const PartIndex> moved,
                  std::span<const std::vector<PartIndex>> rest);
  void offer_move(SetView open, detail::StepFacts& facts, const detail::Movement& movement,
                  std::span<const ConnectionIndex> connections);
  void add_move(const detail::StepFacts& facts, const detail::Movement& movement,
                std::span<const ConnectionIndex> connections,
                std::optional<DirectionIndex> direction);
  void add_stop();
  void recall(SetView state);
  void write_successor();
  [[nodiscard]] std::vector<DirectionIndex> ways_of_moved(const detail::Movement& movement);

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
  // With `direction_free` blocking is known to allow the step.
  [[nodiscard]] bool separation_legal(const detail::StepFacts& facts, bool direction_free = false);
  [[nodiscard]] bool separation_legal_on_base(const detail::StepFacts& facts, bool direction_free);
  [[nodiscard]] bool leaves_grounded(const detail::StepFacts& facts) const;
  void set_elapsed(SetView open);
  [[nodiscard]] double reward(const detail::StepFacts& facts) const;
  template <class Reward>
  [[nodiscard]] std::span<Action> removals(SetView open, Reward&& reward_of);
  [[nodiscard]] std::span<const Action> legal_actions(SetView open);
  void fill_in_rewards(std::span<Action> noted) const;
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
  if (rules.needs_elapsed) {
    facts.elapsed = handled_seconds;
    // Backwards the state at hand has the connection that is made.
    if (rules.assembly && !rules.making) facts.elapsed -= problem.connections()[c].duration;
  }
  return facts;
}

// Where steps take connections away, after connectivity.analyse(): the piece that holds c falls
// apart into A and B.
[[gnu::always_inline]] inline detail::StepFacts Expander::Scratch::removal_facts(
    ConnectionIndex c, std::size_t num_open) {
  detail::StepFacts facts = counts(c, num_open);
  const std::uint32_t below = connectivity.below(c);
  facts.separates = below != 0;
  facts.subassemblies_joined = connectivity.subassemblies();
  facts.subassemblies_apart = facts.subassemblies_joined;
  if (!facts.separates) return facts;
  const std::uint32_t above = connectivity.piece(c) - below;
  const bool lower_is_a = connectivity.lower_end(c) == problem.ends(c)[0];
  facts.a_parts = lower_is_a ? below : above;
  facts.b_parts = lower_is_a ? above : below;
  facts.subassemblies_apart += std::size_t{below >= 2} + std::size_t{above >= 2};
  facts.subassemblies_apart -= 1;
  if (rules.needs_sides) {
    pieces.a = connectivity.lower_side(c);
    pieces.b = connectivity.upper_side(c);
    if (!lower_is_a) std::swap(pieces.a, pieces.b);
  }
  return facts;
}

}  // namespace orasp
