#include "orasp/geometry/detail/line_intervals.h"

#include <algorithm>

namespace orasp::detail {

void Crossings::intervals(std::size_t slot, std::vector<Interval>& found) {
  found.clear();
  const auto first = crossings_.begin() + begin_[slot];
  const auto last = crossings_.begin() + begin_[slot + 1];
  std::sort(first, last, [](const Crossing& a, const Crossing& b) {
    return a.height != b.height ? a.height < b.height : !a.leaves && b.leaves;
  });
  int inside = 0;
  double entered = 0;
  for (auto at = first; at != last; ++at) {
    if (!at->leaves) {
      if (inside++ == 0) entered = at->height;
    } else if (inside > 0 && --inside == 0 && at->height > entered) {
      if (!found.empty() && found.back().high >= entered) {
        found.back().high = at->height;
      } else {
        found.push_back({entered, at->height});
      }
    }
  }
}

Remains remains(std::span<const Interval> from, std::span<const Interval> what, double sliver) {
  Remains result;
  const auto keep = [&](double low, double high, bool cut) {
    if (high - low <= (cut ? sliver : 0.0)) return;
    result.first = std::min(result.first, low);
    result.last = std::max(result.last, high);
  };
  std::size_t next = 0;
  for (const Interval& piece : from) {
    while (next < what.size() && what[next].high <= piece.low) ++next;
    double low = piece.low;
    bool cut = false;
    for (std::size_t i = next; i < what.size() && what[i].low < piece.high; ++i) {
      if (what[i].low > low) keep(low, what[i].low, true);
      low = std::max(low, what[i].high);
      cut = true;
    }
    if (low < piece.high) keep(low, piece.high, cut);
  }
  return result;
}

double shared_length(std::span<const Interval> a, std::span<const Interval> b) {
  double sum = 0;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    sum += std::max(0.0, std::min(a[i].high, b[j].high) - std::max(a[i].low, b[j].low));
    a[i].high < b[j].high ? ++i : ++j;
  }
  return sum;
}

}  // namespace orasp::detail
