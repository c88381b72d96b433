#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "orasp/learning/policy.h"
#include "orasp/model/tolerance.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

class ReplayBuffer;

/// What the network sees of a state.
enum class NetworkInputs {
  Auto,         ///< connections, and pieces from 128 connections on
  Connections,  ///< the paper's: which connections are open
  Pieces,       ///< the pieces that each step leaves (PiecePolicy)
};

/// How to train; docs/learning.md says what each part brings. The defaults in the first half are
/// the paper's.
struct DqnOptions {
  std::uint64_t seed = 1;
  /// 0: 5,000, and 20,000 from 128 connections on.
  std::uint64_t episodes = 0;
  NetworkInputs inputs = NetworkInputs::Auto;
  /// Units of each hidden layer; empty: two of max(128, connections), and of 32 over pieces.
  std::vector<std::size_t> hidden{};
  double learning_rate = 1e-3;
  /// Steps that a gradient step learns from; 0: three times the connections, and 64 over pieces.
  std::size_t batch = 0;
  /// Steps remembered; fewer where the memory limit asks for it.
  std::size_t replay = 100'000;
  double discount = 1;
  /// Share of random actions: at first, in the end, and the steps in which it falls by 1/e.
  double epsilon_start = 0.85;
  double epsilon_end = 0.05;
  double epsilon_decay = 1000;
  /// How much of the network the target network takes over at each gradient step.
  double target_rate = 0.01;
  double gradient_clip = 100;
  /// Share of the training in which episodes act at random until few connections are left, ever
  /// more of them. Less than 0: 0.5, and 0 over pieces, where every state teaches of all others.
  double curriculum = -1;
  /// auto, cpu, cuda.
  std::string device = "auto";

  // ---- Beyond the paper.

  /// Episodes side by side that explore; one more acts without random actions, to see what the
  /// network earns. 0: 7, and 31 from 128 connections on that are not over pieces.
  std::size_t environments = 0;
  /// Gradient steps for each step of all episodes.
  std::uint64_t updates_per_step = 1;
  /// The network picks the next action, the target network values it.
  bool double_q = true;
  /// Rewards that a target takes from its episode before it trusts the network; 0: all. Over
  /// pieces only up to the next random step, which says nothing of the best that could be done.
  std::size_t n_step = 5;
  /// A target is never below what its episode earned: in a deterministic world that can be had
  /// again.
  bool returns = true;
  /// Share of each batch that is drawn from the best episode.
  double imitation = 0.1;
  /// The network learns what comes after a step; the step's own reward is added.
  bool known_reward = true;
  /// Rewards are centred and scaled by what random episodes earn.
  bool scale = true;
  /// Training ends when the greedy plan earns the upper bound.
  bool stop_when_proved = true;
};

/// Whether a network over pieces is trained, for which no libtorch is needed.
[[nodiscard]] bool trains_over_pieces(const TransitionSystem& system, const DqnOptions& options);

/// What training tells after every round of episodes. Rewards are -infinity until there is one.
struct TrainingRecord {
  std::uint64_t episodes = 0;
  /// How many gradient steps were made.
  std::uint64_t updates = 0;
  double epsilon = 0;
  /// Mean smooth L1 loss since the last record, in units of the network's numbers.
  double loss = 0;
  /// What the network earns now without random actions; of the last record, at the end.
  double greedy = -kInfinity;
  /// The most that was: of the policy that is kept.
  double best_greedy = -kInfinity;
  /// The best plan of any episode.
  double best = -kInfinity;
  /// The upper bound: no plan earns more.
  std::optional<double> bound;
  /// The time since training began, earlier runs included.
  double seconds = 0;
};

struct Training {
  TrainedPolicy trained;
  /// The last record.
  TrainingRecord record;
  /// The best plan that was met.
  Result result;
  std::string device;
  /// What slows training down on this machine, a sentence; empty if nothing does.
  std::string warning;
};

/// What training calls; each may be empty.
struct TrainingHooks {
  /// Called after every round.
  std::function<void(const TrainingRecord&)> log;
  /// Called now and then, with all there is.
  std::function<void(const Training&)> save;
  /// The seconds between two calls of `save`.
  double save_every = 30;
};

/// The least and the most that a plan can still earn, by the number of open connections: shape
/// [connections + 1]. Empty where nothing is known.
struct RestLimits {
  std::vector<double> least;
  std::vector<double> greatest;
};
/// By the range of one step's reward. O(connections * parts * terms of the objective).
[[nodiscard]] RestLimits rest_limits(const TransitionSystem& system);

/// What train() learns the network towards, for steps of a replay buffer. A class of its own so
/// that it can be tested on numbers worked out by hand.
class TargetRule {
 public:
  TargetRule(const DqnOptions& options, double scale, std::vector<double> baseline,
             RestLimits limits = {});

  /// What the network's number for an action in a state with `open` connections stands for, in
  /// units of reward, and back: number * scale + baseline.
  [[nodiscard]] double value_of(double number, std::size_t open) const;
  [[nodiscard]] double number_of(double value, std::size_t open) const;
  /// The value of a state with connections left and no legal action: worse than anything seen.
  [[nodiscard]] double dead_end(std::size_t open) const;

  /// The step at which the network is asked for the rest of step `place`; none if the episode
  /// itself says it.
  [[nodiscard]] std::optional<std::size_t> asked(const ReplayBuffer& replay,
                                                 std::size_t place) const;
  /// The network's target for step `place`. `online` and `target`: both networks' numbers in the
  /// state of the step asked(), shape [connections]; not looked at where there is none.
  [[nodiscard]] float target(const ReplayBuffer& replay, std::size_t place,
                             std::span<const float> online, std::span<const float> target) const;

 private:
  [[nodiscard]] double baseline(std::size_t open) const;
  [[nodiscard]] double centre(std::size_t open) const;
  [[nodiscard]] std::size_t reach(const ReplayBuffer& replay, std::size_t place) const;

  DqnOptions options_;
  double scale_;
  std::vector<double> baseline_;
  RestLimits limits_;
};

/// Deep Q-learning.
///
/// Idea.       A network estimates Q(s, a), what handling a in s and the best steps after it earn.
///             Rounds of episodes, played side by side with some random actions, fill a replay
///             buffer; gradient steps move the network towards the rewards seen plus the value of
///             the state reached. Only legal actions are chosen, and only legal ones enter that
///             value: every constraint is kept by construction. Over pieces (PiecePolicy) the
///             number of an action is a sum over the pieces that it leaves; the linear part begins
///             at the least squares of the random episodes, an average of the networks of many
///             gradient steps acts and is the policy, and a target's own rewards end where its
///             episode took a random step. Where TransitionSystem::wide() the network values
///             states (detail/state_trainer.h).
/// Reference.  The paper, "Reinforcement learning methods"; Mnih et al. (2015), Nature 518,
///             529-533; double Q: van Hasselt, Guez and Silver (2016), AAAI, 2094-2100; several
///             steps: Sutton (1988), Machine Learning 3, 9-44; returns as lower bounds: He, Liu,
///             Schwing and Peng (2017), ICLR; curriculum: the paper; values of what a step leaves:
///             Sutton and Barto (2018), Reinforcement Learning, section 6.8; rewards up to the next
///             random step: Watkins (1989), Learning from Delayed Rewards, thesis, Cambridge.
/// Guarantee.  Every plan is legal. None of optimality from learning; Optimal where the plan earns
///             an upper bound (BoundKind::Best), Infeasible only by the search for a first plan.
/// Cost.       updates_per_step gradient steps for each step of a round, and a pass of the network
///             for each state met.
/// Repeatable. The same seed gives the same run on the same machine and libraries, time limits
/// aside.
///
/// @throws InputError if the module with the network is missing (network_available(); over pieces
/// none is needed), or for a value that makes no sense.
[[nodiscard]] Training train(const TransitionSystem& system, const DqnOptions& options,
                             const Budget& budget, const TrainingHooks& hooks = {},
                             const TrainedPolicy* resume = nullptr);

/// Trains and returns the best plan met.
[[nodiscard]] Result dqn(const TransitionSystem& system, const DqnOptions& options,
                         const Budget& budget);

}  // namespace orasp
