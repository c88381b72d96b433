#include "orasp/bounds/bound_kinds.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "orasp/bounds/connection_bound.h"
#include "orasp/bounds/piece_bound.h"
#include "orasp/model/tolerance.h"

namespace orasp {

namespace {

/// The bound of the paper, under which no step earns more than 0; here the step that completes may.
class ZeroBound final : public Bound {
 public:
  explicit ZeroBound(const TransitionSystem& system)
      : completes_first_(system.completes_first()), num_steps_(system.num_steps()) {
    const std::size_t connections = system.num_connections();
    for (ConnectionIndex c = 0; c < connections; ++c) {
      known_ = known_ && system.reward_range(c, connections, false).greatest <= 0;
      last_ = std::max(last_, system.reward_range(c, connections, true).greatest);
    }
    known_ = known_ && std::isfinite(last_);
  }
  [[nodiscard]] bool known() const override { return known_; }
  [[nodiscard]] double operator()(SetView open) override {
    if (!known_) return kInfinity;
    const std::size_t left = count(open);
    return left == 0 || (completes_first_ && left < num_steps_) ? 0 : last_;
  }
  void of_successors(SetView open, double here, std::span<const Action>,
                     std::span<double> bounds) override {
    std::ranges::fill(bounds, completes_first_ || count(open) == 1 ? 0 : here);
  }

 private:
  bool known_ = true;
  bool completes_first_;
  std::size_t num_steps_;
  double last_ = 0;
};

}  // namespace

BoundKind bound_called(std::string_view name) {
  std::string known;
  for (std::size_t i = 0; i < kBoundNames.size(); ++i) {
    if (kBoundNames[i] == name) return static_cast<BoundKind>(i);
    known += (known.empty() ? "" : ", ") + std::string(kBoundNames[i]);
  }
  throw InputError("unknown bound '" + std::string(name) + "'; known: " + known);
}

std::unique_ptr<Bound> make_bound(const TransitionSystem& system, BoundKind kind) {
  switch (kind) {
    case BoundKind::None: return std::make_unique<ZeroBound>(system);
    case BoundKind::Connections: return std::make_unique<ConnectionBound>(system);
    case BoundKind::Sizes: return std::make_unique<PieceBound>(system, PieceBound::Kind::Sizes);
    case BoundKind::Parts: return std::make_unique<PieceBound>(system, PieceBound::Kind::Parts);
    case BoundKind::Best: break;
  }
  auto pieces = std::make_unique<PieceBound>(system, PieceBound::Kind::Both);
  if (pieces->known()) return pieces;
  return std::make_unique<ConnectionBound>(system);
}

}  // namespace orasp
