#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "orasp/bounds/piece_gains.h"
#include "orasp/model/connection_set.h"
#include "orasp/model/tolerance.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// What becomes of a product piece by piece after each legal step, by a quick plan of the piece
/// that the step changes. A policy looks at it, and nothing that is proved rests on it.
///
/// Idea.       Rewards are sums over pieces, so a step is told by the piece that it changes. A
///             piece of up to kExact parts is worked out over all its cuts: V(S) = max of gain(A,
///             B) + V(A) + V(B) (Bellman's recursion over pieces; blocking looks at A and B alone).
///             A larger one is peeled: of the sizes of a cut, the best by the bound first, the
///             first cut that hangs together and that blocking allows, and so on with both sides.
///             Cuts of one to three parts, and those at single connections, are looked at. Where
///             the plan that follows earns less than the bound, other cuts are tried, until
///             kMostTried pieces were looked at.
/// Reference.  A quick plan as the estimate of a state: rollouts, Bertsekas, Tsitsiklis and Wu
///             (1997), Journal of Heuristics 3, 245-262.
/// Guarantee.  Deterministic. Precedence and max_subassemblies are not looked at, so an estimate
///             may be too high there; and too low wherever a better plan is not found.
/// Applies.    Where steps take apart and what a cut gains depends on sizes alone
///             (TransitionSystem::gain_by_sizes), without a base, a limit of mass, or connections
///             that are kept; for pieces of up to 64 parts.
/// Cost.       O(parts^2) once. A piece of n parts is peeled in O(n (parts + connections)) steps of
///             words of 64 bits; every set of parts once a state.
class PieceOutlook {
 public:
  static constexpr std::size_t kMostParts = 64;
  static constexpr std::size_t kExact = 7;
  static constexpr std::size_t kMostTried = 32;
  static constexpr std::size_t kTriedForStep = 1;

  /// One legal step.
  struct Step {
    bool known = false;
    /// What the piece that the step changes loses by it, beside the best that is known of the piece
    /// now: 0 where nothing is lost. Infinite where its quick plan comes to a piece without a cut.
    double loss = 0;
    /// Whether the quick plan earns what sizes allow, so that nothing better is there.
    bool at_bound = false;
  };

  /// The system must outlive it.
  explicit PieceOutlook(const TransitionSystem& system);
  explicit PieceOutlook(const TransitionSystem&&) = delete;

  [[nodiscard]] bool known() const { return known_; }
  /// What a cut gains in the mean, in the best case of the start: a unit to measure losses in.
  /// Positive.
  [[nodiscard]] double unit() const { return unit_; }
  /// The legal steps of the state `open`. Valid until the next call.
  [[nodiscard]] std::span<const Step> look(SetView open, std::span<const Action> actions);

 private:
  using Mask = std::uint64_t;
  /// Values of sets of parts, forgotten all at once.
  class Values {
   public:
    void clear();
    [[nodiscard]] const double* find(Mask parts) const;
    void put(Mask parts, double value);

   private:
    struct Slot {
      Mask parts = 0;
      std::uint32_t round = 0;
      double value = 0;
    };
    [[nodiscard]] std::size_t slot_of(Mask parts) const;
    std::vector<Slot> slots_ = std::vector<Slot>(1024);
    std::uint32_t round_ = 1;
    std::size_t size_ = 0;
  };

  void enter(std::span<const PartIndex> piece, SetView present);
  void look_at_piece(std::span<const Action> actions, std::span<const std::size_t> mine);
  [[nodiscard]] bool connected(Mask parts) const;
  /// Whether what is left of `parts`, which hang together, without `taken` hangs together.
  [[nodiscard]] bool holds_without(Mask parts, Mask taken) const;
  [[nodiscard]] Mask reached(std::uint32_t from, Mask parts) const;
  [[nodiscard]] bool comes_apart(Mask a, Mask b) const;
  [[nodiscard]] double gain(std::size_t a, std::size_t b) const;
  /// The most that the cuts of a piece of so many parts gain.
  [[nodiscard]] double most(std::size_t parts) const { return gains_.by_size(parts); }
  double value(Mask parts, std::size_t size);
  double exact(Mask parts, std::size_t size);
  double peeled(Mask parts, std::size_t size);
  /// Calls visit(A) for the cuts of `parts` into A, of `size` parts, and the rest that hang
  /// together and come apart, until it says false.
  template <class Visit>
  bool for_each_cut(Mask parts, std::size_t total, std::size_t size, Visit&& visit);
  template <class Visit>
  bool for_each_single(Mask parts, Visit&& visit);

  const TransitionSystem& system_;
  PieceGains gains_;
  bool known_ = false;
  double unit_ = 1;
  /// By parts of a piece: the sizes of the smaller side, the best by the bound first.
  std::vector<std::vector<std::uint32_t>> sizes_;
  std::vector<Step> steps_;

  ConnectionSet present_;
  // The piece that is looked at.
  std::vector<std::uint32_t> local_;         ///< by part: its bit
  std::vector<Mask> around_;                 ///< by bit
  std::vector<std::vector<Mask>> blockers_;  ///< by direction and bit
  Values values_;                            ///< of the piece as it is
  Values changed_;                           ///< of sets that hold both ends of what is left out
  Mask left_out_ = 0;
  std::size_t tried_ = 0;
  std::size_t most_tried_ = 0;
};

}  // namespace orasp
