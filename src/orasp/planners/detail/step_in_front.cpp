#include "orasp/planners/detail/step_in_front.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "orasp/model/tolerance.h"

namespace orasp::detail {

bool StepInFront::applies(const TransitionSystem& system, const PlacePrices& prices) {
  return prices.known() && prices.values().exact && system.takes_apart() && !system.ordered() &&
         !system.wide() && harmless_steps(system.problem()) != Harmless::None;
}

StepInFront::StepInFront(const TransitionSystem& system, std::shared_ptr<const PlacePrices> prices)
    : system_(system),
      prices_(std::move(prices)),
      kind_(harmless_steps(system.problem())),
      graph_(system.problem()),
      connectivity_(graph_, false),
      step_of_(system.num_connections(), 0) {
  const PlacePrices::Values& values = prices_->values();
  double greatest = 1;
  for (std::uint32_t i = 0; i < values.steps.size(); ++i) step_of_[values.steps[i]] = i;
  for (const double value : values.table) {
    if (std::isfinite(value)) greatest = std::max(greatest, std::abs(value));
  }
  tolerance_ = 1e-13 * greatest;
}

bool StepInFront::harmless(ConnectionIndex c) const {
  if (kind_ == Harmless::All) return true;
  const std::uint32_t below = connectivity_.below(c);
  if (below == 0) return false;
  return kind_ == Harmless::Cuts || below == 1 || connectivity_.piece(c) - below == 1;
}

std::optional<ConnectionIndex> StepInFront::find(SetView open, std::span<const Action> legal,
                                                 double room) {
  const PlacePrices::Values& values = prices_->values();
  const std::size_t size = values.steps.size();
  if (legal.size() < 2) return std::nullopt;
  if (kind_ != Harmless::All) {
    const ConnectionSet there = system_.present(open);
    connectivity_.analyse(there.view(), false);
  }
  candidates_.clear();
  for (const Action& action : legal) {
    if (harmless(action.connection)) candidates_.push_back(action.connection);
  }
  if (candidates_.empty()) return std::nullopt;
  open_steps_.clear();
  for_each_connection(open, [&](ConnectionIndex c) { open_steps_.push_back(step_of_[c]); });
  const std::size_t now = size - open_steps_.size();
  const auto earned = [&](std::uint32_t step, std::size_t place) {
    return values.table[step * size + place];
  };
  const auto possible = [&](std::uint32_t step, std::size_t place) {
    return values.slack[step * size + place] <= room + tolerance_;
  };
  // What all before place k + 1 lose at most that come one place later.
  double lost = 0;
  for (std::size_t k = now; k + 1 < size && !candidates_.empty(); ++k) {
    double most = -kInfinity;
    for (const std::uint32_t step : open_steps_) {
      if (!possible(step, k) || !std::isfinite(earned(step, k + 1))) continue;
      most = std::max(most, earned(step, k) - earned(step, k + 1));
    }
    // Where no step can be, there is no such plan.
    lost += most == -kInfinity ? 0 : most;
    std::erase_if(candidates_, [&](ConnectionIndex c) {
      const std::uint32_t step = step_of_[c];
      return possible(step, k + 1) && earned(step, now) - earned(step, k + 1) < lost - tolerance_;
    });
  }
  if (candidates_.empty()) return std::nullopt;
  return candidates_.front();
}

}  // namespace orasp::detail
