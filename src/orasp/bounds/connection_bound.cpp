#include "orasp/bounds/connection_bound.h"

#include <algorithm>
#include <cmath>

#include "orasp/model/tolerance.h"

namespace orasp {

ConnectionBound::ConnectionBound(const TransitionSystem& system) {
  const std::size_t connections = system.num_connections();
  last_surplus_ = connections == 0 ? 0 : -kInfinity;
  for (ConnectionIndex c = 0; c < connections; ++c) {
    greatest_.push_back(system.reward_range(c, connections, false).greatest);
    const double last = system.reward_range(c, connections, true).greatest;
    known_ = known_ && std::isfinite(greatest_.back()) && std::isfinite(last);
    last_surplus_ = std::max(last_surplus_, last - greatest_.back());
  }
}

double ConnectionBound::operator()(SetView open) {
  double sum = 0;
  bool goal = true;
  for_each_connection(open, [&](ConnectionIndex c) {
    sum += greatest_[c];
    goal = false;
  });
  if (goal) return 0;
  return known_ ? sum + last_surplus_ : kInfinity;
}

void ConnectionBound::of_successors(SetView open, double here, std::span<const Action> actions,
                                    std::span<double> bounds) {
  const bool last = count(open) == 1;
  for (std::size_t i = 0; i < actions.size(); ++i)
    bounds[i] = last ? 0 : here - greatest_[actions[i].connection];
}

}  // namespace orasp
