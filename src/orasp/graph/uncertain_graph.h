#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "orasp/containers/growing_array.h"
#include "orasp/containers/state_table.h"
#include "orasp/model/transition_system.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp {

/// The states that attempts lead to, by success and by failure, from the start of a problem whose
/// connections may have `success` below 1.
///
/// An attempt at connection c in state s earns r(s, c). With probability `success` c is handled.
/// Else the state stays; or what `breaks` names and is still open comes off too, earning nothing;
/// or the job ends, and the attempt earns the stated number instead of r(s, c).
///
/// Idea.       A failure keeps or shrinks the set of open connections, so but for attempts that
///             leave the state as it is the graph has no cycle. States are found by number of open
///             connections, most first: all that lead to a state are known before it is expanded.
/// Guided.     With a guide, a state has only the attempt that the guide names, where that is
///             legal: then the graph holds what following a plan or a policy can meet, and no more.
/// Cost.       One expansion a state; 24 bytes an attempt and about 40 a state beside its words.
/// Limit.      2^32 - 2 states; memory first. A breaking failure may lead to states that H lacks.
class UncertainGraph {
 public:
  /// The number of a state; 0 is the start.
  using State = std::uint32_t;
  static constexpr State kJobEnded = 0xffffffffU;

  struct Attempt {
    /// What the attempt earns, unless it ends the job.
    double reward;
    ConnectionIndex connection;
    /// The state after success.
    State done;
    /// The state after a failure: the same state where nothing changes, or kJobEnded.
    State failed;
  };

  /// Says which connection to attempt in a state; empty where all attempts are wanted.
  using Guide = std::function<std::optional<ConnectionIndex>(SetView open)>;

  /// Ends early when the budget does; then stop() says why, and the graph is of no use.
  /// @throws InputError as Expander::legal_actions.
  [[nodiscard]] static UncertainGraph build(const TransitionSystem& system, const Budget& budget,
                                            const Guide& guide = {});
  // A system that goes out of scope at once.
  static UncertainGraph build(const TransitionSystem&&, const Budget&, const Guide& = {}) = delete;

  [[nodiscard]] const TransitionSystem& system() const { return *system_; }
  [[nodiscard]] Stop stop() const { return stop_; }
  [[nodiscard]] std::size_t num_states() const { return states_.size(); }
  [[nodiscard]] std::size_t num_attempts() const { return attempts_.size(); }
  [[nodiscard]] SetView state(State state) const { return {states_.key(state), system_->words()}; }
  /// The attempts of a state, ascending by connection; none where no connection is open, and in a
  /// dead end.
  [[nodiscard]] std::span<const Attempt> attempts(State state) const {
    return attempts_.span().subspan(row_begin_[state], row_end_[state] - row_begin_[state]);
  }
  /// Whether the guide chose the one attempt of the state.
  [[nodiscard]] bool guided(State state) const { return guided_[state]; }
  /// States in an order in which each comes before those from which it is reached.
  [[nodiscard]] const std::vector<State>& last_first() const { return last_first_; }
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  explicit UncertainGraph(const TransitionSystem& system)
      : system_(&system), states_(system.words()) {}

  const TransitionSystem* system_;
  Stop stop_ = Stop::None;
  detail::StateTable<0> states_;
  detail::GrowingArray<Attempt> attempts_;
  std::vector<std::uint64_t> row_begin_;
  std::vector<std::uint64_t> row_end_;
  std::vector<bool> guided_;
  std::vector<State> last_first_;
};

/// What a best policy does and earns in each state of an UncertainGraph. All three are indexed by
/// state.
struct UncertainSolution {
  static constexpr std::uint32_t kNone = 0xffffffffU;
  /// The greatest expected reward from the state on; -infinity where every policy may end in a
  /// state without a legal step.
  std::vector<double> values;
  /// The place of the best attempt in UncertainGraph::attempts(state), of several the first; kNone
  /// where there is none.
  std::vector<std::uint32_t> choice;
  /// The expected number of attempts from the state on, if the best is always chosen.
  std::vector<double> attempts;
};

/// Solves the stochastic shortest path exactly, each state once.
/// @throws InputError where a probability is so small that an expectation is no finite number.
[[nodiscard]] UncertainSolution solve_uncertain(const UncertainGraph& graph);

}  // namespace orasp
