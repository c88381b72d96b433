#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <tuple>

#include "orasp/learning/dqn.h"
#include "orasp/learning/network.h"
#include "orasp/model/random.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp::detail {

/// @throws InputError for a value that makes no sense.
void check_training(const DqnOptions& options);
/// Refuses at once a network that is sure to need more memory than there is. @throws InputError.
void require_network_fits(const DqnOptions& options, std::size_t inputs, std::size_t outputs,
                          const Budget& budget);

/// What all trainings by deep Q-learning share: rounds of episodes and gradient steps after each,
/// the policy that earns most kept, the log, the limits. What an episode is, what the network
/// values and what it learns from is said by those that derive from it.
class TrainingLoop {
 public:
  TrainingLoop(const TrainingLoop&) = delete;
  TrainingLoop& operator=(const TrainingLoop&) = delete;
  virtual ~TrainingLoop() = default;

  [[nodiscard]] Training run();

 protected:
  /// All must outlive it; `options` hold no 0 that stands for a default any more.
  TrainingLoop(const TransitionSystem& system, const DqnOptions& options, const Budget& budget,
               const TrainingHooks& hooks);

  [[nodiscard]] virtual std::unique_ptr<Network> new_network() = 0;
  /// Whether warm_up() was done, here or in the training that this one goes on with.
  [[nodiscard]] virtual bool warmed_up() const = 0;
  /// Plays random episodes: what the scale of the rewards is, and the first memories.
  virtual void warm_up() = 0;
  /// One round of episodes, from start to end, all remembered. The first acts greedily, and sets
  /// greedy_, unless all are random. Counts episodes, steps and steps_of_round_.
  virtual void play(bool all_random) = 0;
  /// The gradient steps that follow a round. Sets the loss of the record and counts updates.
  virtual void learn() = 0;
  /// The network as it is.
  [[nodiscard]] virtual Policy policy() const = 0;
  /// The plan that a policy makes, if it makes one within the budget.
  [[nodiscard]] virtual Result plan_of(const Policy& policy, const Budget& budget) const = 0;
  /// Remembers a plan that earns more than all before.
  virtual void keep_plan(const Result& plan) = 0;
  /// Writes the plan that was remembered, and what it earns; nothing where there is none.
  virtual void write_best(Result& result) const = 0;
  /// Steps that are remembered, their bytes, and states expanded.
  [[nodiscard]] virtual std::size_t remembered() const = 0;
  [[nodiscard]] virtual std::uint64_t bytes() const = 0;
  [[nodiscard]] virtual std::uint64_t expanded() const = 0;

  [[nodiscard]] bool stopped();
  [[nodiscard]] bool proved(double reward) const;
  [[nodiscard]] bool finished();
  /// The share of random actions now.
  [[nodiscard]] double epsilon() const;
  /// At how many open connections an episode begins to act by the network.
  [[nodiscard]] std::size_t begin_at() const;
  /// Whether a plan of this reward is the best so far, which is noted.
  bool best_so_far(double reward);
  /// Asks a policy for its plan, as it acts without libtorch, whose last digits differ; keeps it if
  /// it is the best so far.
  void judge(Policy now);

  const TransitionSystem& system_;
  const DqnOptions options_;
  const Budget& budget_;
  SplitMix64 random_;
  std::unique_ptr<Network> network_;
  Training training_;
  /// What the first episode of the round earned, which acts greedily.
  double greedy_ = -kInfinity;
  std::uint64_t steps_of_round_ = 0;

 private:
  void judge_round();
  void judge_at_the_end();
  void judge(Policy now, const Budget& budget);
  void tell();
  void pack();
  void finish();

  const TrainingHooks& hooks_;
  const Stopwatch watch_;
  Stop stop_ = Stop::None;
  /// The episodes, the updates and what the network earned of the last record.
  std::optional<std::tuple<std::uint64_t, std::uint64_t, double>> told_;
};

}  // namespace orasp::detail
