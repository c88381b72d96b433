#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace orasp::detail {

/// A 4-ary min-heap of items 0 .. n - 1 with decrease-key; ties go to the smaller item. Each item
/// enters at most once. Keys live outside (`keys[item]`), so the heap holds 8 bytes an item.
/// Reference. d-ary heaps: Johnson (1975), Inf. Proc. Letters 4(3), 53-57.
class IndexedHeap {
 public:
  IndexedHeap(std::size_t items, const std::vector<double>& keys)
      : keys_(keys), places_(items, kOutside) {}

  [[nodiscard]] bool empty() const { return heap_.empty(); }
  [[nodiscard]] std::uint32_t top() const { return heap_.front(); }
  /// Enters `item`, or moves it up after its key became smaller.
  void enter_or_decrease(std::uint32_t item) {
    if (places_[item] == kOutside) {
      places_[item] = static_cast<std::uint32_t>(heap_.size());
      heap_.push_back(item);
    }
    rise(places_[item]);
  }
  void pop() {
    const std::uint32_t last = heap_.back();
    heap_.pop_back();
    if (heap_.empty()) return;
    heap_.front() = last;
    places_[last] = 0;
    sink(0);
  }

 private:
  static constexpr std::uint32_t kOutside = std::numeric_limits<std::uint32_t>::max();

  [[nodiscard]] bool before(std::uint32_t a, std::uint32_t b) const {
    return keys_[a] < keys_[b] || (keys_[a] == keys_[b] && a < b);
  }
  void put(std::size_t place, std::uint32_t item) {
    heap_[place] = item;
    places_[item] = static_cast<std::uint32_t>(place);
  }
  void rise(std::size_t place) {
    const std::uint32_t item = heap_[place];
    while (place > 0) {
      const std::size_t above = (place - 1) / 4;
      if (!before(item, heap_[above])) break;
      put(place, heap_[above]);
      place = above;
    }
    put(place, item);
  }
  void sink(std::size_t place) {
    const std::uint32_t item = heap_[place];
    while (true) {
      const std::size_t first = place * 4 + 1;
      if (first >= heap_.size()) break;
      std::size_t least = first;
      for (std::size_t child = first + 1; child < first + 4 && child < heap_.size(); ++child) {
        if (before(heap_[child], heap_[least])) least = child;
      }
      if (!before(heap_[least], item)) break;
      put(place, heap_[least]);
      place = least;
    }
    put(place, item);
  }

  const std::vector<double>& keys_;
  std::vector<std::uint32_t> heap_;
  std::vector<std::uint32_t> places_;
};

}  // namespace orasp::detail
