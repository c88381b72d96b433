#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "orasp/model/transition_system.h"

namespace orasp {

/// An upper bound on the reward that a plan can still earn from a state on.
///
/// Each bound is 0 at the goal. It is admissible: never below the best that a plan can still earn.
/// It is consistent: along a legal step it falls by at least what the step earns. The comment of
/// each class says why.
///
/// A bound holds scratch memory, so each thread makes one of its own.
class Bound {
 public:
  Bound() = default;
  Bound(const Bound&) = delete;
  Bound& operator=(const Bound&) = delete;
  virtual ~Bound() = default;

  /// Whether the bound says anything about this problem. Where it does not, it is infinite.
  [[nodiscard]] virtual bool known() const = 0;
  /// The bound of the state in which the connections `open` are still to be handled.
  [[nodiscard]] virtual double operator()(SetView open) = 0;
  /// Writes to `bounds` the bounds of the states that `actions` of the state `open` lead to. `here`
  /// is the bound of `open` itself.
  virtual void of_successors(SetView open, double here, std::span<const Action> actions,
                             std::span<double> bounds);

 private:
  std::vector<std::uint64_t> successor_;
};

}  // namespace orasp
