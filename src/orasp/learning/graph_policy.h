#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "orasp/learning/graph_observer.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// A graph network for products that it has not seen: any number of parts and connections.
///
/// Idea.       Each part has a vector of kHidden numbers, made of its features; two rounds of
///             messages change it: the means of its neighbours' vectors along connections and along
///             blocking. An action's worth is a small network of what the two parts of its
///             connection hold (sum and difference), the mean of all parts and the action's own
///             features, plus a linear function of the latter. Untrained it is `greedy`.
/// Reference.  Messages over a graph: Gilmer et al. (2017), ICML, 1263-1272.
/// Guarantee.  The same numbers on every machine: sums in one order, nothing fused.
struct GraphPolicy {
  static constexpr std::size_t kHidden = 32;
  static constexpr std::size_t kRounds = 2;

  /// All weights, shape [num_weights()].
  std::vector<float> weights;

  [[nodiscard]] static std::size_t num_weights();
  /// Random weights of an untrained network that chooses as `greedy` does.
  [[nodiscard]] static GraphPolicy untrained(std::uint64_t seed);
};

/// Asks a graph policy, and says how its answers change with its weights.
class GraphNetwork {
 public:
  /// The worth of each action, shape [actions]; valid until the next call. O(parts + connections +
  /// actions), times the number of weights.
  std::span<const float> worth(const GraphPolicy& policy, const GraphState& state);
  /// After worth() of the same state: adds to `gradient`, of the shape of the weights, the
  /// derivative of the sum over actions of worth times `slope` (backpropagation by hand).
  void backward(const GraphPolicy& policy, const GraphState& state, std::span<const float> slope,
                std::span<float> gradient);

 private:
  std::vector<std::vector<float>> parts_;    // after each round, [parts, kHidden]
  std::vector<std::vector<float>> near_;     // means along connections
  std::vector<std::vector<float>> blocked_;  // means along blocking
  std::vector<float> mean_;
  std::vector<float> head_in_;
  std::vector<float> head_;
  std::vector<float> worth_;
  std::vector<float> d_parts_;
  std::vector<float> d_next_;
  std::vector<float> d_in_;
};

/// Why a graph policy does not plan for this problem: a clause that goes on from the method's name.
[[nodiscard]] std::optional<std::string> graph_policy_obstacle(const TransitionSystem& system);

/// The plan that the policy makes: in every state the legal action that it values most; at a dead
/// end one step back. As follow_policy().
/// @throws Refusal: graph_policy_obstacle().
[[nodiscard]] Result follow_graph_policy(const TransitionSystem& system, const GraphPolicy& policy,
                                         const Budget& budget);

}  // namespace orasp
