#include "orasp/learning/replay_buffer.h"

#include <algorithm>

namespace orasp {

ReplayBuffer::ReplayBuffer(std::size_t capacity, std::size_t connections)
    : capacity_(std::max<std::size_t>(capacity, 1)),
      connections_(connections),
      words_(words_for(connections)) {}

std::size_t ReplayBuffer::bytes_per_step(std::size_t connections) {
  return sizeof(Step) + words_for(connections) * sizeof(std::uint64_t) +
         connections * sizeof(float);
}

void ReplayBuffer::Episode::push(SetView open, std::span<const Action> actions, std::size_t taken,
                                 bool random) {
  Step step;
  step.connection = actions[taken].connection;
  step.num_open = static_cast<std::uint32_t>(count(open));
  step.reward = actions[taken].reward;
  step.random = random;
  steps_.push_back(step);
  states_.insert(states_.end(), open.begin(), open.end());
  const std::size_t begin = rewards_.size();
  rewards_.resize(begin + connections_, std::numeric_limits<float>::quiet_NaN());
  for (const Action& action : actions)
    rewards_[begin + action.connection] = static_cast<float>(action.reward);
}

void ReplayBuffer::Episode::clear() {
  steps_.clear();
  states_.clear();
  rewards_.clear();
}

void ReplayBuffer::add(const Episode& episode, bool dead_end) {
  const std::size_t length = episode.steps_.size();
  const std::size_t first = length > capacity_ ? length - capacity_ : 0;
  double rest = 0;
  for (std::size_t t = length; t-- > first;) rest += episode.steps_[t].reward;
  for (std::size_t t = first; t < length; ++t) {
    if (next_ == steps_.size()) {
      steps_.emplace_back();
      states_.resize(states_.size() + words_);
      rewards_.resize(rewards_.size() + connections_);
    }
    Step& step = steps_[next_];
    step = episode.steps_[t];
    step.rest = rest;
    step.left = static_cast<std::uint32_t>(length - 1 - t);
    step.dead_end = dead_end;
    rest -= step.reward;
    const auto copy_row = [](const auto& from, std::size_t row, auto& to, std::size_t place,
                             std::size_t width) {
      std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(row * width), width,
                  to.begin() + static_cast<std::ptrdiff_t>(place * width));
    };
    copy_row(episode.states_, t, states_, next_, words_);
    copy_row(episode.rewards_, t, rewards_, next_, connections_);
    next_ = (next_ + 1) % capacity_;
  }
}

}  // namespace orasp
