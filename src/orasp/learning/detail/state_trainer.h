#pragma once

#include "orasp/learning/dqn.h"

namespace orasp::detail {

/// Deep Q-learning where there is more to states and steps than open connections of which one is
/// handled (TransitionSystem::wide()): goals, costs between steps, steps that take parts.
///
/// Idea.      A network values states: V(s), what the best steps still earn from s on, of what
///            ObservedColumns shows. A step is worth what it earns and V of the state that it leads
///            to, so that steps need no numbers: one may take any set of parts, leave in any
///            direction, or end the plan. The rest is as in train(): rounds of episodes with some
///            random actions, a replay buffer, a target network. A state's target is the most of
///            reward and V over all its steps, where its episode went on greedily at the end of
///            those steps (n_step), and never less than the episode earned (returns).
/// Reference. As train(); values of the states that steps lead to: Sutton and Barto (2018),
///            Reinforcement Learning, section 6.8; fitted value iteration: Gordon (1995), ICML,
///            261-268.
/// Guarantee. As train().
/// Cost.      A pass of the network over all states that the steps of a state lead to, for each
///            state met and for each state of a batch; a batch ends where it holds kMostRows of
///            these.
/// Memory.    States that were met and their steps, as TransitionCache says; all is forgotten, with
///            the replay buffer, where they take more than half of the memory limit, 256 MiB at
///            most.
/// @throws InputError as train(), and for options that make no sense here: inputs 'pieces', and
/// rewards that are not known.
[[nodiscard]] Training train_on_states(const TransitionSystem& system, const DqnOptions& options,
                                       const Budget& budget, const TrainingHooks& hooks,
                                       const TrainedPolicy* resume);

}  // namespace orasp::detail
