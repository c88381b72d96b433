#include "orasp/bounds/part_units.h"

#include <algorithm>

#include "orasp/model/detail/connectivity.h"

namespace orasp {

PartUnits::PartUnits(const TransitionSystem& system) {
  if (system.kept().empty()) return;
  const std::size_t parts = system.problem().num_parts();
  merged_.assign(parts, 0);
  first_.assign(parts, 0);
  const detail::AssemblyGraph graph(system.problem());
  graph.for_each_piece(system.kept().view(), [&](std::span<const PartIndex> unit) {
    const PartIndex first = *std::ranges::min_element(unit);
    for (const PartIndex part : unit) {
      first_[part] = first;
      merged_[part] = part == first ? 0 : 1;
    }
  });
}

std::size_t PartUnits::excess(std::span<const PartIndex> piece) const {
  std::size_t sum = 0;
  if (any()) {
    for (const PartIndex part : piece) sum += merged_[part];
  }
  return sum;
}

std::size_t PartUnits::excess() const {
  return static_cast<std::size_t>(std::ranges::count(merged_, 1));
}

std::vector<std::size_t> PartUnits::sizes() const {
  std::vector<std::size_t> sizes(first_.size(), 0);
  for (const PartIndex first : first_) ++sizes[first];
  return sizes;
}

}  // namespace orasp
