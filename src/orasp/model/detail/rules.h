#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "orasp/model/detail/connectivity.h"
#include "orasp/model/detail/problem_totals.h"
#include "orasp/model/objectives/objective_term.h"
#include "orasp/model/problem.h"
#include "orasp/model/situation.h"
#include "orasp/model/tolerance.h"

/// The rules of the world, arranged for work: what TransitionSystem holds and Expander applies.
namespace orasp::detail {

inline constexpr std::size_t kUnlimited = std::numeric_limits<std::size_t>::max();

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

  ProblemTotals totals;
  std::vector<WeightedTerm> terms;  ///< the addends of the objective
  bool checks_rewards = false;      ///< how large rewards are is seen step by step alone
  bool one_counting_term = false;   ///< the objective is a single counting term of weight 1
  bool needs_movement = false;      ///< the objective looks at which side moves, or at masses
  bool needs_sides = false;         ///< the parts of A and B must be listed
  bool cuts_checked = false;        ///< some constraint judges separations

  // Where the work stands (Situation), over the same connections.
  ConnectionSet start;     ///< open and accessible: what is to be handled
  ConnectionSet kept;      ///< open and inaccessible
  ConnectionSet not_next;  ///< of `start`
  ConnectionSet late;      ///< of `start`
  std::size_t num_kept = 0;
  bool whole = true;     ///< everything is to be handled and in any order that is legal
  bool ordered = false;  ///< something cannot be next or is late

  Rules(const Problem& problem, const Situation& situation);
  [[nodiscard]] bool precedence_met(SetView open, ConnectionIndex c) const;
  void set_situation(const Situation& situation);
  void size_up_rewards(const Problem& problem);
};

}  // namespace orasp::detail
