#include "orasp/bounds/cover_prices.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace orasp {

namespace {

constexpr std::uint32_t kUnreached = std::numeric_limits<std::uint32_t>::max();

/// Node v has the number v, its copy n + v, and an edge is two arcs from nodes to copies. Arcs come
/// in pairs: the second takes back what flows along the first.
class Flow {
 public:
  Flow(std::span<const double> cost, std::span<const std::array<PartIndex, 2>> edges)
      : nodes_(cost.size()), source_left_(cost.begin(), cost.end()), sink_left_(source_left_) {
    arcs_of_.resize(2 * nodes_);
    for (const auto& [first, second] : edges) {
      const bool both = std::isinf(cost[first]) && std::isinf(cost[second]);
      add(first, nodes_ + second, first == second || both);
      add(second, nodes_ + first, first == second || both);
    }
    // What is less than this is rounding.
    double most = 0;
    for (const double each : cost) {
      if (std::isfinite(each)) most = std::max(most, each);
    }
    least_ = most * 1e-12;
  }

  void maximise() {
    while (layers()) {
      next_.assign(2 * nodes_, 0);
      for (std::uint32_t node = 0; node < nodes_; ++node) {
        while (source_left_[node] > least_ && push_from(node)) {
        }
      }
    }
  }

  /// What flows along both arcs of an edge.
  [[nodiscard]] double through(std::size_t edge) const {
    return flow_[4 * edge] + flow_[4 * edge + 2];
  }

 private:
  void add(std::size_t from, std::size_t to, bool closed) {
    const auto arc = static_cast<std::uint32_t>(head_.size());
    head_.push_back(static_cast<std::uint32_t>(to));
    head_.push_back(static_cast<std::uint32_t>(from));
    flow_.insert(flow_.end(), {0.0, 0.0});
    if (closed) return;
    arcs_of_[from].push_back(arc);
    arcs_of_[to].push_back(arc + 1);
  }
  /// An arc takes any amount; the one that takes back, what flows along it.
  [[nodiscard]] double room(std::uint32_t arc) const {
    return arc % 2 == 0 ? std::numeric_limits<double>::infinity() : flow_[arc - 1];
  }

  /// Numbers the layers, and returns whether one has a copy that takes more.
  bool layers() {
    layer_.assign(2 * nodes_, kUnreached);
    queue_.clear();
    for (std::uint32_t node = 0; node < nodes_; ++node) {
      if (source_left_[node] <= least_) continue;
      layer_[node] = 0;
      queue_.push_back(node);
    }
    bool reached = false;
    for (std::size_t i = 0; i < queue_.size(); ++i) {
      const std::uint32_t at = queue_[i];
      if (at >= nodes_ && sink_left_[at - nodes_] > least_) reached = true;
      for (const std::uint32_t arc : arcs_of_[at]) {
        if (room(arc) <= least_ || layer_[head_[arc]] != kUnreached) continue;
        layer_[head_[arc]] = layer_[at] + 1;
        queue_.push_back(head_[arc]);
      }
    }
    return reached;
  }

  /// Sends something along one path of growing layers, if there is one.
  bool push_from(std::uint32_t node) {
    path_.clear();
    std::uint32_t at = node;
    for (;;) {
      if (at >= nodes_ && sink_left_[at - nodes_] > least_) break;
      if (next_[at] < arcs_of_[at].size()) {
        const std::uint32_t arc = arcs_of_[at][next_[at]];
        if (room(arc) > least_ && layer_[head_[arc]] == layer_[at] + 1) {
          path_.push_back(arc);
          at = head_[arc];
        } else {
          ++next_[at];
        }
        continue;
      }
      if (path_.empty()) return false;
      at = head_[path_.back() ^ 1U];
      path_.pop_back();
      ++next_[at];
    }
    double amount = std::min(source_left_[node], sink_left_[at - nodes_]);
    for (const std::uint32_t arc : path_) amount = std::min(amount, room(arc));
    for (const std::uint32_t arc : path_) {
      if (arc % 2 == 0)
        flow_[arc] += amount;
      else
        flow_[arc - 1] = std::max(0.0, flow_[arc - 1] - amount);
    }
    source_left_[node] -= amount;
    sink_left_[at - nodes_] -= amount;
    return true;
  }

  std::size_t nodes_;
  std::vector<double> source_left_;  ///< by node, what may still flow into it
  std::vector<double> sink_left_;    ///< by node, what may still flow out of its copy
  std::vector<std::vector<std::uint32_t>> arcs_of_;
  std::vector<std::uint32_t> head_;
  std::vector<double> flow_;  ///< at even places
  std::vector<std::uint32_t> layer_;
  std::vector<std::uint32_t> queue_;
  std::vector<std::size_t> next_;
  std::vector<std::uint32_t> path_;
  double least_ = 0;
};

}  // namespace

std::vector<double> cover_prices(std::span<const double> cost,
                                 std::span<const std::array<PartIndex, 2>> edges) {
  Flow flow(cost, edges);
  flow.maximise();
  std::vector<double> prices(edges.size());
  for (std::size_t edge = 0; edge < edges.size(); ++edge) prices[edge] = flow.through(edge) / 2;
  // Rounding must not overcharge.
  std::vector<double> charged(cost.size(), 0.0);
  for (std::size_t edge = 0; edge < edges.size(); ++edge) {
    for (const PartIndex end : edges[edge]) charged[end] += prices[edge];
  }
  double share = 1;
  for (std::size_t node = 0; node < cost.size(); ++node) {
    if (charged[node] > cost[node]) share = std::min(share, cost[node] / charged[node]);
  }
  for (double& price : prices) price *= share;
  return prices;
}

}  // namespace orasp
