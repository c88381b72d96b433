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
  std::size_t most_epochs = 80;
  /// Epochs without a better answer on problems held out, after which it stops.
  std::size_t patience = 15;
  double learning_rate = 0.003;
};

/// One epoch.
struct ImitationRecord {
  std::size_t epoch = 0;
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
  /// of the untrained network.
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
/// them only smaller ones are asked about. The same for the same seed.
[[nodiscard]] std::vector<LabelledState> label_states(const TransitionSystem& system,
                                                      std::size_t states, std::uint64_t seed,
                                                      const Budget& budget);

/// Learns one policy from the proved values of many problems.
///
/// Idea.       Each state's answer is the set of all its optimal actions: the loss is -log of the
///             probability that the softmax of the worths gives to the set, plus what an action
///             drawn from it loses in the mean. Adam; a fifth of the problems (at least one of two
///             or more) is held out and says when to stop.
/// Reference.  Imitation of an oracle on states off its path: Ross, Gordon and Bagnell (2011),
///             AISTATS, 627-635. Adam: Kingma and Ba (2015), ICLR.
/// Guarantee.  The same policy for the same seed, problems and options, unless a limit stops it.
/// @throws Refusal: graph_policy_obstacle().
[[nodiscard]] Imitation imitate(std::span<const TransitionSystem* const> systems,
                                const ImitationOptions& options, const Budget& budget,
                                const std::function<void(const ImitationRecord&)>& log);

}  // namespace orasp
