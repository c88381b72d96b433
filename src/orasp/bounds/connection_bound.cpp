#include "orasp/bounds/connection_bound.h"

#include <algorithm>
#include <cmath>

#include "orasp/model/tolerance.h"

namespace orasp {

ConnectionBound::ConnectionBound(const TransitionSystem& system)
    : completes_first_(system.completes_first()), num_steps_(system.num_steps()) {
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
  std::size_t left = 0;
  for_each_connection(open, [&](ConnectionIndex c) {
    sum += greatest_[c];
    ++left;
  });
  if (left == 0) return 0;
  if (!known_) return kInfinity;
  return completes_later(left) ? sum + last_surplus_ : sum;
}

void ConnectionBound::of_successors(SetView open, double here, std::span<const Action> actions,
                                    std::span<double> bounds) {
  const std::size_t left = count(open);
  const bool last = left == 1;
  if (completes_first_ && completes_later(left)) here -= last_surplus_;
  for (std::size_t i = 0; i < actions.size(); ++i)
    bounds[i] = last ? 0 : here - greatest_[actions[i].connection];
}

}  // namespace orasp
