#include "orasp/bounds/piece_tree.h"

namespace orasp {

std::uint32_t PieceTree::top(std::uint32_t node) {
  while (nodes_[node].top != node) node = nodes_[node].top = nodes_[nodes_[node].top].top;
  return node;
}

void PieceTree::build(CutTrees& trees, std::span<const PartIndex> piece) {
  nodes_.clear();
  cost_ = 0;
  const auto add = [&](double cost) {
    const auto number = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({.above = kNone, .top = number, .met_in = 0, .cost = cost});
    return number;
  };
  for (const PartIndex part : piece) {
    if (leaf_of_.size() <= part) {
      leaf_of_.resize(part + 1, kNone);
      around_.resize(part + 1);
    }
    leaf_of_[part] = add(0);
    around_[part].clear();
  }
  trees.for_each_of_parts(piece, [&](PartIndex part, PartIndex other, double cost) {
    cost_ += cost;
    around_[part].push_back({other, cost});
    around_[other].push_back({part, cost});
    const std::uint32_t joint = add(cost);
    for (const PartIndex end : {part, other}) {
      Node& below = nodes_[top(leaf_of_[end])];
      below.above = below.top = joint;
    }
  });
}

double PieceTree::saved(std::span<const PartIndex> parts) {
  double sum = 0;
  ++calls_;
  for (const PartIndex part : parts) {
    std::uint32_t node = leaf_of_[part];
    while (node != kNone && nodes_[node].met_in != calls_) {
      nodes_[node].met_in = calls_;
      node = nodes_[node].above;
    }
    if (node != kNone) sum += nodes_[node].cost;
  }
  return sum;
}

}  // namespace orasp
