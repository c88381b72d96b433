#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orasp/model/random.h"
#include "orasp/model/transition_system.h"

namespace orasp {

namespace detail {
class ObservedColumns;
class TransitionCache;
}  // namespace detail

/// What becomes of an episode that is over.
enum class Autoreset {
  SameStep,  ///< the step that ends it also begins the next: what is observed is its start
  NextStep,  ///< the next step begins the next one, whatever its action is, and earns 0
  Off,       ///< it stays over until it is reset; to step it is an error
};

struct VectorEnvironmentOptions {
  Autoreset autoreset = Autoreset::SameStep;
  /// Bytes that remembered states may take.
  std::uint64_t max_bytes = std::uint64_t{256} << 20U;
};

/// Where a step writes to: memory of the caller, row by row, which is only touched during the call.
/// What is empty is not written.
struct EpisodeBuffers {
  /// What is observed, 1 or 0, of shape [episodes, observation_size].
  std::span<float> observations{};
  /// The same in bytes.
  std::span<std::uint8_t> observation_bytes{};
  /// 1 where an action is legal, else 0; of shape [episodes, actions].
  std::span<std::uint8_t> masks{};
  /// What the step earned, of shape [episodes].
  std::span<double> rewards{};
  /// Whether the step ended the plan, 1 or 0, of shape [episodes].
  std::span<std::uint8_t> terminated{};
  /// Whether it led to a dead end: the plan is not ended and nothing is legal; of shape [episodes].
  std::span<std::uint8_t> truncated{};
  /// Rows of episodes that the step ended: what was observed at their end (Autoreset::SameStep
  /// overwrites it above). Other rows are left as they are. Shapes as above.
  std::span<float> final_observations{};
  std::span<std::uint8_t> final_observation_bytes{};
  /// Of episodes that the step ended: all that they earned, and their steps; of shape [episodes].
  std::span<double> returns{};
  std::span<std::int64_t> lengths{};
};

/// A problem as reinforcement learning takes it: thousands of episodes side by side, stepped
/// together, into memory of the caller.
///
/// Problem.   Learners of the kind that ask for millions of steps a second. Environment works out
///            the actions of every state that an episode comes to; here each state is worked out
///            once.
/// Idea.      A cache, filled as states are met and shared by all episodes, remembers the legal
///            actions of a state, what they earn, and where they lead. A step is then a look-up.
///            All of it comes from the TransitionSystem by its Expander, nothing from here.
/// Reference. The paper's Markov decision process; the interface is that of Gymnasium's vectorised
///            environments (Towers et al. 2024, arXiv:2407.17032).
///
/// Actions.   Action c < connections is to handle connection c. Where the objective looks at the
///            direction in which a piece leaves, connection c has the 1 + directions actions from
///            c * (1 + directions): the first where nothing moves, then one for each direction of
///            Problem::directions(). Where a plan may end early (Goal::Stop::Best), the last action
///            is to end it.
/// Observed.  Column c < connections: 1 where connection c is open, the paper's indicator vector.
///            Where states have a context, what the steps before left behind follows, 1 in at most
///            one column each: of every attribute that the objective looks back at the value in
///            force, and the place of the last step. So what is observed is the whole state. At the
///            end of a plan all is 0.
/// Guarantee. Masks, rewards and ends are those of TransitionSystem, to the bit, whatever was
///            remembered or forgotten. Nothing is random but sample(), whose numbers follow from
///            the seed. A call that throws leaves all episodes as they were.
/// Cost.      A step to a state that is remembered: O(actions + connections) bytes written, some
///            30 ns on `hubble`. To another one: one expansion, worked out together with those of
///            the other episodes (docs/performance.md).
/// Memory.    Up to `max_bytes` for what is remembered: 16 bytes an action of an expanded state.
///            Where a step goes beyond, all is forgotten but the states in which episodes stand,
///            and worked out again by the Expander as it is met. So the limit is passed by at most
///            what the states of one step take. Episodes: O(episodes * steps).
/// Limit.     Steps that take parts off (StepKind::Part) are refused. All attempts succeed.
/// Errors.    @throws InputError for those, where no first step is legal, where buffers have other
///            sizes, for an action that is not legal (with the reasons), and as Expander does.
///
///     VectorEnvironment world(system, 1024);
///     std::vector<std::uint8_t> masks(1024 * world.num_actions());
///     std::vector<double> rewards(1024);
///     std::vector<std::int64_t> actions(1024);
///     const EpisodeBuffers buffers{.masks = masks, .rewards = rewards};
///     world.reset(buffers);
///     for (int i = 0; i < 1000; ++i) {
///       world.sample(actions);             // or what a policy chooses, by the masks
///       world.step(actions, buffers);
///     }
class VectorEnvironment {
 public:
  /// All episodes stand at the start. The system must outlive it.
  VectorEnvironment(const TransitionSystem& system, std::size_t episodes,
                    const VectorEnvironmentOptions& options = {});
  // A system that goes out of scope at once.
  VectorEnvironment(const TransitionSystem&&, std::size_t,
                    const VectorEnvironmentOptions& = {}) = delete;
  ~VectorEnvironment();
  VectorEnvironment(VectorEnvironment&&) noexcept;
  VectorEnvironment& operator=(VectorEnvironment&&) = delete;

  [[nodiscard]] const TransitionSystem& system() const { return system_; }
  [[nodiscard]] std::size_t size() const { return totals_.size(); }
  [[nodiscard]] std::size_t num_actions() const { return num_actions_; }
  [[nodiscard]] std::size_t observation_size() const { return observation_size_; }
  /// The most steps that an episode can have.
  [[nodiscard]] std::size_t max_steps() const { return max_steps_; }

  /// Puts all episodes at the start. Writes observations and masks, and 0 to what steps earn and
  /// end.
  void reset(const EpisodeBuffers& buffers);
  /// Puts those episodes at the start whose flag is not 0; `which` is of shape [episodes].
  void reset(std::span<const std::uint8_t> which, const EpisodeBuffers& buffers);
  /// From now on episodes start where these actions lead to from the start of the system, and all
  /// are put there. What best() knew is forgotten. @throws InputError if one is not legal, or if
  /// nothing is legal after them.
  void start_after(std::span<const std::int64_t> actions);

  /// Takes one action in each episode; `actions` is of shape [episodes].
  void step(std::span<const std::int64_t> actions, const EpisodeBuffers& buffers);
  /// Writes observations and masks of where the episodes stand, and nothing else.
  void observe(const EpisodeBuffers& buffers) const;

  /// Draws a legal action for each episode, each equally likely; 0 where none is. `actions` is of
  /// shape [episodes].
  void sample(std::span<std::int64_t> actions) { sample(actions, random_); }
  /// The same by numbers of the caller.
  void sample(std::span<std::int64_t> actions, SplitMix64& random) const;
  void seed(std::uint64_t seed) { random_ = SplitMix64(seed); }

  // One episode.

  /// The open connections; none at the end of a plan.
  [[nodiscard]] SetView open(std::size_t episode) const;
  /// Whether the plan is ended.
  [[nodiscard]] bool done(std::size_t episode) const;
  /// Whether it is not, and nothing is legal.
  [[nodiscard]] bool dead_end(std::size_t episode) const;
  [[nodiscard]] bool legal(std::size_t episode, std::int64_t action) const;
  /// What its steps earned, and how many they were.
  [[nodiscard]] double total(std::size_t episode) const { return totals_[episode]; }
  [[nodiscard]] std::size_t length(std::size_t episode) const { return lengths_[episode]; }
  /// Its plan so far, those of start_after first.
  [[nodiscard]] std::vector<PlanStep> plan(std::size_t episode) const;
  /// Why an action is not legal: the reasons, joined by "; ". Empty if it is.
  [[nodiscard]] std::string obstacle(std::size_t episode, std::int64_t action) const;

  /// What an action takes, and the action that takes it.
  [[nodiscard]] PlanStep plan_step(std::int64_t action) const;
  [[nodiscard]] std::int64_t action_of(const PlanStep& step) const;
  /// What a column of an observation says: "open 1-2", "tool M4" or "place 3".
  [[nodiscard]] std::string column_name(std::size_t column) const;

  /// The plan of the episode that ended its plan and earned most, the first of several.
  struct Best {
    double reward;  ///< without what the actions of start_after earned
    std::vector<PlanStep> plan;
  };
  [[nodiscard]] std::optional<Best> best() const;

  /// States expanded, repeats counted; states remembered now, their bytes, and how often all were
  /// forgotten.
  [[nodiscard]] std::uint64_t expanded() const;
  [[nodiscard]] std::size_t remembered() const;
  [[nodiscard]] std::uint64_t bytes() const;
  [[nodiscard]] std::uint64_t forgotten() const { return forgotten_; }

 private:
  void check(const EpisodeBuffers& buffers) const;
  [[noreturn]] void refuse(std::size_t episode, std::int64_t action) const;
  [[nodiscard]] std::string obstacle_in(std::uint32_t number, std::int64_t action) const;
  void write_state(std::size_t episode, const EpisodeBuffers& buffers) const;
  void write_observation(std::uint32_t state, std::size_t episode, std::span<float> floats,
                         std::span<std::uint8_t> bytes) const;
  void begin(std::size_t episode);
  void keep_to_limit();
  void note_best(std::size_t episode);
  [[nodiscard]] std::vector<PlanStep> plan_of(std::span<const std::uint32_t> actions) const;

  const TransitionSystem& system_;
  VectorEnvironmentOptions options_;
  std::unique_ptr<detail::TransitionCache> cache_;
  std::unique_ptr<const detail::ObservedColumns> observed_;
  std::size_t num_actions_;
  std::size_t observation_size_;
  std::size_t max_steps_;
  /// The state in which episodes begin, its number and that of its expansion.
  std::vector<std::uint64_t> start_;
  std::vector<std::uint32_t> start_actions_;
  std::uint32_t start_state_ = 0;
  std::uint32_t start_expansion_ = 0;
  // By episode.
  std::vector<std::uint32_t> states_;
  std::vector<std::uint32_t> expansions_;
  std::vector<std::uint8_t> over_;
  std::vector<double> totals_;
  std::vector<std::uint32_t> lengths_;
  std::vector<std::uint32_t> history_;  ///< actions, of shape [episodes, max_steps]
  /// Of the step at hand: the place of its transition, and the state that it leads to.
  std::vector<std::uint64_t> places_;
  std::vector<std::uint32_t> next_;
  std::optional<double> best_reward_;
  std::vector<std::uint32_t> best_actions_;
  SplitMix64 random_{1};
  std::uint64_t forgotten_ = 0;
};

}  // namespace orasp
