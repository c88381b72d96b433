#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "orasp/containers/episode_ring.h"
#include "orasp/model/random.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// What a learner remembers: the steps of past episodes, the oldest overwritten first.
///
/// Reference. Lin (1992), Machine Learning 8, 293-321; Mnih et al. (2015), Nature 518, 529-533.
/// Cost.      bytes_per_step(connections) each: the state, and the rewards of its legal actions,
///            which are its mask too.
class ReplayBuffer {
 public:
  /// One step of an episode that is over.
  struct Step {
    /// The connection that was handled.
    std::uint32_t connection = 0;
    /// How many connections were open before the step.
    std::uint32_t num_open = 0;
    /// How many steps its episode had after it.
    std::uint32_t left = 0;
    /// Whether it was taken at random, not because it was worth most.
    bool random = false;
    /// Whether the episode ended with connections left.
    bool dead_end = false;
    double reward = 0;
    /// What the episode earned from this step on.
    double rest = 0;
  };

  /// Room for `capacity` steps, at least 1.
  ReplayBuffer(std::size_t capacity, std::size_t connections);

  [[nodiscard]] static std::size_t bytes_per_step(std::size_t connections);
  [[nodiscard]] std::size_t capacity() const { return ring_.capacity(); }
  /// Steps held.
  [[nodiscard]] std::size_t size() const { return ring_.size(); }

  /// An episode while it is played, to be added when it is over.
  class Episode {
   public:
    explicit Episode(std::size_t connections) : connections_(connections) {}
    /// A step: its state, the state's legal actions, which of them was taken (its place among
    /// them), and whether at random.
    void push(SetView open, std::span<const Action> actions, std::size_t taken,
              bool random = false);
    void clear();

   private:
    friend class ReplayBuffer;
    std::size_t connections_;
    std::vector<Step> steps_;
    std::vector<std::uint64_t> states_;
    std::vector<float> rewards_;
  };

  /// Remembers an episode; of one longer than the buffer its end.
  void add(const Episode& episode, bool dead_end);

  /// Any step held, each as likely.
  [[nodiscard]] std::size_t sample(SplitMix64& random) const { return random.below(size()); }
  [[nodiscard]] const Step& step(std::size_t place) const { return ring_[place]; }
  [[nodiscard]] SetView open(std::size_t place) const {
    return SetView(states_).subspan(place * words_, words_);
  }
  /// Rewards of the legal actions of the step's state, shape [connections]; NaN where not legal.
  [[nodiscard]] std::span<const float> legal_rewards(std::size_t place) const {
    return std::span(rewards_).subspan(place * connections_, connections_);
  }
  /// The step `ahead` later in the same episode; `ahead` at most step(place).left.
  [[nodiscard]] std::size_t later(std::size_t place, std::size_t ahead) const {
    return ring_.later(place, ahead);
  }

 private:
  EpisodeRing<Step> ring_;
  std::size_t connections_;
  std::size_t words_;
  /// The states, of shape [capacity, words], and the rewards of their legal actions, of shape
  /// [capacity, connections].
  std::vector<std::uint64_t> states_;
  std::vector<float> rewards_;
};

}  // namespace orasp
