#pragma once

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

}  // namespace orasp
