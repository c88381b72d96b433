#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "orasp/bounds/piece_gains.h"
#include "orasp/model/connection_set.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// Which few parts could come off next, and what that loses by the bound. A policy looks at it, and
/// nothing that is proved rests on it.
///
/// Idea.       Where parts hang together in cycles, a step seldom separates anything: several
///             connections go until a few parts come off, and only then is something earned or
///             lost. So what a step is good for is told by the sets that it helps to cut off. All
///             connected sets S of up to kMost parts are listed whose piece P hangs together
///             without them, each with what cutting it off now loses at least, h(P) - gain(S, P\S)
///             - h(S) - h(P\S), where h bounds what the cuts of a piece gain (PieceGains), and with
///             how many connections still hold it. For prices of parts that is the reduced cost
///             of S.
/// Reference.  Reduced costs as a measure of what a column is good for: Dantzig and Wolfe (1960),
///             Operations Research 8(1), 101-111.
/// Guarantee.  Deterministic. Precedence is not looked at.
/// Applies.    Where steps take apart, the objective sees the piece only and pieces have a bound;
///             pieces end as single parts.
/// Cost.       A state: O(connected sets of kMost parts times (parts + connections) of their
///             piece).
class CutOutlook {
 public:
  static constexpr std::size_t kMost = 3;

  /// What a connection helps to cut off.
  struct Step {
    bool known = false;  ///< whether it holds such a set
    double loss = 0;     ///< the least loss of the sets that it holds
    /// Of those that lose least: the fewest connections that hold one.
    std::size_t left = 0;
    /// Whether it holds the set of its piece that loses least; of several the one with fewest
    /// connections, then the first.
    bool holds_best = false;
  };

  /// The system and `gains`, of the same system, must outlive it.
  CutOutlook(const TransitionSystem& system, std::shared_ptr<const PieceGains> gains);
  CutOutlook(const TransitionSystem&&, std::shared_ptr<const PieceGains>) = delete;

  [[nodiscard]] bool known() const { return known_; }
  /// The legal steps of the state `open`. Valid until the next call.
  [[nodiscard]] std::span<const Step> look(SetView open, std::span<const Action> actions);

 private:
  /// Parts that could come off, and what holds them.
  struct Cut {
    double loss;
    std::size_t left;
    std::size_t first_held;  ///< where in held_ its connections begin
  };
  void look_at_piece(std::span<const PartIndex> piece);
  void look_at_set(std::span<const PartIndex> piece, std::span<const PartIndex> set);
  [[nodiscard]] double bound_of(std::span<const PartIndex> piece) const;

  const TransitionSystem& system_;
  std::shared_ptr<const PieceGains> gains_;
  Expander expander_;
  bool known_ = false;
  double slack_ = 0;
  std::vector<Step> steps_;
  // Scratch of a state, and of a piece.
  ConnectionSet present_;
  std::size_t may_part_ = 0;  ///< how many more pieces of several parts there may be
  std::vector<std::uint32_t> mark_;
  std::uint32_t round_ = 0;
  std::vector<PartIndex> order_;
  std::vector<PartIndex> rest_;
  double of_piece_ = 0;
  std::vector<Cut> cuts_;
  std::vector<ConnectionIndex> held_;
  std::vector<Step> by_connection_;
};

}  // namespace orasp
