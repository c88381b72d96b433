#include "orasp/planners/bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "orasp/model/detail/connectivity.h"

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

struct SizeBound::Scratch {
  explicit Scratch(const Problem& problem) : graph(problem), connectivity(graph, false) {}
  detail::AssemblyGraph graph;
  detail::Connectivity connectivity;
};

SizeBound::SizeBound(const TransitionSystem& system) {
  const Problem& problem = system.problem();
  const std::size_t parts = problem.num_parts();
  known_ = system.sees_sizes_only() && problem.direction() == Direction::Disassembly &&
           parts <= kMostParts;
  if (!known_) return;
  scratch_ = std::make_unique<Scratch>(problem);
  neutral_ = system.greatest_size_reward(0, 0, false);
  const std::size_t most_moved = problem.limits().max_moved_parts.value_or(parts);
  best_.assign(parts + 1, -std::numeric_limits<double>::infinity());
  if (parts >= 1) best_[1] = 0;
  for (std::size_t n = 2; n <= parts; ++n) {
    for (std::size_t a = 1; a <= std::min(n / 2, most_moved); ++a) {
      best_[n] = std::max(best_[n],
                          system.greatest_size_reward(a, n - a, false) + best_[a] + best_[n - a]);
    }
  }
  // A limit under which some size cannot be cut at all is left to the searches.
  known_ = std::ranges::all_of(std::span(best_).subspan(std::min<std::size_t>(1, best_.size())),
                               [](double best) { return std::isfinite(best); });
  // The last connection of all holds two single parts, or a part to itself.
  last_surplus_ = -std::numeric_limits<double>::infinity();
  if (!scratch_->graph.loops().empty()) {
    last_surplus_ = system.greatest_size_reward(0, 0, true) - neutral_;
  }
  if (parts >= 2) {
    last_surplus_ = std::max(last_surplus_, system.greatest_size_reward(1, 1, true) - best_[2]);
  }
}

SizeBound::~SizeBound() = default;

double SizeBound::operator()(SetView open) {
  if (!known_) return std::numeric_limits<double>::infinity();
  const std::size_t connections = count(open);
  if (connections == 0) return 0;
  std::size_t cuts = 0;
  double sum = 0;
  scratch_->graph.for_each_piece(open, [&](std::span<const PartIndex> piece) {
    sum += best_[piece.size()];
    cuts += piece.size() - 1;
  });
  return sum + static_cast<double>(connections - cuts) * neutral_ + last_surplus_;
}

void SizeBound::add_change(SetView open, std::span<Action> actions) {
  detail::Connectivity& connectivity = scratch_->connectivity;
  connectivity.analyse(open, false);
  for (Action& action : actions) {
    const std::uint32_t a = connectivity.below(action.connection);
    if (a == 0) {
      action.reward -= neutral_;
      continue;
    }
    const std::uint32_t n = connectivity.piece(action.connection);
    action.reward += best_[a] + best_[n - a] - best_[n];
  }
}

}  // namespace orasp
