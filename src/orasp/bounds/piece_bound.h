#pragma once

#include <memory>
#include <span>
#include <vector>

#include "orasp/bounds/bound.h"
#include "orasp/bounds/piece_gains.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// A bound that looks at each piece of a state: at its size, at what moving its parts costs, or at
/// the better of the two for each piece.
///
/// Admissible. By sizes: each piece of n parts is cut n - 1 times, each cut parts it into two
///             sizes, and only cuts of sizes that the limits forbid are left out. By moved parts:
///             see PiecePrices. Other constraints only take choices away.
/// Consistent. For every legal cut of S into A and B, g(S) >= gain + g(A) + g(B) for each of the
///             two bounds, and so for the smaller of the two.
/// Connections. From both is taken what the connections at which pieces are cut cost (CutTrees),
///             by those that are still there.
/// Units.      Where connections are kept for ever, a piece ends as units of several parts
///             (PartUnits). It has that many cuts fewer, and each unit but one ends as the last of
///             what was moved, so it pays the price of any one of its parts. What completing adds
///             then depends on the piece that is cut last.
/// Completing. Where it is the first step that completes (TransitionSystem::backwards) there is one
///             state before it, the start. Its bound is the greatest, over its legal steps, of what
///             the step earns and the bound of the state that it leads to.
/// Limit.      The bound is infinite where the objective sees more than the piece, where steps make
///             connections, and where PieceGains knows none of the two.
/// Cost.       O(parts^2) once, O(parts + connections) a state.
class PieceBound final : public Bound {
 public:
  enum class Kind { Sizes, Parts, Both };

  /// What was worked out for `like`, a bound of the same system, is shared with it.
  PieceBound(const TransitionSystem& system, Kind kind, const PieceBound* like = nullptr);
  /// With `gains` of the system.
  PieceBound(const TransitionSystem& system, Kind kind, std::shared_ptr<const PieceGains> gains);
  ~PieceBound() override;

  [[nodiscard]] bool known() const override { return known_; }
  [[nodiscard]] const std::shared_ptr<const PieceGains>& gains() const { return gains_; }
  /// Whether it tells connections apart (CutTrees).
  [[nodiscard]] bool sees_connections() const { return known_ && gains_->trees().any(); }
  [[nodiscard]] double operator()(SetView open) override;
  void of_successors(SetView open, double here, std::span<const Action> actions,
                     std::span<double> bounds) override;
  /// Adds to the reward of each action the change of the bound that the action brings: minus what a
  /// plan loses at least by it, and 0 for the actions that keep the bound within reach.
  void add_change(SetView open, std::span<Action> actions);
  /// Whether the bound by sizes lets no cut of a piece of so many parts gain more than one that
  /// takes a single part off; true where there is no such bound.
  [[nodiscard]] bool single_part_is_best(std::size_t parts) const;

 private:
  struct Scratch;
  void look_at_first_step(const TransitionSystem& system);
  [[nodiscard]] double of_piece(std::span<const PartIndex> piece) const;
  [[nodiscard]] double of_last_piece(std::span<const PartIndex> piece) const;
  double measure_units(SetView open);
  void of_successors_by_runs(double here, std::span<const Action> actions,
                             std::span<double> bounds);
  void of_successors_with_units(SetView open, double here, std::span<const Action> actions,
                                std::span<double> bounds);

  void of_successors_by_pieces(SetView open, double here, std::span<const Action> actions,
                               std::span<double> bounds);

  std::shared_ptr<const PieceGains> gains_;
  bool sizes_ = false;
  bool parts_ = false;
  bool known_ = false;
  /// Where the first step completes: the open connections of the start, and by how much its bound
  /// is above that of its pieces.
  bool completes_first_ = false;
  std::size_t num_steps_ = 0;
  double first_extra_ = 0;
  std::vector<double> changes_;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace orasp
