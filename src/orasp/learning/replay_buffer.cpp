#include "orasp/learning/replay_buffer.h"

#include <algorithm>

namespace orasp {

ReplayBuffer::ReplayBuffer(std::size_t capacity, std::size_t connections)
    : ring_(capacity), connections_(connections), words_(words_for(connections)) {}

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
  std::vector<Step> steps = episode.steps_;
  const std::size_t length = steps.size();
  double rest = 0;
  for (std::size_t t = length; t-- > 0;) rest += steps[t].reward;
  for (std::size_t t = 0; t < length; ++t) {
    Step& step = steps[t];
    step.rest = rest;
    step.left = static_cast<std::uint32_t>(length - 1 - t);
    step.dead_end = dead_end;
    rest -= step.reward;
  }
  const auto copy_row = [](const auto& from, std::size_t row, auto& to, std::size_t place,
                           std::size_t width) {
    std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(row * width), width,
                to.begin() + static_cast<std::ptrdiff_t>(place * width));
  };
  ring_.add(steps, [&](std::size_t place, std::size_t t) {
    if (states_.size() < (place + 1) * words_) {
      states_.resize((place + 1) * words_);
      rewards_.resize((place + 1) * connections_);
    }
    copy_row(episode.states_, t, states_, place, words_);
    copy_row(episode.rewards_, t, rewards_, place, connections_);
  });
}

}  // namespace orasp
