#pragma once

#include <span>
#include <vector>

#include "orasp/bounds/bound.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// A bound for any objective: each open connection earns at most its greatest reward
/// (TransitionSystem::reward_range), and the step that completes at most `last_surplus` more. That
/// is the last step, or, backwards, the first.
///
/// Admissible. A plan handles each open connection once, and each step earns at most what its range
///             allows.
/// Consistent. h(s) - h(s') = greatest(c) >= r(s, c) for a step from s to s' that handles c and
///             does not complete.
/// Limit.      The bound is infinite where the range of some connection is not known.
/// Cost.       O(open connections) a state; a search that carries the bound along pays one
///             subtraction a step.
class ConnectionBound final : public Bound {
 public:
  explicit ConnectionBound(const TransitionSystem& system);

  [[nodiscard]] bool known() const override { return known_; }
  [[nodiscard]] double operator()(SetView open) override;
  void of_successors(SetView open, double here, std::span<const Action> actions,
                     std::span<double> bounds) override;
  /// The most that handling `connection` can earn when it is not the last step.
  [[nodiscard]] double greatest(ConnectionIndex connection) const { return greatest_[connection]; }
  /// The most that the last step can earn above greatest() of its connection.
  [[nodiscard]] double last_surplus() const { return last_surplus_; }

 private:
  /// Whether completing is still to come in a state with so many open connections.
  [[nodiscard]] bool completes_later(std::size_t open) const {
    return !completes_first_ || open == num_steps_;
  }

  bool known_ = true;
  bool completes_first_ = false;
  std::size_t num_steps_ = 0;
  double last_surplus_ = 0;
  std::vector<double> greatest_;
};

}  // namespace orasp
