#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace orasp {

/// One line of the log that `orasp train --log` writes. Rewards are empty where none was known yet.
struct LearningPoint {
  double episodes = 0;
  std::optional<double> greedy;       ///< what the network earned then without random actions
  std::optional<double> best_greedy;  ///< the best of these so far
  std::optional<double> best;         ///< the best plan of any episode so far
  std::optional<double> bound;        ///< what no plan exceeds
};

/// Reads a training log: JSON objects, one a line; empty lines are skipped. Keys that are not
/// needed are passed over.
/// @throws InputError naming the line.
[[nodiscard]] std::vector<LearningPoint> parse_training_log(std::string_view text);

/// The rewards in what `orasp sample --json` prints (key "rewards"), or in a plain JSON array of
/// numbers.
/// @throws InputError naming the place.
[[nodiscard]] std::vector<double> parse_sample(std::string_view text);

}  // namespace orasp
