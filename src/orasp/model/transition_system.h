#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/model/connection_set.h"
#include "orasp/model/problem.h"
#include "orasp/model/situation.h"

namespace orasp {

namespace detail {
enum class Walk;
struct Rules;
}  // namespace detail

/// One legal action of a state: handling `connection`, and what that step earns.
struct Action {
  Action() = default;
  Action(ConnectionIndex the_connection, double the_reward, std::uint32_t the_number = 0)
      : connection(the_connection), number(the_number), reward(the_reward) {}

  /// The connection that the step handles; of several (TransitionSystem::wide) the first.
  ConnectionIndex connection;
  /// Its place among the legal actions of its state, where TransitionSystem::wide().
  std::uint32_t number = 0;
  double reward = 0;
};

/// What a step of a plan takes, where that is not one connection alone.
struct PlanStep {
  std::vector<ConnectionIndex> connections;  ///< ascending; none: the plan ends here
  /// The direction in which the moved piece leaves, where the planner chose one.
  std::optional<DirectionIndex> direction{};
};

/// The steps of a plan, and what they earn together.
struct PlanWalk {
  std::vector<PlanStep> steps;
  double reward = 0;
};

/// Everything about one step. In disassembly the step removes `connection` and cuts a piece into A
/// and B; in assembly it makes the connection and joins A and B. A holds the first part of the
/// connection.
struct Step {
  ConnectionIndex connection = 0;
  /// All that it handles: the one, or, where steps take parts off, several, the first of which is
  /// `connection`.
  std::vector<ConnectionIndex> connections{};
  std::size_t before = 0;         ///< connections present before the step
  std::size_t after = 0;          ///< connections present after the step
  bool separates = false;         ///< its two parts are in different pieces without the connection
  bool completes = false;         ///< it is the last step of all
  bool both_stay = false;         ///< it moves nothing, since A and B both hold a base part
  bool a_moves = false;           ///< the moved piece is A; meaningful only if one moves
  std::vector<PartIndex> a;       ///< parts of A, ascending; empty unless it separates
  std::vector<PartIndex> b;       ///< parts of B, ascending; empty unless it separates
  double moved_mass = 0;          ///< kg; 0 unless it moves something
  double kept_mass = 0;           ///< kg, where nothing moves of A and B; 0 unless it separates
  std::size_t subassemblies = 0;  ///< pieces with two or more parts after the step
  double reward = 0;
  /// The directions in which the moved piece can leave the other, in the order of the file; empty
  /// unless it separates and the problem has blocking. Of a step of an assembly: the opposites of
  /// those in which it can arrive. Not yet known when an objective is asked for the reward.
  std::vector<DirectionIndex> free_directions{};
  /// The one in which it leaves, in a plan (model/step_directions.h).
  std::optional<DirectionIndex> direction{};

  [[nodiscard]] bool moves() const { return separates && !both_stay; }
  /// The parts that move; none where both A and B hold a base part.
  [[nodiscard]] const std::vector<PartIndex>& moved() const {
    static const std::vector<PartIndex> kNone;
    if (both_stay) return kNone;
    return a_moves ? a : b;
  }
  /// The piece that stays, where the other moves; else B, which stays as A does.
  [[nodiscard]] const std::vector<PartIndex>& kept() const { return a_moves ? b : a; }
};

enum class Constraint {
  /// By `after` or `made_after`: what must be gone before it is still there; in assembly, what must
  /// be made before it is missing.
  Precedence,
  /// By `after_any`: all of them are still there; in assembly, it would be the last of them while
  /// the connection that must be made before one of them is missing and could no longer be made.
  PrecedenceAny,
  /// By `made_after_any`: none of them is there; in disassembly, it is the last of them while the
  /// connection that needs one of them is still there and could no longer be taken off.
  PrecedenceMadeAny,
  MaxSubassemblies,  ///< too many pieces with two or more parts
  MaxMovedParts,
  MaxMovedMass,
  Grounded,      ///< a subassembly would hold no base part
  Blocking,      ///< no direction is free
  Goal,          ///< the plan ends before its goal is reached, or goes on after it
  NotOneStep,    ///< what a step takes is not what one step can take
  NotOpen,       ///< the connection was handled before (or, in a bare list, is missing at the end)
  Inaccessible,  ///< Situation::inaccessible
  NotNext,       ///< Situation::not_next
  Late,          ///< Situation::late
};

/// The name a problem file uses: "precedence", "max_subassemblies", ...
[[nodiscard]] std::string_view constraint_name(Constraint constraint);

/// Why an action is not legal, in words and as data.
struct Violation {
  Constraint constraint = Constraint::NotOpen;
  std::string
      where;  ///< place in the problem file, e.g. "precedence[2]" or "limits.max_moved_parts"
  std::string message;  ///< one sentence
  /// Connections that stand in the way (precedence), ascending; empty for the other constraints.
  std::vector<ConnectionIndex> blocking_connections;
  /// The rule was broken before, by the step that handled those connections too early: now it is
  /// too late.
  bool too_late = false;
};

/// Least and greatest reward of a step; infinite where nothing is known.
struct RewardRange {
  double least;
  double greatest;
};

/// The rules of the world: which actions are legal, where they lead, what they earn. They stand
/// here, and every planner, the environment and the explanations use them. The check of plans
/// (model/plan_check.h) has its own, so that each finds the other's mistakes.
///
/// A *state* is the set of open connections: those still to be handled. In disassembly these are
/// the connections still present; in assembly those still missing. So in both directions the start
/// is the full set, an action takes one connection out, the goal is the empty set, and every path
/// has as many steps as the start has open connections: no planner needs to know the direction.
///
/// A Situation makes it the problem that is left in the middle of the work: the start is what is
/// open and accessible then, what is inaccessible stays as it is for ever and is part of no state.
/// No planner needs to know that either.
///
/// Immutable and shareable between threads. Keeps a reference to the problem, which must outlive
/// it. For work, each thread makes its own Expander.
class TransitionSystem {
 public:
  /// @throws InputError if an expression does not compile or sums of rewards may not be finite.
  explicit TransitionSystem(const Problem& problem);
  /// @throws InputError as above, and where a set of `situation` is not over the problem's
  /// connections.
  TransitionSystem(const Problem& problem, const Situation& situation);
  // A problem that goes out of scope at once.
  explicit TransitionSystem(const Problem&&) = delete;
  TransitionSystem(const Problem&&, const Situation&) = delete;
  ~TransitionSystem();
  TransitionSystem(const TransitionSystem&) = delete;
  TransitionSystem& operator=(const TransitionSystem&) = delete;

  [[nodiscard]] const Problem& problem() const { return problem_; }
  [[nodiscard]] std::size_t num_connections() const { return problem_.num_connections(); }
  /// 64-bit words of a state.
  [[nodiscard]] std::size_t words() const { return words_; }
  /// Those of them that say what is open; they come first.
  [[nodiscard]] std::size_t open_words() const { return words_for(num_connections()); }
  [[nodiscard]] SetView open(SetView state) const { return state.first(open_words()); }
  /// The open connections at the start.
  [[nodiscard]] const ConnectionSet& start() const;
  /// The words of the start.
  [[nodiscard]] SetView start_state() const { return start_state_; }
  /// Whether a state is that in which a plan ends. It is the one whose words are all 0.
  [[nodiscard]] bool ends(SetView state) const {
    return std::ranges::all_of(state, [](std::uint64_t word) { return word == 0; });
  }
  /// Whether there is more to states and steps than open connections of which one is handled. Then
  /// a plan may end while connections are left (Goal), a step may handle several (StepKind::Part),
  /// or a state says what the steps before left behind, in words after those of the open ones: a
  /// *context*. Who walks through states then asks Expander::successor where an action leads.
  [[nodiscard]] bool wide() const;
  /// Whether states have a context.
  [[nodiscard]] bool looks_back() const;
  /// Connections open at the start: the steps of every plan, or the most where wide().
  [[nodiscard]] std::size_t num_steps() const { return num_steps_; }
  /// Whether the start is all connections and nothing but the problem's own constraints judges
  /// steps.
  [[nodiscard]] bool whole() const;
  /// Whether a legal step may lead to a state from which the goal cannot be reached: under limits,
  /// blocking, or `after_any` beside `made_after_any`.
  [[nodiscard]] bool may_shut_out() const;
  /// Whether something cannot be next or is late.
  [[nodiscard]] bool ordered() const;
  /// Connections that are part of no state and stay as they are: those that are open and never
  /// handled (Situation::inaccessible); backwards(), those that are made already.
  [[nodiscard]] const ConnectionSet& kept() const;
  /// The situation that it was made with.
  [[nodiscard]] const Situation& situation() const { return situation_; }
  /// The connections that are physically there in the state `open`.
  [[nodiscard]] ConnectionSet present(SetView open) const;

  /// The plans of an assembly, walked from their end: the start is the product that they end with,
  /// a step takes off what a plan makes, and the goal is the state at which the work stands. A
  /// sequence is legal backwards if and only if its reverse is a plan, and each step earns what the
  /// plan's step earns. So everything that is known about taking products apart helps to put them
  /// together. Only where steps make connections (not takes_apart()) and nothing is ordered().
  [[nodiscard]] TransitionSystem backwards() const;
  /// Whether a step takes a connection away: in disassembly, and backwards(). Then a state is what
  /// is there and still to be taken off, else what is missing and still to be made.
  [[nodiscard]] bool takes_apart() const;
  /// Whether the step that completes is the first one, not the last: backwards().
  [[nodiscard]] bool completes_first() const;

  /// A reason, found without search, for which no plan exists: the start has more subassemblies
  /// than allowed, two parts that must come apart block each other in every direction, or the
  /// precedence can never be met (then the message spells out a cycle). Empty if there is none of
  /// these.
  [[nodiscard]] std::optional<Violation> infeasibility() const;
  /// Two parts of one piece that must come apart and block each other in every direction: no
  /// single straight motion parts them, whatever else has been taken off. The first such pair.
  /// O(blockers), and O(parts + connections) where two parts block each other so.
  [[nodiscard]] std::optional<std::array<PartIndex, 2>> locked_pair() const;

  /// What handling `connection` can earn in any state with at most `open` open connections;
  /// `completes` says whether it is the last step. Admissible: no reachable step lies outside.
  /// O(parts * terms of the objective).
  [[nodiscard]] RewardRange reward_range(ConnectionIndex connection, std::size_t open,
                                         bool completes) const;

  /// Whether a step's reward is its connection's own (Expander::own_reward) and, where it
  /// separates, a gain that depends on nothing but A, B, the connection and whether it completes:
  /// not on what else is there or was done before. Then pieces of the product can be planned for
  /// one by one.
  [[nodiscard]] bool sees_piece_only() const;
  /// Whether that gain depends on the sizes of A and B alone; on nothing but which parts move; and
  /// whether it depends on the connection.
  [[nodiscard]] bool gain_by_sizes() const;
  [[nodiscard]] bool gain_by_moved() const;
  [[nodiscard]] bool gain_by_connection() const;

  /// Whether a step's reward depends on nothing but the sizes of A and B and on whether it
  /// completes.
  [[nodiscard]] bool sees_sizes_only() const;
  /// If so: the most that a step earns which cuts a piece into a and b parts (0 and 0: it separates
  /// nothing). Exact but for `cubesat_zone`, where a whole starting piece of fewer than four parts
  /// may earn less.
  [[nodiscard]] double greatest_size_reward(std::size_t a, std::size_t b, bool completes) const;
  /// If sees_piece_only(): the most that a cut gains (Expander::cut_gain) that moves a piece of at
  /// least `least` and at most `most` parts, all of `parts` among them, which are at least one;
  /// infinite where that is not known. What is at most `low_enough` need not be the least that is
  /// known.
  [[nodiscard]] double greatest_gain_of_moving_with(std::span<const PartIndex> parts,
                                                    std::size_t least, std::size_t most,
                                                    double low_enough) const;

  /// Whether some reward depends on whether A and B together are a whole starting piece.
  [[nodiscard]] bool sees_starting_pieces() const;
  /// Whether a step's reward depends on nothing but the connection and how many are present.
  [[nodiscard]] bool sees_order_only() const;
  /// Whether rewards are worked out by a formula or a function of the user, which may fail.
  [[nodiscard]] bool calls_out() const;

  /// Pieces with two or more parts among the connections of `present` (not `open`).
  [[nodiscard]] std::size_t subassemblies(SetView present) const;

  /// The rules, arranged for work.
  [[nodiscard]] const detail::Rules& rules() const;

 private:
  friend class Expander;
  struct Rules;
  TransitionSystem(const Problem& problem, const Situation& situation, detail::Walk walk);
  [[nodiscard]] Violation waits_in_vain(ConnectionIndex connection, ConnectionIndex other,
                                        std::size_t entry, bool to_be_made) const;
  [[nodiscard]] std::optional<Violation> ungrounded(SetView present) const;
  [[nodiscard]] Violation locked(const std::array<PartIndex, 2>& pair) const;
  [[nodiscard]] std::array<ConnectionSet, 2> both_ends() const;

  const Problem& problem_;
  std::unique_ptr<const Rules> rules_;
  /// Where something is late and legal steps may shut something out: the same without any order.
  std::unique_ptr<const TransitionSystem> in_any_order_;
  Situation situation_;
  std::size_t num_steps_;
  std::size_t words_;
  std::vector<std::uint64_t> start_state_;
};

/// Works out steps. Holds scratch memory, so each thread makes its own; cheap to make (O(parts +
/// connections)).
///
///     const TransitionSystem system(problem);
///     Expander expander(system);
///     ConnectionSet state = system.start();
///     while (!state.empty()) {
///       const auto actions = expander.legal_actions(state.view());
///       if (actions.empty()) break;                       // a dead end
///       state.erase(actions.front().connection);
///     }
class Expander {
 public:
  explicit Expander(const TransitionSystem& system);
  // A system that goes out of scope at once.
  explicit Expander(const TransitionSystem&&) = delete;
  ~Expander();
  Expander(Expander&&) noexcept;
  Expander& operator=(Expander&&) = delete;

  /// The legal actions of a state with their rewards, ascending by connection. The span is valid
  /// until the next call. One pass over the assembly finds all separations at once: O(parts +
  /// connections), plus the size of the piece for each separation where the objective,
  /// blocking or a mass limit looks inside it.
  /// Reference. Bridges by depth-first search: Tarjan
  /// (1974), Inf. Proc. Letters 2(6), 160-161.
  /// @throws InputError if an expression or a callable yields a reward that is not finite.
  [[nodiscard]] std::span<const Action> legal_actions(SetView open);

  /// The steps that take parts off one piece, whatever else is there: where StepKind::Part and
  /// TransitionSystem::takes_apart(). `piece`: the connections among its parts. `completes`:
  /// whether the step that completes is one of them (in disassembly one that leaves nothing of the
  /// piece; backwards any). Of the rules those that tell a step by its piece: all but `after_any`
  /// and `made_after_any`, and of the others what they say where all other pieces are taken apart.
  /// So no step of any plan is missing. Rewards are those of legal_actions where
  /// TransitionSystem::sees_piece_only(). Successors are those of the piece.
  [[nodiscard]] std::span<const Action> piece_steps(SetView piece, bool completes);

  /// Writes to `next` the state that the action leads to. Where wide(), the action is one of those
  /// that the last call of legal_actions gave, for this very state.
  void successor(SetView state, const Action& action, std::span<std::uint64_t> next) const;
  /// What the action takes; where wide(), of the last call of legal_actions, as above.
  [[nodiscard]] PlanStep plan_step(const Action& action) const;
  /// Whether a legal action leads from one state to the other.
  [[nodiscard]] bool leads_to(SetView from, SetView to);
  /// What the steps of a walk take, from state to state (each of words() words, one after another,
  /// the first of them the start of the walk). Of several ways between two states it is one that
  /// earns most. @throws std::logic_error if no legal action leads from one to the next.
  [[nodiscard]] PlanWalk steps_along(std::span<const std::uint64_t> states);

  /// The same for many states, which stand one after another: calls visit(i, legal actions of state
  /// i). Quicker than one by one where several can be analysed at once.
  template <class Visit>
  void for_each_expansion(std::span<const std::uint64_t> states, Visit&& visit) {
    const std::size_t words = system_.words();
    const std::size_t size = states.size() / words;
    if (asks_for_many()) {
      for (std::size_t begin = 0; begin < size; begin += kMostAsked) {
        const std::size_t many = size - begin < kMostAsked ? size - begin : kMostAsked;
        expand_many(states.subspan(begin * words, many * words));
        for (std::size_t i = 0; i < many; ++i) visit(begin + i, actions_of_many(i));
      }
      return;
    }
    for (std::size_t begin = 0; begin < size; begin += kBatch) {
      const std::size_t batch = size - begin < kBatch ? size - begin : kBatch;
      const auto loaded = states.subspan(begin * words, batch * words);
      load(loaded);  // nothing, where wide()
      for (std::size_t i = 0; i < batch; ++i) visit(begin + i, loaded_actions(loaded, i));
    }
  }

  /// The step that handles `connection`, which must be open, whether it is legal or not. O(parts +
  /// connections).
  [[nodiscard]] Step step(SetView open, ConnectionIndex connection);

  /// What the step earns that handles `connection` when it is the last one of all, whatever else is
  /// open.
  [[nodiscard]] double completing_reward(SetView open, ConnectionIndex connection);

  /// Whether handling `connection` is legal; false if it is not open. O(parts + connections).
  [[nodiscard]] bool legal(SetView open, ConnectionIndex connection);

  /// Why handling `connection` is not legal, all reasons; empty if it is legal. O(parts +
  /// connections).
  [[nodiscard]] std::vector<Violation> violations(SetView open, ConnectionIndex connection);

  /// Step::free_directions of the step that handles `connection`, which must be open. O(parts +
  /// connections + directions).
  [[nodiscard]] std::vector<DirectionIndex> free_directions(SetView open,
                                                            ConnectionIndex connection);

  // Pieces on their own, in disassembly, for objectives with TransitionSystem::sees_piece_only().

  /// What handling `connection` earns when it separates nothing and does not complete.
  /// @throws InputError as legal_actions.
  [[nodiscard]] double own_reward(ConnectionIndex connection);
  /// What removing `connection` earns beyond own_reward when it cuts a piece into `a`, which holds
  /// its first part, and `b`, without completing; nothing where max_moved_parts, max_moved_mass or
  /// blocking forbid the cut. With `direction_free` blocking is known to allow it. O(parts of the
  /// piece), or O(1) where only sizes matter.
  [[nodiscard]] std::optional<double> cut_gain(std::span<const PartIndex> a,
                                               std::span<const PartIndex> b,
                                               ConnectionIndex connection,
                                               bool direction_free = false);
  /// The most that a cut gains into a smaller side of `moved` parts and a larger one of `kept`,
  /// whatever they are; infinite where that is not known. Exact where gain_by_sizes().
  [[nodiscard]] double greatest_gain(std::size_t moved, std::size_t kept);
  /// The most that a cut gains that moves just these parts, whatever from; infinite where that is
  /// not known.
  [[nodiscard]] double greatest_gain_of_moving(std::span<const PartIndex> moved);
  /// For each connection the least by which a cut at it gains less than greatest_gain and
  /// greatest_gain_of_moving say of its sides, true of any connection. O(connections * terms).
  [[nodiscard]] std::vector<double> least_extra_costs() const;
  /// Whether a cut gains less, or as much, the more parts it moves.
  [[nodiscard]] bool moving_more_costs_more() const;
  /// How much more removing `connection` earns because it completes, where nothing else is left.
  [[nodiscard]] double completion_surplus(ConnectionIndex connection);

 private:
  static constexpr std::size_t kBatch = 8;
  /// States whose steps a function of many steps (Callable::rewards) is asked about at once.
  static constexpr std::size_t kMostAsked = 4096;
  struct Scratch;
  [[nodiscard]] std::optional<Action> best_action_to(SetView from, SetView to);
  [[nodiscard]] bool asks_for_many() const;
  void expand_many(std::span<const std::uint64_t> states);
  [[nodiscard]] std::span<const Action> actions_of_many(std::size_t i) const;
  void load(std::span<const std::uint64_t> states);
  [[nodiscard]] std::span<const Action> loaded_actions(std::span<const std::uint64_t> states,
                                                       std::size_t i);

  const TransitionSystem& system_;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace orasp
