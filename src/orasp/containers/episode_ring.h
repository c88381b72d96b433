#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace orasp {

/// The steps of past episodes, the oldest overwritten first. What a step is, is the user's; more
/// that belongs to a step stands in arrays of the user's by the same places.
template <class Step>
class EpisodeRing {
 public:
  /// Room for `capacity` steps, at least 1.
  explicit EpisodeRing(std::size_t capacity) : capacity_(std::max<std::size_t>(capacity, 1)) {}

  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  /// Steps held.
  [[nodiscard]] std::size_t size() const { return steps_.size(); }
  [[nodiscard]] const Step& operator[](std::size_t place) const { return steps_[place]; }
  /// The step `ahead` later in the same episode.
  [[nodiscard]] std::size_t later(std::size_t place, std::size_t ahead) const {
    return (place + ahead) % capacity_;
  }

  /// Remembers an episode; of one longer than the ring its end. Calls placed(place, t) for each
  /// step t of it that is held now. A place that was not there before is size() - 1.
  template <class Placed>
  void add(std::span<const Step> episode, Placed&& placed) {
    const std::size_t first = episode.size() > capacity_ ? episode.size() - capacity_ : 0;
    for (std::size_t t = first; t < episode.size(); ++t) {
      if (next_ == steps_.size()) steps_.emplace_back();
      steps_[next_] = episode[t];
      placed(next_, t);
      next_ = (next_ + 1) % capacity_;
    }
  }
  void add(std::span<const Step> episode) {
    add(episode, [](std::size_t, std::size_t) {});
  }
  void clear() {
    steps_.clear();
    next_ = 0;
  }

 private:
  std::size_t capacity_;
  /// Where the next step goes.
  std::size_t next_ = 0;
  std::vector<Step> steps_;
};

}  // namespace orasp
