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
#include "orasp/planners/value_iteration.h"
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
  using State = std::uint32_t;  ///< 0 is the start
  static constexpr State kJobEnded = 0xffffffffU;

  struct Attempt {
    double reward;  ///< of the attempt, unless it ends the job
    ConnectionIndex connection;
    State done;    ///< the state after success
    State failed;  ///< after a failure: the state itself where nothing changes; or kJobEnded
  };

  /// Which connection to attempt in a state; empty: no opinion.
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

/// A number for each state of an UncertainGraph.
struct UncertainSolution {
  static constexpr std::uint32_t kNone = 0xffffffffU;
  /// The greatest expected reward from the state on; -infinity where every policy may end in a
  /// state without a legal step.
  std::vector<double> values;
  /// Where in attempts(state) the best stands, of several the first; kNone where there is none.
  std::vector<std::uint32_t> choice;
  /// Expected number of attempts from the state on, under that choice.
  std::vector<double> attempts;
};

/// Solves the stochastic shortest path exactly, each state once.
/// @throws InputError where a probability is so small that an expectation is no finite number.
[[nodiscard]] UncertainSolution solve_uncertain(const UncertainGraph& graph);

/// Finds a policy with the greatest expected reward where attempts may fail.
///
/// Problem.    Maximise the expected sum of rewards until no connection is open or the job ends:
///             a stochastic shortest path. A policy that may end in a state that is not the goal
///             and has no legal step is worth -infinity.
/// Idea.       Bellman's equation V(s) = max over c of p (r + V(s \ c)) + (1 - p) (what a failure
///             earns + V(where it leads)). An attempt that leaves the state as it is when it fails
///             solves to r / p + V(s \ c), so one sweep, fewest open connections first, is exact.
///             The textbook order iterates the plain operator on all states from initial_value.
/// Reference.  Bertsekas and Tsitsiklis (1991), Mathematics of Operations Research 16(3), 580-595.
/// Guarantee.  `layers`: Optimal. Every policy ends with probability 1, so a residual e (the most
///             by which the operator changes V, and what rounding can hide of it) puts V within
///             e * N of the optimum at the start, N being the greatest expected number of attempts
///             of any policy: unroll V <= T V + e along the greedy policy and V >= T V - e along an
///             optimal one. Textbook: Optimal where the policy found meets V + e * N, else Feasible
///             with this as the bound.
/// Cost.       O(attempts) a sweep; memory as UncertainGraph and 28 bytes a state (44 textbook).
/// Limit.      The graph must fit in memory; Unknown where the budget ends before it is built.
/// Repeatable. One thread; ties go to the lowest connection.
///
/// Result::reward is the expected reward of the policy; Result::sequence is its order where no
/// failure changes the state; Result::expectation holds the policy.
[[nodiscard]] Result uncertain_value_iteration(const TransitionSystem& system,
                                               const ValueIterationOptions& options,
                                               const Budget& budget);
/// The same on a graph that is there, guided or not.
[[nodiscard]] Result uncertain_value_iteration(const UncertainGraph& graph,
                                               const ValueIterationOptions& options,
                                               const Budget& budget);

/// Follows a plan: its first connection that is still open. Where that is not legal, the graph
/// keeps all attempts, and the best is chosen knowing that the plan is taken up again.
[[nodiscard]] UncertainGraph::Guide guide_by_plan(std::span<const ConnectionIndex> sequence);

/// Follows a policy. @throws InputError, when asked, where the policy has no entry for a state that
/// is not the goal, or names a connection that is not legal there.
[[nodiscard]] UncertainGraph::Guide guide_by_policy(const TransitionSystem& system,
                                                    std::span<const PolicyState> policy);

struct SimulationOptions {
  std::uint64_t runs = 10'000;
  std::uint64_t seed = 1;
};

/// What random runs came to.
struct Simulation {
  std::vector<double> rewards;          ///< of each run
  std::vector<std::uint64_t> attempts;  ///< of each run
  std::uint64_t aborted = 0;            ///< runs that a failure ended
  /// How often the plan could not go on: its next connection was not legal, or had come off.
  std::uint64_t replanned = 0;
  Stop stop = Stop::None;  ///< what ended it before the last run; the run under way is dropped
};

/// Executes `choice` (of solve_uncertain on this graph; the start must have a finite value) with
/// random failures. `plan`, if there is one, is what guides the graph. Run i draws from SplitMix64
/// seeded with the i-th number of SplitMix64(seed), so a longer simulation begins with the shorter
/// one, and the same seed gives the same runs on every machine. O(attempts made).
[[nodiscard]] Simulation simulate(const UncertainGraph& graph,
                                  std::span<const std::uint32_t> choice,
                                  std::span<const ConnectionIndex> plan,
                                  const SimulationOptions& options, const Budget& budget);

}  // namespace orasp
