#pragma once

#include <memory>
#include <span>
#include <vector>

#include "orasp/model/transition_system.h"

namespace orasp {

/// Rewards of plans are sums of up to thousands of binary numbers; smaller differences are not
/// real.
inline constexpr double kRewardTolerance = 1e-10;

/// Upper bound on the reward still to come, for any objective: each open connection earns at most
/// its greatest reward (TransitionSystem::reward_range), and the last step at most `last_surplus`
/// more.
///
/// Admissible: yes, a plan handles each open connection once and each step earns at most its range
/// allows.
/// Consistent: yes, h(s) - h(s') = greatest(c) >= r(s, c) for a step that handles c and
/// does not complete.
/// Infinite where no range is known; then it proves nothing.
/// Cost: O(open connections); a search carries it along at one subtraction a step (greatest).
class ConnectionBound {
 public:
  explicit ConnectionBound(const TransitionSystem& system);

  /// The bound of a state; 0 at the goal.
  [[nodiscard]] double operator()(SetView open) const;
  /// Whether it says anything: false where an objective's rewards have no known range.
  [[nodiscard]] bool known() const { return known_; }
  /// Most that handling `connection` can earn when it is not the last step.
  [[nodiscard]] double greatest(ConnectionIndex connection) const { return greatest_[connection]; }
  /// Most that the last step can earn above greatest() of its connection.
  [[nodiscard]] double last_surplus() const { return last_surplus_; }

 private:
  bool known_ = true;
  double last_surplus_ = 0;
  std::vector<double> greatest_;
};

/// Upper bound on the reward still to come for objectives that see only sizes (TransitionSystem::sees_sizes_only), in
/// disassembly: the recursion over piece sizes alone. A piece of n parts can earn at most
///
///     g(n) = max over a + b = n of r(a, b) + g(a) + g(b),   g(1) = 0,   the smaller of a, b at most max_moved_parts,
///
/// and every connection beyond the n - 1 that separate earns what a step does that separates nothing. The last step of
/// all is paid as completing. Reference: reference.md, "Exact values"; the recursion is Bellman's over sizes.
///
/// Admissible: yes, each piece of n parts is cut exactly n - 1 times, each cut of some size, and cuts of sizes that the
///             limit forbids are left out. Other constraints only take choices away.
/// Consistent: yes, g(n) is at least r(a, b) + g(a) + g(b) for every legal cut.
/// Infinite where the objective sees more, in assembly, and beyond kMostParts.
/// Cost: O(parts^2) once, O(parts + connections) a state. Holds scratch memory: one for each thread.
class SizeBound {
 public:
  static constexpr std::size_t kMostParts = 4096;

  explicit SizeBound(const TransitionSystem& system);
  ~SizeBound();
  SizeBound(const SizeBound&) = delete;
  SizeBound& operator=(const SizeBound&) = delete;

  [[nodiscard]] bool known() const { return known_; }
  [[nodiscard]] double operator()(SetView open);
  /// Adds to each action's reward the change of the bound that it brings: what the plan loses at least by it, 0 for
  /// the actions that keep the bound within reach.
  void add_change(SetView open, std::span<Action> actions);

 private:
  struct Scratch;
  bool known_ = false;
  double neutral_ = 0;        ///< of a step that separates nothing
  double last_surplus_ = 0;   ///< most that completing adds to the last step
  std::vector<double> best_;  ///< g, by parts
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace orasp
