#include "orasp/planners/feasibility.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "orasp/model/detail/connectivity.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/depth_first_plan.h"
#include "orasp/planners/detail/wide_search.h"

namespace orasp {

namespace {

constexpr std::string_view kMethod = "feasibility";

// What prepared() makes a step earn tells what it cuts: nothing 0, two larger pieces -2, at least
// one single part -5 or -8.
constexpr double kSingle = 4;
constexpr double kLarger = 1;
constexpr double kCuts = -1.5;
constexpr double kCutsSingle = -4.5;

/// The greatest reward of a step that can do no harm.
double greatest_of_harmless(const Problem& problem) {
  switch (harmless_steps(problem)) {
    case Harmless::SingleCuts: return kCutsSingle;
    case Harmless::Cuts: return kCuts;
    case Harmless::All: return 0;
    default: return -kInfinity;
  }
}

/// Puts actions into an order in which a plan is soon met: first those of a part that may leave its
/// piece alone, of such parts one with few connections. One part after the other is then freed and
/// taken off, where connections taken at random soon leave pieces that can only move together.
class PartsFirst {
 public:
  explicit PartsFirst(const TransitionSystem& system)
      : system_(system), graph_(system.problem()), expander_(system) {}

  void order(SetView open, std::span<Action> actions) {
    const Problem& problem = system_.problem();
    if (problem.num_parts() > kMostParts) return;
    rank_.assign(problem.num_parts(), kNever);
    graph_.for_each_piece(system_.present(open).view(), [&](std::span<const PartIndex> piece) {
      for (std::size_t i = 0; i < piece.size() && piece.size() > 1; ++i) rank(open, piece, i);
    });
    std::ranges::stable_sort(actions, {}, [&](const Action& action) {
      const auto& ends = problem.ends(action.connection);
      return std::min(rank_[ends[0]], rank_[ends[1]]);
    });
  }

 private:
  static constexpr std::size_t kMostParts = 512;
  static constexpr std::size_t kNever = std::numeric_limits<std::size_t>::max();

  void rank(SetView open, std::span<const PartIndex> piece, std::size_t i) {
    rest_.assign(piece.begin(), piece.end());
    rest_.erase(rest_.begin() + static_cast<std::ptrdiff_t>(i));
    std::size_t degree = 0;
    ConnectionIndex last = 0;
    for (const auto& half : graph_.around(piece[i])) {
      if (system_.kept().contains(half.connection)) return;
      if (!contains(open, half.connection)) continue;
      ++degree;
      last = half.connection;
    }
    if (degree > 0 && expander_.cut_gain(piece.subspan(i, 1), rest_, last))
      rank_[piece[i]] = degree;
  }

  const TransitionSystem& system_;
  detail::AssemblyGraph graph_;
  Expander expander_;
  std::vector<std::size_t> rank_;  ///< by part
  std::vector<PartIndex> rest_;
};

/// `system` takes the problem apart.
Feasibility search(const TransitionSystem& system, const Budget& budget) {
  if (system.wide()) {
    Result result = detail::wide_greedy(system, budget);
    Feasibility found;
    found.status = result.has_plan() ? Status::Feasible : result.status;
    found.stop = result.stop;
    found.order = std::move(result.sequence);
    found.steps = std::move(result.steps);
    found.expanded = result.statistics.expanded;
    return found;
  }
  const double threshold = greatest_of_harmless(system.problem());
  const ConnectionSet none(system.num_connections());
  std::optional<PartsFirst> parts_first;  // often nothing asks for it
  Result result = detail::depth_first_search(
      system, system.start(), none, budget, kMethod,
      [&](SetView open, std::span<Action> actions) -> std::size_t {
        const auto safe = std::ranges::find_if(
            actions, [&](const Action& action) { return action.reward <= threshold; });
        if (safe != actions.end()) {
          std::swap(actions.front(), *safe);
          return 1;
        }
        std::ranges::stable_sort(actions, {}, &Action::reward);  // cuts first
        if (!parts_first) parts_first.emplace(system);
        parts_first->order(open, actions);
        return actions.size();
      });
  Feasibility found;
  found.status = result.has_plan() ? Status::Feasible : result.status;
  found.stop = result.stop;
  found.order = std::move(result.sequence);
  found.expanded = result.statistics.expanded;
  return found;
}

/// An objective whose rewards tell what a step cuts.
Problem prepared(ProblemSpec spec) {
  PieceCost cost;
  cost.pieces[1] = kSingle;
  for (std::size_t parts = 2; parts <= std::max<std::size_t>(2, spec.parts.size()); ++parts)
    cost.pieces[parts] = kLarger;
  // The step that completes is the last one of a disassembly, which can do no harm, and the first
  // one of an assembly backwards, of which nothing is said.
  cost.completion = spec.direction == Direction::Disassembly ? 2 * -kSingle : 0;
  spec.objective = Objective("piece_cost", cost);
  return Problem(std::move(spec));
}

}  // namespace

Harmless harmless_steps(const Problem& problem) {
  // A connection that another one needs must not go early.
  if (std::ranges::any_of(problem.precedence(), [](const PrecedenceClause& clause) {
        return !clause.made_after_any.empty();
      }))
    return Harmless::None;
  const Limits& limits = problem.limits();
  const bool blocking =
      std::ranges::any_of(problem.blockers(), [](const auto& list) { return !list.empty(); });
  if (!blocking && !limits.any()) return Harmless::All;
  // A base part that is taken off leaves pieces that then move.
  if (problem.spec().base.size() > 1) return Harmless::None;
  const bool equal_masses = std::ranges::all_of(
      problem.parts(), [&](const Part& part) { return part.mass == problem.parts().front().mass; });
  if (limits.max_moved_mass && !equal_masses) return Harmless::None;
  const bool counts =
      limits.max_subassemblies && *limits.max_subassemblies < problem.num_parts() / 2;
  return counts ? Harmless::SingleCuts : Harmless::Cuts;
}

Feasibility find_order(const Problem& problem, const ConnectionSet& from, const ConnectionSet& to,
                       const Budget& budget) {
  const Problem plain = prepared(problem.spec());
  const std::size_t connections = problem.num_connections();
  const auto search_unless_locked = [&](const TransitionSystem& system) {
    return system.locked_pair() ? Feasibility{.status = Status::Infeasible}
                                : search(system, budget);
  };
  Situation now = Situation::whole(connections);
  if (problem.direction() == Direction::Disassembly) {
    now.open = from;
    now.inaccessible = to;
    return search_unless_locked(TransitionSystem(plain, now));
  }
  for (ConnectionIndex c = 0; c < connections; ++c) {
    if (to.contains(c)) now.open.erase(c);
    if (!from.contains(c)) now.inaccessible.insert(c);
  }
  return search_unless_locked(TransitionSystem(plain, now).backwards());
}

Feasibility find_order(ProblemSpec spec, const Budget& budget) {
  spec.direction = Direction::Disassembly;
  const Problem plain = prepared(std::move(spec));
  const TransitionSystem system(plain);
  Feasibility found;
  if (system.infeasibility()) {
    found.status = Status::Infeasible;
    return found;
  }
  return search(system, budget);
}

}  // namespace orasp
