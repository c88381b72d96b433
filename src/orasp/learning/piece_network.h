#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "orasp/learning/detail/adam.h"
#include "orasp/learning/network.h"
#include "orasp/learning/policy.h"
#include "orasp/model/detail/connectivity.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// What a piece network sees of many steps. Pieces that look the same are one row, so that each is
/// worked out once.
class PieceSteps {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffU;
  /// One step: what its state holds, and what becomes of it.
  struct Step {
    std::uint32_t state = 0;                               ///< in the order of describe()
    std::array<std::uint32_t, 2> before = {kNone, kNone};  ///< rows of pieces that are gone
    std::array<std::uint32_t, 2> after = {kNone, kNone};  ///< rows of pieces that are there instead
    /// Rows of A and B, single parts included; none where the step separates nothing.
    std::array<std::uint32_t, 2> sides = {kNone, kNone};
    /// Whether it is the last step of all, after which nothing is left to be valued.
    bool last = false;
  };

  /// What tells pieces apart that do not look the same.
  using Key = std::array<std::uint64_t, 4>;

  void clear();
  /// The row of a piece, and whether it is new: then its features are to be added to `rows`.
  std::pair<std::uint32_t, bool> row(const Key& key);

  /// Features, shape [rows, PiecePolicy::kFeatures].
  std::vector<float> rows;
  std::vector<Step> steps;
  /// The rows of the pieces of state i: `pieces` from begin[i] to begin[i + 1].
  std::vector<std::uint32_t> begin = {0};
  std::vector<std::uint32_t> pieces;

  [[nodiscard]] std::size_t num_rows() const { return keys_.size(); }

 private:
  [[nodiscard]] std::size_t slot_of(const Key& key) const;
  std::vector<Key> keys_;             ///< by row
  std::vector<std::uint32_t> slots_;  ///< hash table of rows; kNone where free
};

/// Describes steps of one problem to a piece network. Holds scratch memory: one for each thread.
class PieceObserver {
 public:
  /// The system must outlive it; it must not be wide().
  explicit PieceObserver(const TransitionSystem& system);
  explicit PieceObserver(const TransitionSystem&&) = delete;

  /// Adds the steps that handle these open connections in this state. O(parts + connections).
  void describe(SetView open, std::span<const ConnectionIndex> connections, PieceSteps& steps);

 private:
  /// What is counted of a piece; a sum over its parts.
  struct Sums {
    double parts = 0;
    double degree = 0;   ///< of parts, within the piece
    double squares = 0;  ///< of degrees
    double leaves = 0;   ///< parts of degree 1
    double mass = 0;
    double base = 0;  ///< parts of the base
    void add(const Sums& other, double times = 1);
  };
  [[nodiscard]] Sums of(const detail::Side& side) const;
  /// The part's degree changes by `by`.
  void change_degree(Sums& sums, PartIndex part, double by) const;
  /// The row of a piece.
  [[nodiscard]] std::uint32_t row_of(const Sums& sums, PieceSteps& steps) const;
  [[nodiscard]] std::array<float, PiecePolicy::kFeatures> features(const Sums& sums) const;

  const TransitionSystem& system_;
  detail::Connectivity connectivity_;
  double total_mass_ = 0;
  std::vector<std::uint32_t> degrees_;
  std::vector<Sums> before_;  ///< sums over the parts that were walked earlier
};

/// Asks a piece policy. Holds scratch memory: one for each thread. The same numbers on every
/// machine: each sum is in one order, nothing is fused.
class PieceEvaluator {
 public:
  /// The number of each step: what handling its connection is worth in the units of the network.
  /// Shape [steps]; valid until the next call.
  std::span<const float> numbers(const PiecePolicy& policy, const PieceSteps& steps);
  /// After numbers() of the same steps: adds to `gradient`, of the shape of the weights, the
  /// derivative of the sum over steps of number times `slope` (backpropagation by hand).
  void backward(const PiecePolicy& policy, const PieceSteps& steps, std::span<const float> slope,
                std::span<float> gradient);

 private:
  /// After each layer, [rows, units].
  std::vector<std::vector<float>> layers_;
  std::vector<float> of_states_;
  std::vector<float> numbers_;
  std::vector<float> d_out_;
  std::vector<float> d_next_;
};

class ReplayBuffer;

/// A piece network that is trained, with its slow copy. Needs no libtorch.
class PieceNetwork final : public Network {
 public:
  /// `knows_rewards`: the reward of the step itself is not part of the network's numbers.
  PieceNetwork(const TransitionSystem& system, const NetworkOptions& options, bool knows_rewards);

  /// Sets the part of the network that is linear to the least squares of what is remembered: of
  /// what episodes earned after each step in units of `scale`, and, unless rewards are known, of
  /// what the step earned.
  void fit(const ReplayBuffer& replay, double scale);
  /// The policy that acts: the slow copy, an average of the networks of many gradient steps.
  [[nodiscard]] const PiecePolicy& policy() const { return target_; }

  void values(std::span<const float> states, std::span<float> values) override;
  void target_values(std::span<const float> states, std::span<float> values) override;
  double learn(std::span<const float> states, std::span<const std::int64_t> actions,
               std::span<const float> targets) override;
  [[nodiscard]] std::vector<DenseLayer> layers() const override { return {}; }
  [[nodiscard]] std::vector<float> state() const override;
  void restore(std::span<const float> state) override;
  [[nodiscard]] std::string device() const override { return "cpu"; }
  [[nodiscard]] std::string warning() const override { return {}; }

 private:
  void ask(const PiecePolicy& policy, std::span<const float> states, std::span<float> values);
  /// The open connections of a row of `states`, as a set and as a list.
  void read(std::span<const float> row);

  NetworkOptions options_;
  PieceObserver observer_;
  PieceEvaluator evaluator_;
  PiecePolicy online_;
  PiecePolicy target_;
  detail::Adam adam_;
  PieceSteps steps_;
  /// The states that were asked about last, and their steps.
  std::vector<float> asked_;
  PieceSteps asked_steps_;
  std::vector<std::uint64_t> open_;
  std::vector<ConnectionIndex> connections_;
  std::vector<float> slope_;
  std::vector<float> gradient_;
};

}  // namespace orasp
