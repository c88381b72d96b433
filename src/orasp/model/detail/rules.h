#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "orasp/model/detail/connectivity.h"
#include "orasp/model/objective.h"
#include "orasp/model/problem.h"
#include "orasp/model/situation.h"
#include "orasp/model/tolerance.h"

/// The rules of the world, arranged for work: what TransitionSystem holds and Expander applies.
namespace orasp::detail {

inline constexpr std::size_t kUnlimited = std::numeric_limits<std::size_t>::max();
/// A formula of sizes alone is looked up in a table of its values up to this many parts (two values
/// for each pair of sizes).
inline constexpr std::size_t kMostPartsInTable = 2048;

enum class TermKind {
  PieceCost,
  CubesatZone,
  Indexed,
  Time,
  Travel,
  Fuel,
  Completion,
  Expression,
  Callable
};

/// One addend of the objective with its parameters resolved.
struct Term {
  TermKind kind = TermKind::PieceCost;
  double weight = 1;
  std::vector<double> piece_cost;  ///< by number of parts
  double p = 0;  ///< PieceCost: operation; Time: speed; Fuel: dry mass; Completion: join
  double q = 0;  ///< PieceCost: completion; Time: transfer; Fuel: e^k - 1; Completion: step
  double r = 0;  ///< Completion: bonus
  Vector3 depot{};
  const Expression* expression = nullptr;
  const Callable* callable = nullptr;
  std::size_t index = 0;  ///< of the term
  /// The reward depends on sizes and counts only, not on which parts are on which side: always so
  /// for some kinds, and for Fuel where all masses are equal (to `part_mass`), for Time where no
  /// part has a position.
  bool counting = false;
  double part_mass = 0;  ///< kg
  /// What the term earns is the connection's own (a step for it that separates nothing) and, where
  /// it separates, a gain that depends on nothing but A, B, the connection and whether it
  /// completes.
  bool piece_only = false;
  bool gain_by_sizes = false;  ///< piece_only, and the gain depends on the sizes of A and B alone
  bool gain_by_connection = false;  ///< piece_only, and the gain depends on the connection too
};

inline double zone_cost(std::size_t parts, std::size_t piece_parts, bool whole_start) {
  switch (parts) {
    case 1: return piece_parts >= 4 || whole_start ? 0.0967 : 0.0823;
    case 2: return 0.0722;
    case 3: return 0.0782;
    default: return 0;
  }
}

inline double fuel_reward(const Term& term, double moved_mass) {
  return 0.0 - (term.p * term.q + (term.p + moved_mass) * term.q);
}

inline double time_reward(const Term& term, double duration, std::optional<double> metres) {
  return 0.0 - (duration + (metres ? 2 * *metres / term.p : term.q));
}

/// The objectives that see nothing but sizes: a step that cuts a piece into a and b parts (0 and 0:
/// it separates nothing). `whole`: the piece is a whole starting piece.
[[gnu::always_inline]] inline double size_reward(const Term& term, std::size_t a, std::size_t b,
                                                 bool completes, bool whole) {
  const bool separates = a != 0;
  switch (term.kind) {
    case TermKind::PieceCost:
      if (completes) return term.q;
      if (!separates) return 0.0 - term.p;
      return 0.0 - (term.p + term.piece_cost[a] + term.piece_cost[b]);
    case TermKind::CubesatZone:
      if (completes) return 1;
      if (!separates) return 0;
      return 0.0 - (zone_cost(a, a + b, whole) + zone_cost(b, a + b, whole));
    case TermKind::Completion:
      return (separates ? term.p : 0.0) - term.q + (completes ? term.r : 0.0);
    default: break;
  }
  assert(false);
  return 0;
}

constexpr bool sees_sizes_only(TermKind kind) {
  return kind == TermKind::PieceCost || kind == TermKind::CubesatZone ||
         kind == TermKind::Completion;
}

/// The problem, arranged for work.
struct Rules {
  bool assembly = false;
  std::size_t words = 1;
  AssemblyGraph graph;

  std::vector<std::uint64_t> constrained;  ///< connections with a clause of precedence
  std::vector<std::uint64_t> after;        ///< by connection: union of its `after` lists
  std::vector<std::vector<std::vector<std::uint64_t>>>
      any;  ///< by connection: its `after_any` lists
  std::size_t max_subassemblies = kUnlimited;
  std::size_t max_moved_parts = kUnlimited;
  double max_moved_mass = kInfinity;
  bool blocking = false;

  bool uniform_mass = true;
  double total_mass = 0;
  std::vector<Term> terms;
  std::vector<double> lightest;  ///< kg, by number of parts: the least that so many parts can weigh
  std::vector<double> heaviest;  ///< and the most
  std::vector<double> farthest;  ///< by term: greatest distance of a part to the term's depot
  bool one_counting_term = false;  ///< the objective is a single counting term of weight 1
  bool needs_movement = false;     ///< the objective looks at which side moves, or at masses
  bool needs_sides = false;        ///< the parts of A and B must be listed
  bool cuts_checked = false;       ///< some constraint judges separations

  // Where the work stands (Situation), over the same connections.
  ConnectionSet start;     ///< open and accessible: what is to be handled
  ConnectionSet kept;      ///< open and inaccessible
  ConnectionSet not_next;  ///< of `start`
  ConnectionSet late;      ///< of `start`
  std::size_t num_kept = 0;
  bool whole = true;     ///< everything is to be handled and in any order that is legal
  bool ordered = false;  ///< something cannot be next or is late

  Rules(const Problem& problem, const Situation& situation);
  void look_at_gain(const Problem& problem, Term& term) const;
  void add_terms(const Problem& problem, const Objective& objective, double weight);
  [[nodiscard]] bool precedence_met(SetView open, ConnectionIndex c) const;
  void take(const Situation& situation);
};

}  // namespace orasp::detail
