#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "orasp/model/transition_system.h"

namespace orasp {

namespace detail {
class AssemblyGraph;
}

/// An upper bound on the reward still to come from a state; 0 at the goal. Each is admissible
/// (never below the best that a plan can still earn) and consistent (along a legal step it falls by
/// at least what the step earns), with the reason in its comment. Holds scratch memory: one for
/// each thread.
class Bound {
 public:
  Bound() = default;
  Bound(const Bound&) = delete;
  Bound& operator=(const Bound&) = delete;
  virtual ~Bound() = default;

  /// Whether it says anything about this problem; if not it is infinite.
  [[nodiscard]] virtual bool known() const = 0;
  [[nodiscard]] virtual double operator()(SetView open) = 0;
  /// The bounds of the states that `actions` of the state `open` lead to. `here` is the bound of
  /// `open`.
  virtual void of_successors(SetView open, double here, std::span<const Action> actions,
                             std::span<double> bounds);

 private:
  std::vector<std::uint64_t> successor_;
};

/// For any objective: each open connection earns at most its greatest reward
/// (TransitionSystem::reward_range), and the last step at most `last_surplus` more.
///
/// Admissible: yes, a plan handles each open connection once and each step earns at most its range
/// allows.
/// Consistent: yes, h(s) - h(s') = greatest(c) >= r(s, c) for a step that handles c and
/// does not complete.
/// Infinite where no range is known; then it proves nothing.
/// Cost: O(open connections); a search carries it along at one subtraction a step (greatest).
class ConnectionBound final : public Bound {
 public:
  explicit ConnectionBound(const TransitionSystem& system);

  [[nodiscard]] bool known() const override { return known_; }
  [[nodiscard]] double operator()(SetView open) override;
  void of_successors(SetView open, double here, std::span<const Action> actions,
                     std::span<double> bounds) override;
  /// Most that handling `connection` can earn when it is not the last step.
  [[nodiscard]] double greatest(ConnectionIndex connection) const { return greatest_[connection]; }
  /// Most that the last step can earn above greatest() of its connection.
  [[nodiscard]] double last_surplus() const { return last_surplus_; }

 private:
  bool known_ = true;
  double last_surplus_ = 0;
  std::vector<double> greatest_;
};

/// What the bounds for objectives that see the piece only (TransitionSystem::sees_piece_only) have
/// in common, in disassembly. Such a plan earns
///
///     sum over open connections of own(c)  +  sum over pieces of what their cuts gain
///       +  what completing adds once,
///
/// and each piece of n parts is cut exactly n - 1 times, whatever becomes of the others. A bound is
/// then a bound on what the cuts of one piece can gain.
class PieceGains {
 public:
  static constexpr std::size_t kMostParts = 4096;

  explicit PieceGains(const TransitionSystem& system);

  [[nodiscard]] bool known() const { return known_; }
  [[nodiscard]] double own(ConnectionIndex connection) const { return own_[connection]; }
  /// Most that completing adds to the last step.
  [[nodiscard]] double last_surplus() const { return last_surplus_; }
  /// Whether all finite (else a limit forbids to cut some size at all).
  [[nodiscard]] bool sizes_known() const { return sizes_known_; }
  [[nodiscard]] bool parts_known() const { return parts_known_; }

  /// Whether pieces may end as more than one part, because connections are kept
  /// (TransitionSystem::kept).
  [[nodiscard]] bool has_units() const { return !merged_.empty(); }
  /// Parts of a piece less the units that it ends as: what kept connections hold together is a
  /// unit. 0 without any.
  [[nodiscard]] std::size_t excess(std::span<const PartIndex> piece) const;
  /// By sizes, for a piece of n parts that ends as n - d units, so is cut n - d - 1 times, whatever
  /// their sizes:
  ///
  ///     g(n, d) = max over a + b = n, i + j = d of gain(a, b) + g(a, i) + g(b, j),   i < a, j < b,
  ///     g(n, n - 1) = 0.
  [[nodiscard]] double by_size(std::size_t parts, std::size_t excess) const {
    return excess == 0 ? by_size_[parts] : by_excess_[excess - 1][parts];
  }

  /// The same where the piece's last cut is the last step of all, which adds S to it; S depends on
  /// the two units that it parts, whose sizes are known:
  ///
  ///     g*(a + b, a + b - 2) = gain(a, b) + S(a, b),
  ///     g*(n, d) = max over cuts of gain(a, b) + max(g*(a, i) + g(b, j), g(a, i) + g*(b, j)).
  ///
  /// -infinity for a piece that is one unit.
  [[nodiscard]] double last_by_size(std::size_t parts, std::size_t excess) const {
    return last_by_excess_[excess][parts];
  }
  /// Most that completing adds to a last step that separates nothing, or that does; -infinity where
  /// there is none. Known only if has_units().
  [[nodiscard]] double surplus_without_cut() const { return surplus_without_cut_; }
  [[nodiscard]] double surplus_of_cut() const { return surplus_of_cut_; }

  /// By sizes alone: g(n) = max over a + b = n of gain(a, b) + g(a) + g(b), g(1) = 0, the smaller
  /// of a, b at most max_moved_parts. The recursion is Bellman's over sizes.
  [[nodiscard]] double by_size(std::size_t parts) const { return by_size_[parts]; }
  /// The same for a piece that falls into `arms` components without some part v: each side of a cut
  /// without v lies within one of them, so v sees at least as many cuts as there are arms:
  ///
  ///     g(n, k) = max over a + b = n of gain(a, b) + g(a) + g(b, k - 1),   b > k - 1,
  ///
  /// where v is in the side of b.
  ///
  /// It tells a hub from a chain. Up to kMostArms, more count as that many, and up to
  /// 512 parts, beyond which it is by_size.
  static constexpr std::size_t kMostArms = 64;
  [[nodiscard]] double by_arms(std::size_t parts, std::size_t arms) const;

  /// The most that a cut into so many parts gains; -infinity where max_moved_parts forbids it.
  [[nodiscard]] double gain(std::size_t moved, std::size_t kept) const;
  /// By what moves: the sum of prices y(p) <= 0 over the parts of the piece, less the least of
  /// them.
  ///
  /// Simple prices: every part but one of a piece ends as the last of what was moved in some cut
  /// (follow the side that stays), a different cut for each part; y(p) is the most that a cut gains
  /// which moves a piece with p.
  ///
  /// Where at most three parts ever move, better ones. Let w(M) be what moving M gains and what M,
  /// on its own, gains from there on; M runs over all connected sets of up to three parts. If the
  /// prices of each M add up to w(M) or more, then what is taken off a piece gains at most its
  /// prices, so all of it at most the sum without the part that stays last. The least such prices
  /// are a linear program, the dual of covering the parts with moved pieces; they are found nearly
  /// by subgradients and then repaired, so that they are always valid. Pieces of up to three parts
  /// have their exact value, which keeps the bound consistent. Reference: Held and Karp (1971),
  /// Math. Programming 1, 6-25.
  [[nodiscard]] double by_parts(std::span<const PartIndex> piece) const;

 private:
  static constexpr std::size_t kMostPartsWithArms = 512;
  void find_units(const TransitionSystem& system);
  void measure_last(const TransitionSystem& system, Expander& expander);
  void measure_sizes(const TransitionSystem& system, Expander& expander);
  void measure_excess();
  void measure_arms(const Problem& problem);
  void measure_parts(Expander& expander, const Problem& problem);
  void lower_prices(Expander& expander, const Problem& problem, const detail::AssemblyGraph& graph);

  bool known_ = false;
  bool sizes_known_ = false;
  bool parts_known_ = false;
  double last_surplus_ = 0;
  std::size_t most_moved_ = 0;
  std::vector<double> own_;
  /// By part: whether it is in one unit with an earlier listed one; empty if there are no units.
  std::vector<unsigned char> merged_;
  std::vector<PartIndex> unit_;  ///< by part: the first part of its unit
  std::vector<double> by_size_;
  std::vector<std::vector<double>> by_excess_;            ///< from an excess of 1 on, by parts
  std::vector<std::vector<double>> last_by_excess_;       ///< from 0 on
  std::map<std::array<std::size_t, 2>, double> surplus_;  ///< S, by the smaller unit and the larger
  double surplus_without_cut_ = 0;
  double surplus_of_cut_ = 0;
  std::vector<std::vector<double>> by_arms_;  ///< from two arms on, by parts
  std::vector<double>
      gains_;  ///< of (moved, kept), moved <= kept, in the triangle row moved + kept
  std::vector<double> prices_;
  /// Exact values of connected sets of two and three parts, by their parts in ascending order;
  /// empty with simple prices.
  std::unordered_map<std::uint64_t, double> small_;
};

/// The bound from piece sizes, from what is moved, or for each piece the better of the two.
///
/// Admissible: yes. Sizes: each piece of n parts is cut n - 1 times, each cut of some size, and
/// cuts of sizes that the limit forbids are left out. Moved parts: see PieceGains::by_parts. Other
/// constraints only take choices away.
/// Consistent: yes, for every legal cut of S into A and B g(S) >= gain + g(A) + g(B), for each of
/// the two, and so for
///             the smaller of the two.
/// Where connections are kept, a piece ends as units of several parts: it has that many cuts fewer
/// (g(n, d)), and each unit but one ends as the last of what was moved, so it pays the price of any
/// one of its parts. What completing adds then depends on the piece that is cut last (g*). Infinite
/// where the objective sees more than the piece, in assembly, and beyond PieceGains::kMostParts.
/// Cost: O(parts^2) once, O(parts + connections) a state.
class PieceBound final : public Bound {
 public:
  enum class Kind { Sizes, Parts, Both };

  PieceBound(const TransitionSystem& system, Kind kind);
  ~PieceBound() override;

  [[nodiscard]] bool known() const override { return known_; }
  [[nodiscard]] double operator()(SetView open) override;
  void of_successors(SetView open, double here, std::span<const Action> actions,
                     std::span<double> bounds) override;
  /// Adds to each action's reward the change of the bound that it brings: what the plan loses at
  /// least by it, 0 for the actions that keep the bound within reach.
  void add_change(SetView open, std::span<Action> actions);

 private:
  struct Scratch;
  [[nodiscard]] double of_piece(std::span<const PartIndex> piece) const;
  [[nodiscard]] double of_last_piece(std::span<const PartIndex> piece) const;
  double measure_units(SetView open);
  void of_successors_with_units(SetView open, double here, std::span<const Action> actions,
                                std::span<double> bounds);

  PieceGains gains_;
  bool sizes_ = false;
  bool parts_ = false;
  bool known_ = false;
  std::vector<double> changes_;
  std::unique_ptr<Scratch> scratch_;
};

/// The bounds that a search may be told to use, and the strongest cheap one.
enum class BoundKind { None, Connections, Sizes, Parts, Best };
inline constexpr std::array<std::string_view, 5> kBoundNames = {"none", "connections", "sizes",
                                                                "parts", "best"};
/// @throws InputError that names the known ones.
[[nodiscard]] BoundKind bound_called(std::string_view name);
/// Best: for each piece the better of sizes and parts where the objective sees the piece only, else
/// connections. None: the paper's, the most that the last step can earn; known where no other step
/// earns more than 0, as the paper assumes. It may turn out to know nothing about the problem.
[[nodiscard]] std::unique_ptr<Bound> make_bound(const TransitionSystem& system, BoundKind kind);

}  // namespace orasp
