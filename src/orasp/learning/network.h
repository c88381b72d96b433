#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orasp/learning/policy.h"
namespace orasp {

/// Shape and training of a value network.
struct NetworkOptions {
  /// The number of inputs, and of outputs where that is 0.
  std::size_t connections = 0;
  std::size_t outputs = 0;
  /// The number of units of each hidden layer.
  std::vector<std::size_t> hidden;
  double learning_rate = 1e-3;
  /// How much of the network the target network takes over at every step.
  double target_rate = 0.01;
  /// Each component of the gradient is cut to this size.
  double gradient_clip = 100;
  /// Whether the last layer begins at 0, so that an untrained network prefers nothing.
  bool zero_outputs = true;
  /// The seed of the initial weights.
  std::uint64_t seed = 1;
  /// "cpu", "cuda", or "auto": cuda where there is one.
  std::string device = "auto";
};

/// A network that is trained, and its slow copy, the target network. Rows of `states` are indicator
/// vectors of open connections, or of columns of states; all matrices are row-major.
///
/// Reference. The paper's network: fully connected, ReLU; smooth L1 loss; AdamW with amsgrad
/// (Loshchilov and Hutter 2019, ICLR; Reddi et al. 2018, ICLR), weight decay 0.01; target network
/// by averaging (Lillicrap et al. 2016, ICLR).
/// Repeatable. One thread; the same seed gives the same numbers on the same machine and libraries.
///
/// Lives in a module of its own, which is loaded when the first network is made: libtorch takes 0.6
/// s to load.
class Network {
 public:
  Network() = default;
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;
  virtual ~Network() = default;

  /// Shapes: states [batch, connections], values [batch, outputs].
  virtual void values(std::span<const float> states, std::span<float> values) = 0;
  virtual void target_values(std::span<const float> states, std::span<float> values) = 0;
  /// One gradient step towards values(states[i])[actions[i]] = targets[i], and one of the target
  /// network. Shapes: states [batch, connections], actions [batch], targets [batch].
  /// @returns the mean smooth L1 loss of the batch before the step.
  virtual double learn(std::span<const float> states, std::span<const std::int64_t> actions,
                       std::span<const float> targets) = 0;
  /// The network as plain weights.
  [[nodiscard]] virtual std::vector<DenseLayer> layers() const = 0;
  /// All that training needs to go on: both networks and the optimiser's moments.
  [[nodiscard]] virtual std::vector<float> state() const = 0;
  /// @throws InputError if it is not of this shape.
  virtual void restore(std::span<const float> state) = 0;
  /// The device that is used: "cpu" or "cuda".
  [[nodiscard]] virtual std::string device() const = 0;
  /// What slows training down on this machine, a sentence; empty if nothing does.
  [[nodiscard]] virtual std::string warning() const = 0;
};

/// Whether the module is there. It is looked for beside the program, in the folder above, in
/// ../lib/orasp and where this library was to be installed.
[[nodiscard]] bool network_available();
/// Why the method dqn cannot train here, a clause that goes on from its name; empty where it can.
[[nodiscard]] std::optional<std::string> network_obstacle();

/// @throws InputError if the module is missing or cannot be loaded, with how to get it; or for an
/// unknown or missing device.
[[nodiscard]] std::unique_ptr<Network> make_network(const NetworkOptions& options);

}  // namespace orasp
