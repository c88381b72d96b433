#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace orasp::detail {

/// Stochastic gradient descent with moments of the gradient, and weights that decay.
///
/// Reference. Kingma and Ba (2015), ICLR; decay apart from the gradient: Loshchilov and Hutter
///            (2019), ICLR.
class Adam {
 public:
  explicit Adam(std::size_t size) : first_(size), second_(size) {}

  void step(std::span<const float> gradient, double rate, std::span<float> weights) {
    constexpr double kFirst = 0.9;
    constexpr double kSecond = 0.999;
    constexpr double kDecay = 0.01;
    first_power_ = static_cast<float>(first_power_ * kFirst);
    second_power_ = static_cast<float>(second_power_ * kSecond);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const double g = gradient[i];
      first_[i] = static_cast<float>(kFirst * first_[i] + (1 - kFirst) * g);
      second_[i] = static_cast<float>(kSecond * second_[i] + (1 - kSecond) * g * g);
      const double first = first_[i] / (1 - double{first_power_});
      const double second = second_[i] / (1 - double{second_power_});
      const double move = first / (std::sqrt(second) + 1e-8);
      weights[i] -= static_cast<float>(rate * (move + kDecay * weights[i]));
    }
  }

  /// All that it needs to go on, as numbers of shape [2 * size + 2].
  [[nodiscard]] std::vector<float> state() const {
    std::vector<float> all = first_;
    all.insert(all.end(), second_.begin(), second_.end());
    all.push_back(first_power_);
    all.push_back(second_power_);
    return all;
  }
  void restore(std::span<const float> state) {
    const std::size_t size = first_.size();
    first_.assign(state.begin(), state.begin() + static_cast<std::ptrdiff_t>(size));
    second_.assign(state.begin() + static_cast<std::ptrdiff_t>(size),
                   state.begin() + static_cast<std::ptrdiff_t>(2 * size));
    first_power_ = state[2 * size];
    second_power_ = state[2 * size + 1];
  }

 private:
  float first_power_ = 1;
  float second_power_ = 1;
  std::vector<float> first_;
  std::vector<float> second_;
};

}  // namespace orasp::detail
