#include "orasp/planners/detail/spanning_forest.h"

#include <numeric>
#include <utility>

#include "orasp/model/random.h"

namespace orasp::detail {

SpanningForest random_spanning_forest(const AssemblyGraph& graph, std::uint64_t seed) {
  const std::size_t parts = graph.num_parts();
  SpanningForest forest{std::vector<std::uint32_t>(parts, SpanningForest::kNoPart), {}};
  SplitMix64 random(seed);
  std::vector<PartIndex> roots(parts);
  std::iota(roots.begin(), roots.end(), PartIndex{0});
  std::vector<unsigned char> seen(parts, 0);
  struct Frame {
    PartIndex part;
    std::vector<PartIndex> next;
  };
  std::vector<Frame> path;
  const auto shuffle = [&](std::vector<PartIndex>& list) {
    for (std::size_t i = list.size(); i > 1; --i)
      std::swap(list[i - 1], list[static_cast<std::size_t>(random.below(i))]);
  };
  const auto enter = [&](PartIndex part) {
    seen[part] = 1;
    forest.order.push_back(part);
    Frame& frame = path.emplace_back(Frame{part, {}});
    for (const auto& half : graph.around(part)) frame.next.push_back(half.other);
    shuffle(frame.next);
  };
  shuffle(roots);
  for (const PartIndex root : roots) {
    if (seen[root] != 0) continue;
    enter(root);
    while (!path.empty()) {
      if (path.back().next.empty()) {
        path.pop_back();
        continue;
      }
      const PartIndex from = path.back().part;
      const PartIndex to = path.back().next.back();
      path.back().next.pop_back();
      if (seen[to] != 0) continue;
      forest.parent[to] = from;
      enter(to);
    }
  }
  return forest;
}

}  // namespace orasp::detail
