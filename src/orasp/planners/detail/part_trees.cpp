#include "orasp/planners/detail/part_trees.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "orasp/bounds/wide_bound.h"
#include "orasp/containers/growing_array.h"
#include "orasp/containers/state_table.h"
#include "orasp/model/detail/rules.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/detail/wide_search.h"
#include "orasp/planners/planner_support.h"
#include "orasp/task/detail/listing_watch.h"
#include "orasp/task/memory_limit.h"

namespace orasp::detail {

namespace {

using Words = std::vector<std::uint64_t>;

class PartTrees {
 public:
  /// Steps of `system` take parts off. All must outlive it.
  PartTrees(const TransitionSystem& system, const Budget& budget, Result& result)
      : system_(system),
        budget_(budget),
        allowed_(allowed_bytes(budget)),
        result_(result),
        listing_(system, budget),
        expander_(system),
        completes_first_(system.completes_first()),
        table_(system.words() + 1) {}

  /// The most that a plan may earn; -infinity where there is none. Only to be used where
  /// result.stop is None.
  double run() {
    const std::vector<Words> pieces = pieces_of(system_.start_state());
    if (pieces.empty()) return 0;  // nothing is to be done
    const Role completing = completes_first_ ? Role::First : Role::Last;
    double inside = 0;
    double most = -kInfinity;
    for (const Words& piece : pieces) {
      if (pieces.size() > 1) inside += value_of(piece, Role::Inside);
    }
    for (const Words& piece : pieces) {
      if (result_.stop != Stop::None) break;
      const double others = pieces.size() > 1 ? inside - value_of(piece, Role::Inside) : 0;
      const double total = others + value_of(piece, completing);
      if (total > most) {
        most = total;
        first_piece_ = piece;
      }
    }
    result_.statistics.states = table_.size();
    note_bytes();
    return most;
  }

  /// The states of a plan that carries the best tree out; empty where its steps have no order in
  /// which all are legal. Only after run() has found one.
  [[nodiscard]] Words states_of_plan() {
    std::vector<Pending> pending;
    for (const Words& piece : pieces_of(system_.start_state())) {
      const bool completing = piece == first_piece_;
      const Role role = !completing ? Role::Inside : completes_first_ ? Role::First : Role::Last;
      pending.push_back(best_step(piece, role));
    }
    Words states(system_.start_state().begin(), system_.start_state().end());
    Words next(system_.words());
    while (!pending.empty() && result_.stop == Stop::None) {
      // The one that completes at its time, the others as they can, small pieces first.
      std::ranges::stable_sort(pending, [](const Pending& a, const Pending& b) {
        if (a.role != b.role) return a.role < b.role;
        return count(a.piece) < count(b.piece);
      });
      const SetView now = SetView(states).last(system_.words());
      const auto step = std::ranges::find_if(pending, [&](const Pending& candidate) {
        const bool ends = candidate.role == Role::Last && candidate.children.empty();
        if (ends && pending.size() > 1) return false;
        for (std::size_t w = 0; w < next.size(); ++w)
          next[w] = now[w] & ~(candidate.piece[w] & ~candidate.left[w]);
        return expander_.leads_to(now, next);
      });
      if (step == pending.end() || (pending.front().role == Role::First && step != pending.begin()))
        return {};
      const Pending taken = std::move(*step);
      pending.erase(step);
      states.insert(states.end(), next.begin(), next.end());
      for (std::size_t i = 0; i < taken.children.size(); ++i) {
        const bool last = taken.role == Role::Last && i == taken.last_child;
        pending.push_back(best_step(taken.children[i], last ? Role::Last : Role::Inside));
      }
    }
    return result_.stop == Stop::None ? states : Words();
  }

 private:
  /// Where the step that completes stands: it is the first step of all and of this piece; not in
  /// this piece; it is the last step of all and of this piece.
  enum class Role : std::uint64_t { First, Inside, Last };

  /// A piece with the step that is best for it.
  struct Pending {
    Words piece;
    Role role = Role::Inside;
    Words left;  ///< its connections after the step
    std::vector<Words> children{};
    std::size_t last_child = 0;  ///< Role::Last: the child that has this role
    double value = -kInfinity;
  };

  void note_bytes() {
    result_.statistics.peak_bytes = std::max(result_.statistics.peak_bytes, bytes());
  }
  [[nodiscard]] std::uint64_t bytes() const { return table_.bytes() + value_.bytes() + held_; }

  /// The pieces among these connections, each as the connections among its parts.
  [[nodiscard]] std::vector<Words> pieces_of(SetView open) const {
    std::vector<Words> pieces;
    std::vector<std::size_t> piece_of(system_.problem().num_parts());
    std::size_t number = 0;
    system_.rules().graph.for_each_piece(open, [&](std::span<const PartIndex> parts) {
      for (const PartIndex part : parts) piece_of[part] = number;
      ++number;
    });
    std::vector<std::size_t> place(number, number);
    for_each_connection(open, [&](ConnectionIndex c) {
      std::size_t& mine = place[piece_of[system_.problem().ends(c)[0]]];
      if (mine == number) {
        mine = pieces.size();
        pieces.emplace_back(system_.words(), 0);
      }
      pieces[mine][c / 64] |= std::uint64_t{1} << (c % 64);
    });
    return pieces;
  }

  /// What the steps of a piece earn, and the states that they leave of it, one after another.
  struct Choices {
    std::vector<double> rewards;
    Words left;
  };
  Choices choices_of(const Words& piece, Role role) {
    Choices choices;
    std::span<const Action> actions;
    try {
      actions = expander_.piece_steps(piece, role != Role::Inside);
    } catch (const ListingStopped& stopped) {
      result_.stop = listing_.reason(stopped);
      return choices;
    }
    ++result_.statistics.expanded;
    choices.left.resize(actions.size() * piece.size());
    for (std::size_t i = 0; i < actions.size(); ++i) {
      choices.rewards.push_back(actions[i].reward);
      expander_.successor(piece, actions[i],
                          std::span(choices.left).subspan(i * piece.size(), piece.size()));
    }
    return choices;
  }

  /// What a step leads to: what it earns with what is best for all that it leaves.
  Pending weighed(const Words& piece, Role role, double reward, SetView left) {
    Pending step{.piece = piece, .role = role, .left = {left.begin(), left.end()}};
    step.children = pieces_of(left);
    step.value = reward;
    ++result_.statistics.generated;
    if (role != Role::Last || step.children.empty()) {
      for (const Words& child : step.children) step.value += value_of(child, Role::Inside);
      return step;
    }
    if (step.children.size() == 1) {
      step.value += value_of(step.children.front(), Role::Last);
      return step;
    }
    double surplus = -kInfinity;
    for (std::size_t i = 0; i < step.children.size() && step.value > -kInfinity; ++i) {
      const double inside = value_of(step.children[i], Role::Inside);
      step.value += inside;
      const double more = value_of(step.children[i], Role::Last) - inside;
      if (inside == -kInfinity || more <= surplus) continue;
      surplus = more;
      step.last_child = i;
    }
    step.value += surplus;
    return step;
  }

  Pending best_step(const Words& piece, Role role) {
    const Choices choices = choices_of(piece, role);
    Pending best{.piece = piece, .role = role, .left = piece};
    for (std::size_t i = 0; i < choices.rewards.size(); ++i) {
      Pending step = weighed(piece, role, choices.rewards[i],
                             SetView(choices.left).subspan(i * piece.size(), piece.size()));
      if (step.value > best.value) best = std::move(step);
    }
    return best;
  }

  double value_of(const Words& piece, Role role) {
    if (result_.stop != Stop::None) return 0;
    Words key = piece;
    key.push_back(static_cast<std::uint64_t>(role));
    const std::uint32_t known = table_.find(key.data());
    if (known != StateTable<0>::kAbsent) return value_[known];
    poll();
    const Choices choices = choices_of(piece, role);
    const std::uint64_t mine =
        choices.rewards.capacity() * sizeof(double) + choices.left.capacity() * sizeof(Words);
    held_ += mine;
    double best = -kInfinity;
    for (std::size_t i = 0; i < choices.rewards.size() && result_.stop == Stop::None; ++i) {
      const SetView left = SetView(choices.left).subspan(i * piece.size(), piece.size());
      best = std::max(best, weighed(piece, role, choices.rewards[i], left).value);
    }
    held_ -= mine;
    if (result_.stop != Stop::None) return 0;
    table_.insert(key.data());
    value_.push_back(best);
    return best;
  }

  void poll() {
    constexpr std::uint64_t kPollEvery = 64;
    if (result_.statistics.expanded >= budget_.max_expansions) result_.stop = Stop::ExpansionLimit;
    if (result_.statistics.expanded % kPollEvery != 0) return;
    note_bytes();
    result_.stop = bytes() > allowed_ ? Stop::MemoryLimit
                                      : budget_.expired(bytes(), result_.statistics.expanded);
    budget_.report(
        {.phase = "search", .done = result_.statistics.expanded, .states = table_.size()});
  }

  const TransitionSystem& system_;
  const Budget& budget_;
  std::uint64_t allowed_;
  Result& result_;
  ListingWatch listing_;
  Expander expander_;
  bool completes_first_;
  /// The pieces that were looked at, each with a role in a last word, and what they are worth.
  StateTable<0> table_;
  GrowingArray<double> value_;
  /// Bytes of the steps of the pieces that are being looked at.
  std::uint64_t held_ = 0;
  /// Of the start, the piece in which the step that completes stands.
  Words first_piece_;
};

/// The best plan of a system whose steps take parts off, with what bounds all of them.
Result best_tree(const TransitionSystem& system, const Budget& budget) {
  Result result;
  result.method = "and-or";
  result.stop = budget.expired();
  if (result.stop != Stop::None) return result;
  PartTrees trees(system, budget, result);
  const double most = trees.run();
  if (result.stop != Stop::None) return result;
  if (most == -kInfinity) return exhausted("and-or", result.statistics);
  result.bound = most;
  const Words states = trees.states_of_plan();
  if (states.empty()) return result;
  const ListingScope as_before(system, {.most = system.rules().listing.most});
  take_walk(Expander(system).steps_along(states), result);
  judge_by(most, result);
  return result;
}

}  // namespace

bool takes_part_trees(const TransitionSystem& system) {
  const Rules& rules = system.rules();
  return rules.by_part && !rules.has_goal && !rules.may_stop && !system.looks_back();
}

Result part_trees(const TransitionSystem& system, const Budget& budget) {
  const Stopwatch watch;
  Result result;
  if (system.takes_apart()) {
    result = best_tree(system, budget);
  } else {
    const TransitionSystem backwards = system.backwards();
    Result found = best_tree(backwards, budget);
    Result without_plan = found;
    if (found.has_plan()) without_plan.status = Status::Unknown;
    without_plan.sequence.clear();
    without_plan.steps.clear();
    without_plan.reward = -kInfinity;
    result = turned_round(system, std::move(found));
    if (!result.has_plan()) result = std::move(without_plan);
  }
  if (!result.has_plan() && result.status != Status::Infeasible) {
    const std::optional<double> most = result.bound;
    result = stopped_with_quick_plan(system, "and-or", result.stop, result.statistics);
    WideBound bound(system);
    if (most) {
      result.bound = most;
    } else if (bound.known()) {
      result.bound = bound(system.start_state());
    }
    if (result.has_plan()) judge_by(result.bound, result);
  }
  result.statistics.seconds = watch.seconds();
  return result;
}

}  // namespace orasp::detail
