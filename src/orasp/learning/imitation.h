#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "orasp/learning/graph_policy.h"
#include "orasp/task/budget.h"

namespace orasp {

/// A state with what each legal action loses: the most that can still be earned, less what the
/// action and the best steps after it earn. 0 for every optimal action.
struct LabelledState {
  /// Of an action of which it is not known whether it loses. At least one action is optimal.
  static constexpr float kUnsettled = -1;
  [[nodiscard]] bool settled(std::size_t action) const { return loss[action] >= 0; }

  GraphState state;
  /// In units of the greatest loss of a state of the problem; 1 where the action ends in a dead
  /// end. Shape [actions].
  std::vector<float> loss;
};

struct ImitationOptions {
  std::uint64_t seed = 0;
  /// States asked of the engine for each problem.
  std::size_t states = 24;
  /// And of those that the policy comes to by its own steps, once it has learned from the others.
  std::size_t own_states = 12;
  /// Epochs before it meets its own states, and after.
  std::size_t most_epochs = 80;
  /// Epochs without a better answer on problems held out, after which it stops.
  std::size_t patience = 15;
  double learning_rate = 0.003;
};

/// One epoch.
struct ImitationRecord {
  std::size_t epoch = 0;
  /// Whether it has met states of its own.
  bool own = false;
  std::size_t problems = 0;
  std::size_t held_out_problems = 0;
  std::size_t states = 0;
  std::size_t held_out_states = 0;
  double loss = 0;           ///< on the states learned from
  double held_out_loss = 0;  ///< on those of problems held out
  /// The share of held-out states in which the choice is an optimal action.
  double held_out_right = 0;
  double seconds = 0;
};

struct Imitation {
  /// The weights of the best epoch, by the loss on problems held out; before the first epoch those
  /// that it began with.
  GraphPolicy policy;
  ImitationRecord best;
  Stop stop = Stop::None;
};

/// What each legal action of one state loses, by the engine, in units of reward: infinite where it
/// ends in a dead end, LabelledState::kUnsettled where that is not known; where an action is known
/// by a bound to lose, at least the loss that the bound tells. None where the state is not settled
/// or has no plan.
[[nodiscard]] std::optional<std::vector<double>> action_losses(const TransitionSystem& system,
                                                               const ConnectionSet& open,
                                                               std::span<const Action> actions,
                                                               const Budget& budget);

/// States of a problem with what the engine proves of them: half of the walks' steps are optimal, a
/// quarter greedy, a quarter random, so that states on and off the best path are seen. An action is
/// optimal where a plan that begins with it earns the proved value: one that the engine finds, or a
/// known plan in which it comes first; it is known to lose where its bound or its proved value is
/// below. States that a fixed number of expansions does not settle are left out; after several of
/// them only smaller ones are asked about. The same for the same seed. With `own` nine steps of ten
/// are those of that policy, the others random.
[[nodiscard]] std::vector<LabelledState> label_states(const TransitionSystem& system,
                                                      std::size_t states, std::uint64_t seed,
                                                      const Budget& budget,
                                                      const GraphPolicy* own = nullptr);

/// Learns one policy from the proved values of many problems.
///
/// Idea.       Each state's answer is the set of all its optimal actions: the loss is -log of the
///             probability that the softmax of the worths gives to the set, plus what an action
///             drawn from it loses in the mean. Adam; what is judged and kept is an average of the
///             networks of some fifty steps. A fifth of the problems (at least one of two or more)
///             is held out and says when to stop. Then the policy plays, the engine says what was
///             right in the states that it came to, and it learns on from all.
/// Reference.  Imitation of an oracle on states of the learner's own: Ross, Gordon and Bagnell
///             (2011), AISTATS, 627-635. Adam: Kingma and Ba (2015), ICLR. Averages: Polyak and
///             Juditsky (1992), SIAM J. Control and Optimization 30(4), 838-855.
/// Guarantee.  The same policy for the same seed, problems, options and beginning, unless a limit
///             stops it.
/// @param resume  Weights to begin with, of an earlier training; null: those of `greedy`.
/// @throws Refusal: graph_policy_obstacle().
[[nodiscard]] Imitation imitate(std::span<const TransitionSystem* const> systems,
                                const ImitationOptions& options, const Budget& budget,
                                const std::function<void(const ImitationRecord&)>& log,
                                const GraphPolicy* resume = nullptr);

}  // namespace orasp
