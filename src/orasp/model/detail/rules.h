#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "orasp/model/detail/connectivity.h"
#include "orasp/model/detail/listing.h"
#include "orasp/model/detail/problem_totals.h"
#include "orasp/model/objectives/objective_term.h"
#include "orasp/model/problem.h"
#include "orasp/model/situation.h"
#include "orasp/model/tolerance.h"

/// The rules of the world, arranged for work: what TransitionSystem holds and Expander applies.
namespace orasp::detail {

inline constexpr std::size_t kUnlimited = std::numeric_limits<std::size_t>::max();

/// In which order the states of a problem's plans are met.
enum class Walk {
  Forwards,   ///< from where the work stands to its end
  Backwards,  ///< of an assembly: from the product that it ends with back to where the work stands
};

/// How the context of a state is written down: what the steps before left behind, for objectives
/// that look back.
struct ContextLayout {
  /// By attribute (ProblemTotals::attributes): how many numbers it may have in force, and what one
  /// of them counts in the first word.
  std::vector<std::uint64_t> radix;
  std::vector<std::uint64_t> stride;
  /// By attribute: the connections that have a value; empty for the direction.
  std::vector<std::vector<std::uint64_t>> with_value;
  /// Where steps were done: by connection, the number of its place from 1, and the places. Where
  /// steps handle one connection, the number of the last place stands in the first word; else its
  /// coordinates stand in three words of their own, after a flag.
  std::vector<std::uint32_t> place_of;
  std::vector<Vector3> places;
  std::uint64_t place_stride = 0;  ///< 0 where no objective looks at places
  bool coordinates = false;
  std::size_t words = 0;
};

/// The problem, arranged for work.
///
/// Precedence. A state is one that precedence allows if what is missing in it could have been taken
/// off in some order, as `after` and `after_any` ask, and what is there could have been put on in
/// some order, as `made_after_any` asks (`after` asks both times: what is removed after a
/// connection is made before it). A step is legal if it obeys its own clauses and comes to such a
/// state. In disassembly what is missing has been taken off, so only `made_after_any` must be
/// looked at ahead; in assembly what is there has been put on, so it is `after`, by a mask, and
/// `after_any`, by going through what is missing. Both look at one end alone, so where `after_any`
/// and `made_after_any` stand in one problem dead ends may remain.
struct Rules {
  bool assembly = false;  ///< steps are counted, named and paid as those of an assembly
  bool making = false;    ///< steps put connections on: an assembly, walked forwards
  std::size_t words = 1;
  AssemblyGraph graph;

  using Words = std::vector<std::uint64_t>;
  Words constrained;  ///< connections whose steps precedence may forbid
  Words after;        ///< by connection: union of its `after` lists
  Words before;       ///< by connection: all that have it in their `after` lists, where asked for
  std::vector<std::vector<Words>> any;       ///< by connection: its `after_any` lists
  std::vector<std::vector<Words>> made_any;  ///< by connection: its `made_after_any` lists
  /// A list of `any` or of `made_any`: its connection and its place there.
  struct ListOfMany {
    ConnectionIndex connection;
    std::size_t list;
  };
  /// By connection: the lists that name it, of the kind that must be looked at ahead.
  std::vector<std::vector<ListOfMany>> named_in;
  std::size_t max_subassemblies = kUnlimited;
  std::size_t max_moved_parts = kUnlimited;
  double max_moved_mass = kInfinity;
  bool blocking = false;
  bool fixed_parts = false;  ///< there is a base
  bool grounded = false;

  ProblemTotals totals;
  std::vector<WeightedTerm> terms;  ///< the addends of the objective
  bool checks_rewards = false;      ///< how large rewards are is seen step by step alone
  bool one_counting_term = false;   ///< the objective is a single counting term of weight 1
  bool needs_movement = false;      ///< the objective looks at which side moves, or at masses
  bool needs_sides = false;         ///< the parts of A and B must be listed
  bool cuts_checked = false;        ///< some constraint judges separations
  // What makes states and steps wide (TransitionSystem::wide).
  bool wide = false;
  bool by_part = false;  ///< StepKind::Part
  bool has_goal = false;
  bool may_stop = false;  ///< Goal::Stop::Best
  Words goal;             ///< the connections that the goal asks to be gone
  ContextLayout context;
  bool needs_elapsed = false;  ///< the objective looks at the time that has passed

  // Where the work stands (Situation), over the same connections.
  ConnectionSet start;     ///< open and accessible: what is to be handled
  ConnectionSet kept;      ///< stays open: inaccessible; backwards, what is made already
  ConnectionSet not_next;  ///< of `start`
  ConnectionSet late;      ///< of `start`
  std::size_t num_kept = 0;
  std::size_t num_steps = 0;  ///< connections of `start`
  bool whole = true;          ///< everything is to be handled and in any order that is legal
  bool ordered = false;       ///< something cannot be next or is late
  /// Whether a legal step may lead to a state from which the goal cannot be reached.
  bool may_shut_out = false;

  /// Of whoever plans, who holds the rules as they are.
  mutable Listing listing{};

  Rules(const Problem& problem, const Situation& situation, Walk walk);
  [[nodiscard]] bool precedence_met(SetView open, ConnectionIndex c) const;
  /// Word `w` of the connections that are there while `c`, which is open, is not yet or no longer.
  [[nodiscard]] std::uint64_t there_without(SetView open, ConnectionIndex c, std::size_t w) const {
    const std::uint64_t stays = open[w] | kept.view()[w];
    const std::uint64_t self = w == c / 64 ? std::uint64_t{1} << (c % 64) : 0;
    return (making ? ~stays : stays) & ~self;
  }
  /// The lists that name `c` and that handling it in the state `open` makes impossible to meet: of
  /// connections that nothing could put on any more (disassembly), or take off (assembly).
  [[nodiscard]] std::vector<ListOfMany> lists_shut(SetView open, ConnectionIndex c) const;
  void set_precedence(const Problem& problem);
  void set_wide(const Problem& problem, const Situation& situation);
  /// The words of the context where the work stands.
  [[nodiscard]] Words start_context(const Situation& situation) const;
  /// Whether precedence allows a state, where a step may handle several connections: what is gone
  /// went with or after all that it had to wait for, and what is there has what it needs.
  [[nodiscard]] bool state_allowed(SetView open) const;
  /// Whether nothing of what is there in the state `open` must go before one of `handled`, by
  /// `after` and its like; lists of which one is enough are not looked at.
  [[nodiscard]] bool precedence_met_within(SetView open,
                                           std::span<const ConnectionIndex> handled) const;
  /// Whether the goal holds where these connections are there.
  [[nodiscard]] bool goal_holds(SetView present) const {
    for (std::size_t w = 0; w < words; ++w) {
      if ((goal[w] & present[w]) != 0) return false;
    }
    return true;
  }
  void set_situation(const Situation& situation);
  void size_up_rewards(const Problem& problem);
};

}  // namespace orasp::detail
