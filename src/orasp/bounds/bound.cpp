#include "orasp/bounds/bound.h"

namespace orasp {

void Bound::of_successors(SetView open, double, std::span<const Action> actions,
                          std::span<double> bounds) {
  successor_.assign(open.begin(), open.end());
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const ConnectionIndex c = actions[i].connection;
    const std::uint64_t bit = std::uint64_t{1} << (c % 64);
    successor_[c / 64] &= ~bit;
    bounds[i] = (*this)(successor_);
    successor_[c / 64] |= bit;
  }
}

}  // namespace orasp
