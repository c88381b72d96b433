#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orasp/model/tolerance.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// One fully connected layer: out[o] = bias[o] + sum over i of in[i] * weights[i * outputs + o].
struct DenseLayer {
  std::size_t inputs = 0;
  std::size_t outputs = 0;
  /// The weights, of shape [inputs, outputs].
  std::vector<float> weights;
  /// One number for each output.
  std::vector<float> bias;
};

/// A network that values what a step leaves piece by piece: what holds of a piece of four parts
/// here holds of one there, so little must be learned of much.
///
/// Idea.      A step's number is the sum over the pieces of two or more parts that are there after
///            it of a function of the piece's features (how many parts, connections, leaves, what
///            mass, ...), plus a constant where work is left. So what a step changes is told by the
///            pieces that it changes alone. Where the step's own reward is to be learned, a second
///            function of the two sides is added where it separates. Both functions are the two
///            outputs of one fully connected network with max(0, x) between layers, plus a linear
///            function of the features.
/// Reference. Sums of a shared function over a set: Zaheer et al. (2017), NeurIPS, 3391-3401.
struct PiecePolicy {
  static constexpr std::size_t kFeatures = 20;
  static constexpr std::size_t kOutputs = 2;
  /// What a step adds beside the pieces: where work is left after it; where it is the last; where
  /// it separates.
  static constexpr std::size_t kStep = 3;

  /// Connections of the problem that it is for.
  std::size_t connections = 0;
  /// Units of the hidden layers.
  std::vector<std::size_t> hidden;
  /// Whether its numbers hold the step's own reward.
  bool of_rewards = false;
  /// Shape [num_weights(hidden)]: for each hidden layer and for the outputs a matrix of shape
  /// [inputs, outputs] and a bias, then the linear function, of shape [kFeatures, kOutputs], then
  /// kStep numbers.
  std::vector<float> weights;

  [[nodiscard]] static std::size_t num_weights(const std::vector<std::size_t>& hidden);
  friend bool operator==(const PiecePolicy&, const PiecePolicy&) = default;
};

/// What training leaves: a network that says for each open connection what handling it next is
/// worth, as plain weights.
///
/// In: the paper's indicator vector of the open connections, shape [connections]. Between layers:
/// max(0, x). Out: one number a connection, shape [connections]; an action's worth is
///
///     scale * out[c] + (adds_reward ? r(s, c) : 0)
///
/// up to a number that all actions of a state share.
///
/// Where there is more to states and steps (TransitionSystem::wide()), the network values states:
/// in are the columns of detail::ObservedColumns, out is one number, and an action is worth what it
/// earns and scale * out of the state that it leads to, 0 where that ends the plan.
struct Policy {
  /// None where the policy values pieces.
  std::vector<DenseLayer> layers;
  std::optional<PiecePolicy> pieces{};
  /// A positive number.
  double scale = 1;
  /// Whether the network was trained on what comes after a step, so that the reward of the step
  /// itself is added.
  bool adds_reward = false;
  /// Whether its layers value states, not actions.
  bool of_states = false;

  /// Whether it says nothing: training was stopped before the first network.
  [[nodiscard]] bool empty() const { return layers.empty() && !pieces; }
  /// The connections of the problem that it is for; where it values states, their columns.
  [[nodiscard]] std::size_t num_connections() const {
    return pieces ? pieces->connections : num_inputs();
  }
  [[nodiscard]] std::size_t num_inputs() const {
    return layers.empty() ? 0 : layers.front().inputs;
  }
  friend bool operator==(const Policy&, const Policy&) = default;
};
[[nodiscard]] bool operator==(const DenseLayer&, const DenseLayer&);

/// All that a later training needs to go on where one stopped, but for its replay buffer, which
/// fills again.
struct TrainingState {
  std::uint64_t episodes = 0;
  std::uint64_t steps = 0;
  std::uint64_t updates = 0;
  double seconds = 0;
  /// What one unit of the numbers of the network is in units of reward.
  double scale = 1;
  /// The mean of what random episodes still earned, by the number of open connections; of shape
  /// [connections + 1].
  std::vector<double> baseline;
  std::vector<std::size_t> hidden;
  bool known_reward = true;
  /// The state of the random numbers.
  std::uint64_t random = 0;
  /// The best plan of any episode.
  std::vector<ConnectionIndex> best;
  /// What Network::state() gave.
  std::vector<float> network;
};

/// The outcome of a training.
struct TrainedPolicy {
  /// The best policy that was met. It has no layers where training was stopped before the first.
  Policy policy;
  /// What the plan earns that it makes from the start; -infinity where none was found soon.
  double reward = -kInfinity;
  TrainingState training;
};

/// Asks a policy that values actions. Holds scratch memory: one for each thread. The same numbers
/// on every machine: each output is summed in one order, without fused operations.
class PolicyEvaluator {
 public:
  /// Of a policy that looks at open connections. The policy must outlive it.
  /// @throws InputError where the policy values pieces or states.
  explicit PolicyEvaluator(const Policy& policy);
  /// Of any policy, for a problem that it fits (policy_obstacle()). Both must outlive it.
  PolicyEvaluator(const Policy& policy, const TransitionSystem& system);
  // A policy that goes out of scope at once.
  explicit PolicyEvaluator(const Policy&&) = delete;
  PolicyEvaluator(const Policy&&, const TransitionSystem&) = delete;
  ~PolicyEvaluator();

  /// The outputs of the layers in a state, shape [connections]; valid until the next call. For a
  /// policy that looks at open connections. O(weights),
  /// less what the open connections and the units at 0 save: about a microsecond at two layers of
  /// 128 and 19 connections.
  [[nodiscard]] std::span<const float> outputs(SetView open);
  /// What each action is worth, in units of reward.
  void values(SetView open, std::span<const Action> actions, std::span<double> values);
  /// The place in `actions` of the one worth most; of several the first. `actions` must not be
  /// empty: leave out of it what is forbidden, and the policy answers for the rest.
  [[nodiscard]] std::size_t choose(SetView open, std::span<const Action> actions);

 private:
  struct Pieces;
  const Policy& policy_;
  std::unique_ptr<Pieces> pieces_;  ///< where the policy values pieces
  std::vector<float> in_;
  std::vector<float> out_;
  std::vector<double> values_;
};

/// Why dqn does not plan with this policy: it is for another number of connections, or for states
/// of another kind. A clause that goes on from the method's name; empty where it fits.
[[nodiscard]] std::optional<std::string> policy_obstacle(const TransitionSystem& system,
                                                         const Policy& policy);

/// The plan that a policy makes: in every state the legal action that it values most. From `from`
/// (else the start) until only `forbidden` is left, which is never handled.
///
/// Guarantee.  A plan if there is one (Feasible); Infeasible only after everything was tried: at a
///             dead end it goes back one step and takes the next best. Optimal where the plan earns
///             an upper bound (BoundKind::Best).
/// Cost.       One pass of the network for each state met; without dead ends one for each
///             connection.
/// @throws Refusal: policy_obstacle(). With `from`, where TransitionSystem::wide() as well.
[[nodiscard]] Result follow_policy(const TransitionSystem& system, const Policy& policy,
                                   const Budget& budget);
[[nodiscard]] Result follow_policy(const TransitionSystem& system, const Policy& policy,
                                   const ConnectionSet& from, const ConnectionSet& forbidden,
                                   const Budget& budget);

namespace detail {
/// follow_policy() where TransitionSystem::wide(), without a judgement by bounds.
[[nodiscard]] Result follow_states(const TransitionSystem& system, const Policy& policy,
                                   const Budget& budget);
}  // namespace detail

}  // namespace orasp
