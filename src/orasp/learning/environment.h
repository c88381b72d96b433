#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "orasp/model/transition_system.h"

namespace orasp {

/// Writes the paper's indicator vector of a state, shape [connections]: 1 where open, else 0.
void indicate(SetView open, std::span<float> indicator);

/// The problem as a learner sees it: several episodes side by side, each a state that steps change.
/// Everything legal and earned comes from the TransitionSystem; this only keeps the episodes.
///
/// Reference. The paper's Markov decision process; the interface is that of Gymnasium's vectorised
///            environments (Towers et al. 2024, arXiv:2407.17032).
/// Cost.      The actions of all episodes that moved are worked out together, when the first is
///            asked for: as Expander::for_each_expansion. Memory: O(episodes * connections).
///
///     Environment world(system, 32);
///     while (!world.over(0)) {
///       total += world.step(0, world.actions(0).front().connection);
///     }
class Environment {
 public:
  /// All episodes stand at the start. The system must outlive it.
  Environment(const TransitionSystem& system, std::size_t episodes);
  // A system that goes out of scope at once.
  Environment(const TransitionSystem&&, std::size_t) = delete;

  [[nodiscard]] std::size_t size() const { return totals_.size(); }
  [[nodiscard]] std::size_t num_connections() const { return system_.num_connections(); }

  /// Puts an episode at the start, or at a state; its rewards count from 0.
  void reset(std::size_t episode);
  void reset(std::size_t episode, const ConnectionSet& open);
  /// From now on these connections are never legal, in any episode.
  void forbid(const ConnectionSet& connections);

  /// Open connections.
  [[nodiscard]] SetView open(std::size_t episode) const;
  [[nodiscard]] std::size_t num_open(std::size_t episode) const { return open_counts_[episode]; }
  /// The legal actions that are not forbidden, ascending by connection; valid until the next step
  /// or reset.
  [[nodiscard]] std::span<const Action> actions(std::size_t episode);
  /// The same as a mask, shape [connections]: 1 where legal, else 0.
  void mask(std::size_t episode, std::span<float> mask);
  /// The paper's indicator vector of open connections, shape [connections]: 1 where open, else 0.
  void observe(std::size_t episode, std::span<float> observation) const;

  /// Handles a connection. @returns what the step earns. @throws InputError if it is not among
  /// actions(episode).
  double step(std::size_t episode, ConnectionIndex connection);
  /// Rewards of the episode's steps so far.
  [[nodiscard]] double total(std::size_t episode) const { return totals_[episode]; }

  /// Nothing is open but what is forbidden.
  [[nodiscard]] bool done(std::size_t episode) const;
  /// Not done, and nothing is legal.
  [[nodiscard]] bool dead_end(std::size_t episode) {
    return !done(episode) && actions(episode).empty();
  }
  [[nodiscard]] bool over(std::size_t episode) { return done(episode) || dead_end(episode); }

  /// States whose actions were worked out, repeats counted.
  [[nodiscard]] std::uint64_t expanded() const { return expanded_; }

 private:
  void refresh();

  const TransitionSystem& system_;
  Expander expander_;
  std::size_t words_;
  /// The states of all episodes, of shape [episodes, words].
  std::vector<std::uint64_t> states_;
  std::vector<std::size_t> open_counts_;
  std::vector<std::vector<Action>> actions_;
  /// For each episode, whether its actions are not yet those of its state.
  std::vector<bool> stale_;
  std::vector<double> totals_;
  ConnectionSet forbidden_;
  std::vector<std::uint64_t> batch_;
  std::vector<std::size_t> batch_episodes_;
  std::uint64_t expanded_ = 0;
};

}  // namespace orasp
