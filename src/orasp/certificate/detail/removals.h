#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "orasp/model/detail/checked_reward.h"
#include "orasp/model/problem.h"

namespace orasp::detail {

/// A problem read once more, for certificates: what may be removed from a state, and what it earns.
///
/// A state is the set of connections that are present. An assembly is looked at backwards: a step
/// that makes a connection is its removal from the state behind it, and the last step of all is the
/// first removal. So every plan is a way from all connections to none, whatever its direction.
///
/// The rules are those sentences of docs/format.md that say what a plan must keep; where a step is
/// kept from what would shut others out, that is left to the end of the plan: no plan gets there.
/// Rewards come from the second formula of each objective (CheckedReward), by which plans are
/// checked. Nothing here is shared with those who plan.
class Removals {
 public:
  /// @throws InputError as CheckedReward.
  explicit Removals(const Problem& problem);

  /// What there is to say against the whole product, where the problem has something to handle:
  /// too many subassemblies, or one without a base part.
  [[nodiscard]] bool start_allowed() const;

  /// Makes `present` the state that the members below speak of.
  void look_at(const ConnectionSet& present);
  /// Whether `connection`, which is present, may be removed.
  [[nodiscard]] bool allowed(ConnectionIndex connection);
  /// Whether a piece may be separated into these two, as far as that depends on nothing else than
  /// they: limits on what moves, grounded pieces, blocking. Both are not empty, and ascending. What
  /// look_at() was told is kept; what allowed() was asked about last is not.
  [[nodiscard]] bool cut_allowed(const std::vector<PartIndex>& a, const std::vector<PartIndex>& b);
  /// A sum that is at least what the step earns, with all attempts that it takes on average.
  struct Reward {
    double most = 0;
    bool finite = true;
  };
  /// Of the connection that allowed() was asked about last.
  [[nodiscard]] Reward reward() const;
  /// Whether that removal separates.
  [[nodiscard]] bool separates() const { return separates_; }
  /// The numbers of parts of A and B, where it does.
  [[nodiscard]] std::size_t a_parts() const { return separates_ ? a_.parts.size() : 0; }
  [[nodiscard]] std::size_t b_parts() const { return separates_ ? b_.parts.size() : 0; }

 private:
  struct Piece {
    std::vector<PartIndex> parts;  ///< ascending
    double mass = 0;
    std::size_t base_parts = 0;
  };
  [[nodiscard]] bool precedence_allows(ConnectionIndex connection) const;
  [[nodiscard]] bool limits_allow() const;
  [[nodiscard]] bool limits_allow_pieces() const;
  [[nodiscard]] bool some_way_out() const;
  void part_at(ConnectionIndex connection);
  void walk(PartIndex from, ConnectionIndex without);
  [[nodiscard]] Piece piece_of(const std::vector<PartIndex>& parts) const;
  [[nodiscard]] bool first_moves() const;

  const Problem& problem_;
  bool assembly_;
  CheckedReward rewards_;
  bool equal_masses_ = true;
  bool has_numbers_ = false;
  std::vector<std::vector<ConnectionIndex>> around_;           ///< by part
  std::vector<std::vector<const PrecedenceClause*>> clauses_;  ///< by connection

  ConnectionSet present_;
  std::size_t subassemblies_ = 0;  ///< of present_
  double missing_seconds_ = 0;     ///< durations of what is not present
  // The removal at hand.
  ConnectionIndex connection_ = 0;
  bool separates_ = false;
  Piece a_;
  Piece b_;
  bool moves_ = false;
  bool a_moves_ = false;
  std::vector<bool> reached_;
  std::vector<PartIndex> walked_;
};

}  // namespace orasp::detail
