#include "orasp/bounds/cut_trees.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "orasp/model/tolerance.h"

namespace orasp {

CutTrees::CutTrees(const TransitionSystem& system) {
  if (!system.gain_by_connection()) return;
  std::vector<double> costs = Expander(system).least_extra_costs();
  if (std::ranges::none_of(costs, [](double cost) { return cost > 0; })) return;
  const Problem& problem = system.problem();
  costs_ = std::move(costs);
  for_each_connection(system.kept().view(), [&](ConnectionIndex c) { costs_[c] = 0; });
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    ends_.push_back(problem.ends(c));
    if (ends_[c][0] != ends_[c][1]) order_.push_back(c);
  }
  std::ranges::stable_sort(order_, {}, [&](ConnectionIndex c) { return costs_[c]; });
  changes_.resize(costs_.size());
  above_.resize(problem.num_parts());
  inside_.assign(problem.num_parts(), 0);
  parent_.resize(problem.num_parts());
  to_parent_.resize(problem.num_parts());
  depth_.resize(problem.num_parts());
  around_.resize(problem.num_parts());
}

double CutTrees::of(SetView present) {
  double sum = 0;
  if (!any()) return sum;
  kruskal(
      above_.size(), [&](ConnectionIndex c) { return contains(present, c); },
      [&](ConnectionIndex c, bool in_tree) { sum += in_tree ? costs_[c] : 0; });
  return sum;
}

double CutTrees::of_parts(std::span<const PartIndex> parts) {
  double sum = 0;
  if (!any()) return sum;
  for_each_of_parts(parts, [&](PartIndex, PartIndex, double cost) { sum += cost; });
  return sum;
}

void CutTrees::measure_changes(SetView present) {
  std::ranges::fill(changes_, 0.0);
  if (!any()) return;
  for (std::vector<ConnectionIndex>& list : around_) list.clear();
  std::vector<ConnectionIndex> beside;
  kruskal(
      above_.size() + order_.size(), [&](ConnectionIndex c) { return contains(present, c); },
      [&](ConnectionIndex c, bool in_tree) {
        if (!in_tree) {
          beside.push_back(c);
          return;
        }
        changes_[c] = -costs_[c];  // until something is found that replaces it
        for (const PartIndex end : ends_[c]) around_[end].push_back(c);
      });
  // The tree hangs on roots; above_ then says from where on the way to the root is not settled.
  std::ranges::fill(depth_, kNone);
  for (PartIndex start = 0; start < above_.size(); ++start) {
    above_[start] = start;
    if (depth_[start] != kNone) continue;
    depth_[start] = 0;
    queue_.assign(1, start);
    for (std::size_t i = 0; i < queue_.size(); ++i) {
      const PartIndex part = queue_[i];
      for (const ConnectionIndex c : around_[part]) {
        const PartIndex other = ends_[c][0] == part ? ends_[c][1] : ends_[c][0];
        if (depth_[other] != kNone) continue;
        depth_[other] = depth_[part] + 1;
        parent_[other] = part;
        to_parent_[other] = c;
        queue_.push_back(other);
      }
    }
  }
  // The first that closes a cycle, least cost first, replaces each on it that none replaced yet.
  for (const ConnectionIndex c : beside) {
    PartIndex u = root(above_, ends_[c][0]);
    PartIndex v = root(above_, ends_[c][1]);
    while (u != v) {
      if (depth_[u] < depth_[v]) std::swap(u, v);
      changes_[to_parent_[u]] += costs_[c];
      above_[u] = parent_[u];
      u = root(above_, u);
    }
  }
}

}  // namespace orasp
