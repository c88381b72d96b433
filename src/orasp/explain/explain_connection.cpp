#include "orasp/explain/explain_connection.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "orasp/containers/state_table.h"
#include "orasp/model/detail/wording.h"
#include "orasp/planners/feasibility.h"

namespace orasp {

namespace {

using detail::quoted_list;

/// How many states each search for a later chance may look at.
constexpr std::uint64_t kStatesBreadthFirst = 20'000;
constexpr std::uint64_t kStatesDepthFirst = 200'000;

std::vector<BlockedDirection> blocked_directions(const Problem& problem, const Step& step) {
  std::vector<char> moved(problem.num_parts(), 0);
  std::vector<char> stays(problem.num_parts(), 0);
  for (const PartIndex part : step.moved()) moved[part] = 1;
  for (const PartIndex part : step.kept()) stays[part] = 1;
  struct Parts {
    std::set<PartIndex> blocked;
    std::set<PartIndex> in_the_way;
    std::set<std::size_t> entries;
    double width = 0;
    bool measured = true;  ///< every entry states its width
  };
  std::map<DirectionIndex, Parts> along;
  const auto& entries = problem.spec().blocking->blocked;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const PartIndex part = problem.find_part(entries[i].part, "");
    const PartIndex by = problem.find_part(entries[i].by, "");
    const bool forward = moved[part] != 0 && stays[by] != 0;
    const bool backward = moved[by] != 0 && stays[part] != 0;
    if (!forward && !backward) continue;
    for (std::size_t d = 0; d < entries[i].directions.size(); ++d) {
      const DirectionIndex direction = *problem.find_direction(entries[i].directions[d]);
      Parts& found = along[forward ? direction : opposite(direction)];
      if (entries[i].widths.empty())
        found.measured = false;
      else
        found.width = std::max(found.width, entries[i].widths[d]);
      found.blocked.insert(forward ? part : by);
      found.in_the_way.insert(forward ? by : part);
      found.entries.insert(i);
    }
  }
  std::vector<BlockedDirection> directions;
  for (const auto& [direction, found] : along) {
    directions.push_back({.direction = problem.direction_name(direction),
                          .moved = {found.blocked.begin(), found.blocked.end()},
                          .in_the_way = {found.in_the_way.begin(), found.in_the_way.end()},
                          .entries = {found.entries.begin(), found.entries.end()},
                          .width = found.measured ? std::optional(found.width) : std::nullopt});
  }
  std::ranges::stable_sort(directions, {}, [](const BlockedDirection& direction) {
    return std::pair(direction.in_the_way.size(), direction.entries.size());
  });
  return directions;
}

/// The number of pieces of two or more parts while the connection of the step is absent, which is
/// what max_subassemblies limits.
std::size_t subassemblies_apart(const Problem& problem, const Step& step) {
  if (problem.direction() == Direction::Disassembly) return step.subassemblies;
  return step.subassemblies - 1 + std::size_t{step.a.size() >= 2} + std::size_t{step.b.size() >= 2};
}

Remedy remedy_for(const Problem& problem, const Violation& violation, const Step& step) {
  const bool assembly = problem.direction() == Direction::Assembly;
  Remedy remedy;
  remedy.constraint = violation.constraint;
  remedy.where = violation.where;
  const auto ids = [&](const auto& items, const auto& name) {
    std::vector<std::string> list;
    for (const auto item : items) list.push_back(name(item));
    return list;
  };
  const auto connection = [&](ConnectionIndex c) { return problem.connection_id(c); };
  const auto part = [&](PartIndex p) { return problem.part_id(p); };
  const auto allow = [&](double least, const std::string& text) {
    remedy.least = least;
    remedy.message = "a limit of " + text + " would allow it";
  };
  switch (violation.constraint) {
    case Constraint::Precedence:
    case Constraint::PrecedenceAny:
    case Constraint::PrecedenceMadeAny: {
      const bool any = violation.constraint != Constraint::Precedence;
      const std::string names =
          quoted_list(ids(violation.blocking_connections, connection), any ? "or" : "and");
      if (std::ranges::find(violation.blocking_connections, step.connection) !=
          violation.blocking_connections.end()) {
        remedy.first = violation.blocking_connections;
        remedy.message = "the entry makes it wait for itself; take that out";
      } else if (violation.too_late) {
        remedy.message = "it is too late: it had to be made before " + names;
      } else {
        remedy.first = violation.blocking_connections;
        remedy.message = (assembly ? "make first " : "remove first ") + names;
      }
      break;
    }
    case Constraint::MaxSubassemblies: {
      const std::size_t least = subassemblies_apart(problem, step);
      allow(static_cast<double>(least), std::to_string(least));
      break;
    }
    case Constraint::MaxMovedParts:
      allow(static_cast<double>(step.moved().size()), std::to_string(step.moved().size()));
      break;
    case Constraint::MaxMovedMass:
      allow(step.moved_mass, detail::number_text(step.moved_mass) + " kg");
      break;
    case Constraint::Grounded:
      remedy.message = "a base part would have to be in each subassembly";
      break;
    case Constraint::Blocking: {
      remedy.directions = blocked_directions(problem, step);
      const BlockedDirection& best = remedy.directions.front();
      remedy.message = "fewest parts are in the way along " + best.direction + ": " +
                       quoted_list(ids(best.in_the_way, part), "and") + " in the way of " +
                       quoted_list(ids(best.moved, part), "and") + " (";
      for (std::size_t i = 0; i < best.entries.size(); ++i)
        remedy.message +=
            (i > 0 ? ", " : "") + ("blocking.blocked[" + std::to_string(best.entries[i]) + "]");
      if (best.width) remedy.message += ", " + width_text(*problem.spec().blocking, *best.width);
      remedy.message += ")";
      break;
    }
    case Constraint::Inaccessible: remedy.message = "it would have to be accessible again"; break;
    case Constraint::NotNext: remedy.message = "it may be a later step"; break;
    case Constraint::Late:
      remedy.first = violation.blocking_connections;
      remedy.message = "what does not wait for the part comes first";
      break;
    case Constraint::Goal:
    case Constraint::NotOneStep: break;  // of plans, not of a connection
    case Constraint::NotOpen: remedy.message = "it is not there to be handled again"; break;
  }
  return remedy;
}

/// Finds the fewest other steps after which the connection is legal, breadth first.
void search_breadth_first(const TransitionSystem& system, const ConnectionSet& open,
                          ConnectionIndex connection, const Budget& budget,
                          ConnectionExplanation& explanation) {
  struct Origin {
    std::uint32_t parent;
    ConnectionIndex step;
  };
  Expander expander(system);
  detail::StateTable<0> states(system.open_words());
  std::vector<Origin> origins;
  states.insert(open.view().data());
  origins.push_back({0, 0});
  for (std::uint32_t s = 0; s < states.size(); ++s) {
    if (s % 64 == 0 && budget.expired(states.bytes()) != Stop::None) return;
    ConnectionSet state(system.num_connections(), SetView{states.key(s), system.open_words()});
    const auto actions = expander.legal_actions(state.view());
    if (std::ranges::find(actions, connection, &Action::connection) != actions.end()) {
      explanation.later = ConnectionExplanation::Later::Legal;
      explanation.fewest = true;
      for (std::uint32_t at = s; at != 0; at = origins[at].parent)
        explanation.after.push_back(origins[at].step);
      std::ranges::reverse(explanation.after);
      return;
    }
    for (const Action& action : actions) {
      state.erase(action.connection);
      if (states.insert(state.view().data()).is_new) origins.push_back({s, action.connection});
      state.insert(action.connection);
      if (states.size() > kStatesBreadthFirst) return;
    }
  }
  explanation.later = ConnectionExplanation::Later::Never;
}

/// A legal order from `open` to the end (disassembly: nothing present, assembly: everything), as
/// steps of the problem's direction.
Feasibility order_from(const Problem& problem, const ConnectionSet& open, const Budget& budget) {
  Budget share = budget;
  share.progress = nullptr;
  share.max_expansions = std::min(budget.max_expansions, kStatesDepthFirst);
  const std::size_t connections = problem.num_connections();
  if (problem.direction() == Direction::Disassembly)
    return find_order(problem, open, ConnectionSet(connections), share);
  ConnectionSet present = ConnectionSet::all(connections);
  for_each_connection(open.view(), [&](ConnectionIndex c) { present.erase(c); });
  Feasibility found = find_order(problem, ConnectionSet::all(connections), present, share);
  std::ranges::reverse(found.order);
  return found;
}

/// How many of `steps` lead to the first state in which `connection` is legal; empty where they
/// end, or are not legal themselves, before that.
std::optional<std::size_t> steps_until_legal(Expander& expander, ConnectionSet state,
                                             std::span<const ConnectionIndex> steps,
                                             ConnectionIndex connection) {
  for (std::size_t i = 0; i <= steps.size(); ++i) {
    if (expander.legal(state.view(), connection)) return i;
    if (i == steps.size() || !expander.legal(state.view(), steps[i])) break;
    state.erase(steps[i]);
  }
  return std::nullopt;
}

/// Follows some plan up to where the connection is legal, and leaves out what it can of its steps.
void search_depth_first(const Problem& problem, const TransitionSystem& system,
                        const ConnectionSet& open, ConnectionIndex connection, const Budget& budget,
                        ConnectionExplanation& explanation) {
  std::vector<ConnectionIndex> steps = order_from(problem, open, budget).order;
  Expander expander(system);
  const auto reached = steps_until_legal(expander, open, steps, connection);
  if (!reached) return;
  steps.resize(*reached);
  // Leaving a step out is tried by replaying the others: as often as a second or so allows.
  constexpr std::size_t kWork = 200'000'000;
  const std::size_t work_of_step = problem.num_parts() + problem.num_connections();
  std::size_t work = 0;
  for (std::size_t i = steps.size(); i-- > 0 && budget.expired() == Stop::None;) {
    work += 2 * steps.size() * work_of_step;
    if (work > kWork) break;
    std::vector<ConnectionIndex> fewer = steps;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
    const auto still = steps_until_legal(expander, open, fewer, connection);
    if (!still) continue;
    fewer.resize(*still);
    steps = std::move(fewer);
    i = std::min(i, steps.size());
  }
  explanation.later = ConnectionExplanation::Later::Legal;
  explanation.after = std::move(steps);
}

}  // namespace

std::string width_text(const Blocking& blocking, double width) {
  constexpr double kMillimetres = 1000;
  std::string text = detail::rounded_text(kMillimetres * width) + " mm wide";
  if (blocking.is_near_tolerance(width))
    text += ", near the tolerance of " + detail::rounded_text(kMillimetres * blocking.tolerance) +
            " mm";
  return text;
}

ConnectionExplanation explain_connection(const Problem& problem, const ConnectionSet& open,
                                         ConnectionIndex connection, const Budget& budget) {
  const TransitionSystem system(problem);
  Expander expander(system);
  ConnectionExplanation explanation;
  explanation.violations = expander.violations(open.view(), connection);
  explanation.legal = explanation.violations.empty();
  if (explanation.legal) {
    ConnectionSet next = open;
    next.erase(connection);
    const Feasibility found = system.infeasibility() ? Feasibility{.status = Status::Infeasible}
                                                     : order_from(problem, next, budget);
    if (found.status != Status::Unknown) explanation.plan_exists = found.status == Status::Feasible;
    return explanation;
  }
  if (!open.contains(connection)) {
    explanation.later = ConnectionExplanation::Later::Never;
    explanation.remedies.push_back(remedy_for(problem, explanation.violations.front(), {}));
    return explanation;
  }
  const Step step = expander.step(open.view(), connection);
  for (const Violation& violation : explanation.violations)
    explanation.remedies.push_back(remedy_for(problem, violation, step));
  search_breadth_first(system, open, connection, budget, explanation);
  if (explanation.later == ConnectionExplanation::Later::Unknown &&
      budget.expired() == Stop::None) {
    search_depth_first(problem, system, open, connection, budget, explanation);
  }
  return explanation;
}

}  // namespace orasp
