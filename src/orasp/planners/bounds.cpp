#include "orasp/planners/bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace orasp {

ConnectionBound::ConnectionBound(const TransitionSystem& system) {
  const std::size_t connections = system.num_connections();
  last_surplus_ = connections == 0 ? 0 : -std::numeric_limits<double>::infinity();
  for (ConnectionIndex c = 0; c < connections; ++c) {
    greatest_.push_back(system.reward_range(c, connections, false).greatest);
    const double last = system.reward_range(c, connections, true).greatest;
    known_ = known_ && std::isfinite(greatest_.back()) && std::isfinite(last);
    last_surplus_ = std::max(last_surplus_, last - greatest_.back());
  }
}

double ConnectionBound::operator()(SetView open) const {
  double sum = 0;
  bool goal = true;
  for_each_connection(open, [&](ConnectionIndex c) {
    sum += greatest_[c];
    goal = false;
  });
  if (goal) return 0;
  return known_ ? sum + last_surplus_ : std::numeric_limits<double>::infinity();
}

}  // namespace orasp
