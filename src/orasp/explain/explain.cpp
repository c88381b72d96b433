#include "orasp/explain/explain.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <set>
#include <span>
#include <tuple>
#include <utility>

#include "orasp/containers/state_table.h"
#include "orasp/model/detail/wording.h"
#include "orasp/planners/feasibility.h"
#include "orasp/planners/greedy.h"

namespace orasp {

namespace {

using detail::in_quotes;

// -------------------------------------------------------------------------------------------------
// What can be dropped

enum class Kind { After, AfterAny, Subassemblies, MovedParts, MovedMass, Blocked, Inaccessible };

/// The least that can be dropped: a limit, one id of an `after`, a whole `after_any` (of which
/// fewer ids ask for more), one direction of an entry of `blocked`, one inaccessible connection.
struct Atom {
  Kind kind;
  std::size_t entry = 0;
  std::size_t member = 0;  ///< After, Inaccessible: the connection; Blocked: the direction

  [[nodiscard]] friend auto operator<=>(const Atom&, const Atom&) = default;
};

/// Atoms that are dropped together, or kept.
using Unit = std::vector<Atom>;
using Units = std::vector<Unit>;

std::vector<Atom> atoms_of(const Problem& problem, const ConnectionSet& kept) {
  std::vector<Atom> atoms;
  for (const PrecedenceClause& clause : problem.precedence()) {
    for (const ConnectionIndex c : clause.after) atoms.push_back({Kind::After, clause.entry, c});
    if (!clause.after_any.empty()) atoms.push_back({Kind::AfterAny, clause.entry, 0});
  }
  const Limits& limits = problem.limits();
  if (limits.max_subassemblies) atoms.push_back({Kind::Subassemblies});
  if (limits.max_moved_parts) atoms.push_back({Kind::MovedParts});
  if (limits.max_moved_mass) atoms.push_back({Kind::MovedMass});
  if (const auto& blocking = problem.spec().blocking) {
    for (std::size_t i = 0; i < blocking->blocked.size(); ++i) {
      std::set<std::size_t> directions;
      for (const std::string& name : blocking->blocked[i].directions) {
        const auto found = std::ranges::find(kDirectionNames, name);
        directions.insert(static_cast<std::size_t>(found - kDirectionNames.begin()));
      }
      for (const std::size_t d : directions) atoms.push_back({Kind::Blocked, i, d});
    }
  }
  for_each_connection(kept.view(), [&](ConnectionIndex c) {
    atoms.push_back({Kind::Inaccessible, c, c});
  });
  return atoms;
}

/// Joined where `same(a, b)` holds of neighbours.
template <class Same>
Units units_of(std::span<const Atom> atoms, Same&& same) {
  Units units;
  for (const Atom& atom : atoms) {
    if (units.empty() || !same(units.back().back(), atom)) units.emplace_back();
    units.back().push_back(atom);
  }
  return units;
}

bool is_precedence(Kind kind) {
  return kind == Kind::After || kind == Kind::AfterAny;
}

bool same_group(const Atom& a, const Atom& b) {
  return a.kind == b.kind || (is_precedence(a.kind) && is_precedence(b.kind));
}

bool same_entry(const Atom& a, const Atom& b) {
  return same_group(a, b) && a.entry == b.entry;
}

/// The problem with no constraints but `units`.
ProblemSpec reduced(const Problem& problem, const Units& units) {
  const ProblemSpec& whole = problem.spec();
  ProblemSpec spec;
  spec.parts = whole.parts;
  spec.connections = whole.connections;
  if (whole.blocking) spec.blocking = Blocking{whole.blocking->directions, {}};
  std::vector<Atom> atoms;
  for (const Unit& unit : units) atoms.insert(atoms.end(), unit.begin(), unit.end());
  std::ranges::sort(atoms);
  for (const Atom& atom : atoms) {
    switch (atom.kind) {
      case Kind::After:
        spec.precedence.push_back(
            {whole.precedence[atom.entry].connection,
             {problem.connection_id(static_cast<ConnectionIndex>(atom.member))},
             {}});
        break;
      case Kind::AfterAny: {
        const Precedence& entry = whole.precedence[atom.entry];
        spec.precedence.push_back({entry.connection, {}, entry.after_any});
        break;
      }
      case Kind::Subassemblies:
        spec.limits.max_subassemblies = whole.limits.max_subassemblies;
        break;
      case Kind::MovedParts: spec.limits.max_moved_parts = whole.limits.max_moved_parts; break;
      case Kind::MovedMass: spec.limits.max_moved_mass = whole.limits.max_moved_mass; break;
      case Kind::Inaccessible: break;  // not the problem's own
      case Kind::Blocked: {
        const Blocked& entry = whole.blocking->blocked[atom.entry];
        spec.blocking->blocked.push_back({entry.part, entry.by, {kDirectionNames[atom.member]}});
        break;
      }
    }
  }
  return spec;
}

/// Whether precedence atoms alone can be met: connections go as soon as nothing holds them.
/// O(connections + ids).
bool precedence_can_be_met(const Problem& problem, std::span<const Atom> atoms) {
  const std::size_t connections = problem.num_connections();
  std::vector<std::size_t> waits(connections, 0);              // atoms that still hold a connection
  std::vector<std::vector<std::size_t>> waiting(connections);  // atoms that look at a connection
  for (std::size_t i = 0; i < atoms.size(); ++i) {
    const PrecedenceClause& clause = problem.precedence()[atoms[i].entry];
    ++waits[clause.connection];
    if (atoms[i].kind == Kind::After) {
      waiting[atoms[i].member].push_back(i);
    } else {
      for (const ConnectionIndex c : clause.after_any) waiting[c].push_back(i);
    }
  }
  std::vector<bool> met(atoms.size(), false);
  std::vector<std::size_t> gone;
  for (std::size_t c = 0; c < connections; ++c) {
    if (waits[c] == 0) gone.push_back(c);
  }
  for (std::size_t next = 0; next < gone.size(); ++next) {
    for (const std::size_t i : waiting[gone[next]]) {
      if (met[i]) continue;
      met[i] = true;
      const ConnectionIndex c = problem.precedence()[atoms[i].entry].connection;
      if (--waits[c] == 0) gone.push_back(c);
    }
  }
  return gone.size() == connections;
}

// -------------------------------------------------------------------------------------------------
// Finding the conflict

/// An order, in disassembly, of what is left to do under the constraints of `problem`, where only
/// `kept` stays.
Feasibility find_order_left(const Problem& problem, const TransitionSystem& system,
                            const ConnectionSet& kept, const Budget& budget) {
  ConnectionSet left(problem.num_connections());  // all that is open, but for `kept`
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    if ((system.start().contains(c) || system.kept().contains(c)) && !kept.contains(c))
      left.insert(c);
  }
  ConnectionSet from = left;
  ConnectionSet to(problem.num_connections());
  const bool assembly = system.problem().direction() == Direction::Assembly;
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const bool made = !system.start().contains(c) && !system.kept().contains(c);
    if (left.contains(c) || !(assembly ? made : kept.contains(c))) continue;
    from.insert(c);
    to.insert(c);
  }
  return find_order(problem, from, to, budget);
}

class ConflictFinder {
 public:
  ConflictFinder(const TransitionSystem& system, const Budget& budget,
                 ProblemExplanation& explanation)
      : system_(system), problem_(system.problem()), budget_(budget), explanation_(explanation) {}

  /// Whether no plan exists under `units`: proved. What is not decided counts as no.
  [[nodiscard]] bool conflicts(const Units& units) {
    Stop stop = budget_.expired();
    if (stop == Stop::None) {
      ++explanation_.tests;
      budget_.report({.phase = "test", .done = explanation_.tests});
      std::vector<Atom> atoms;
      for (const Unit& unit : units) atoms.insert(atoms.end(), unit.begin(), unit.end());
      const auto is_of_precedence = [](const Atom& atom) { return is_precedence(atom.kind); };
      if (system_.whole() &&
          std::ranges::all_of(atoms, is_of_precedence))  // nothing judges cuts: nothing to search
        return !precedence_can_be_met(problem_, atoms);
      Budget share = budget_;
      share.progress = nullptr;
      share.max_expansions = kTestExpansions;
      const Feasibility found = order_under(units, atoms, share);
      if (found.status == Status::Infeasible) return true;
      if (found.status == Status::Feasible) return false;
      stop = found.stop;
    }
    explanation_.minimal = false;
    explanation_.stop = stop;
    undecided_ = true;
    return false;
  }

  /// What is left of `units`, which conflict, when each that is not needed is dropped, one after
  /// the other, and which of them are proved to be needed.
  [[nodiscard]] std::pair<Units, Units> filtered(Units units) {
    Units needed;
    Units unsure;
    while (!units.empty()) {
      const Unit candidate = std::move(units.back());
      units.pop_back();
      Units others = units;
      others.insert(others.end(), needed.begin(), needed.end());
      others.insert(others.end(), unsure.begin(), unsure.end());
      undecided_ = false;
      if (conflicts(others)) continue;
      (undecided_ ? unsure : needed).push_back(candidate);
    }
    return {needed, unsure};
  }

  /// QuickXplain: those of `candidates` that are needed beside `background`, given that both
  /// together conflict. `grown`: something was added to the background since it was last tested.
  [[nodiscard]] Units halved(const Units& background, bool grown, const Units& candidates) {
    if (grown && conflicts(background)) return {};
    if (candidates.size() <= 1) return candidates;
    const auto middle = candidates.begin() + static_cast<std::ptrdiff_t>(candidates.size() / 2);
    const Units first(candidates.begin(), middle);
    const Units second(middle, candidates.end());
    const Units of_second = halved(joined(background, first), true, second);
    const Units of_first = halved(joined(background, of_second), !of_second.empty(), first);
    return joined(of_first, of_second);
  }

  [[nodiscard]] static Units joined(const Units& a, const Units& b) {
    Units both = a;
    both.insert(both.end(), b.begin(), b.end());
    return both;
  }

 private:
  /// Enough for what a person may hope to understand.
  static constexpr std::uint64_t kTestExpansions = 100'000;

  /// An order of what is left to do, in disassembly, under `units` alone.
  [[nodiscard]] Feasibility order_under(const Units& units, std::span<const Atom> atoms,
                                        const Budget& budget) const {
    if (system_.whole()) return find_order(reduced(problem_, units), budget);
    ConnectionSet kept(problem_.num_connections());
    for (const Atom& atom : atoms) {
      if (atom.kind == Kind::Inaccessible) kept.insert(static_cast<ConnectionIndex>(atom.member));
    }
    return find_order_left(Problem(reduced(problem_, units)), system_, kept, budget);
  }

  const TransitionSystem& system_;
  const Problem& problem_;
  const Budget& budget_;
  ProblemExplanation& explanation_;
  bool undecided_ = false;
};

std::vector<Atom> atoms_in(const Units& units) {
  std::vector<Atom> atoms;
  for (const Unit& unit : units) atoms.insert(atoms.end(), unit.begin(), unit.end());
  std::ranges::sort(atoms, [](const Atom& a, const Atom& b) {
    const auto key = [](const Atom& atom) {
      return std::tuple(is_precedence(atom.kind) ? Kind::After : atom.kind, atom.entry, atom.kind,
                        atom.member);
    };
    return key(a) < key(b);
  });
  return atoms;
}

std::string quoted_list(const std::vector<std::string>& ids, std::string_view last) {
  std::string text;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (i > 0) text += i + 1 == ids.size() ? " " + std::string(last) + " " : ", ";
    text += in_quotes(ids[i]);
  }
  return text;
}

ConflictItem described(const Problem& problem, const Unit& unit,
                       const std::optional<Violation>& at_once) {
  const ProblemSpec& spec = problem.spec();
  const bool assembly = problem.direction() == Direction::Assembly;
  const Atom& first = unit.front();
  switch (first.kind) {
    case Kind::After:
    case Kind::AfterAny: {
      const Precedence& entry = spec.precedence[first.entry];
      std::vector<std::string> after;
      for (const Atom& atom : unit) {
        if (atom.kind == Kind::After)
          after.push_back(problem.connection_id(static_cast<ConnectionIndex>(atom.member)));
      }
      std::string rule;
      const std::string_view relation = assembly ? "before" : "after";
      if (!after.empty()) rule = std::string(relation) + " " + quoted_list(after, "and");
      if (unit.back().kind == Kind::AfterAny) {
        if (!rule.empty()) rule += ", and ";
        rule += std::string(relation) + " at least one of " + quoted_list(entry.after_any, "and");
      }
      return {after.empty() ? Constraint::PrecedenceAny : Constraint::Precedence,
              "precedence[" + std::to_string(first.entry) + "]",
              in_quotes(entry.connection) +
                  (assembly ? " must be made " : " may be removed only ") + rule};
    }
    case Kind::Subassemblies: {
      const std::size_t most = *spec.limits.max_subassemblies;
      if (at_once && at_once->constraint == Constraint::MaxSubassemblies)
        return {Constraint::MaxSubassemblies, "limits.max_subassemblies", at_once->message};
      return {Constraint::MaxSubassemblies, "limits.max_subassemblies",
              std::string("at most ") + std::to_string(most) +
                  (most == 1 ? " subassembly is allowed" : " subassemblies are allowed") +
                  (assembly ? " before a connection joins two pieces"
                            : " after a removal that separates")};
    }
    case Kind::MovedParts: {
      const std::size_t most = *spec.limits.max_moved_parts;
      return {Constraint::MaxMovedParts, "limits.max_moved_parts",
              "a moved piece may have at most " + std::to_string(most) +
                  (most == 1 ? " part" : " parts")};
    }
    case Kind::MovedMass:
      return {Constraint::MaxMovedMass, "limits.max_moved_mass",
              "a moved piece may have at most " + detail::number_text(*spec.limits.max_moved_mass) +
                  " kg"};
    case Kind::Inaccessible:
      return {Constraint::Inaccessible, "",
              in_quotes(problem.connection_id(static_cast<ConnectionIndex>(first.member))) +
                  " is inaccessible"};
    case Kind::Blocked: break;
  }
  const Blocked& entry = spec.blocking->blocked[first.entry];
  std::string directions;
  for (std::size_t i = 0; i < unit.size(); ++i) {
    if (i > 0) directions += i + 1 == unit.size() ? " and " : ", ";
    directions += kDirectionNames[unit[i].member];
  }
  return {Constraint::Blocking, "blocking.blocked[" + std::to_string(first.entry) + "]",
          in_quotes(entry.part) + " cannot leave " + in_quotes(entry.by) + " along " + directions};
}

}  // namespace

ProblemExplanation explain_problem(const Problem& problem, const Budget& budget) {
  return explain_problem(problem, Situation::whole(problem.num_connections()), budget);
}

ProblemExplanation explain_problem(const Problem& problem, const Situation& situation,
                                   const Budget& budget) {
  ProblemExplanation explanation;
  const TransitionSystem system(problem, situation);
  const auto at_once = system.infeasibility();
  Feasibility whole;
  if (system.whole()) {
    whole = find_order(problem.spec(), budget);
  } else if (at_once) {
    whole.status = Status::Infeasible;
  } else {
    whole = find_order_left(problem, system, system.kept(), budget);
  }
  if (whole.status == Status::Feasible && system.ordered()) {
    // A plan, but for what cannot be next or is late.
    const Result plan = greedy(system, budget);
    explanation.tests = 2;
    explanation.status = plan.has_plan() ? Status::Feasible : plan.status;
    explanation.stop = plan.stop;
    explanation.plan = plan.sequence;
    if (plan.status != Status::Infeasible) return explanation;
    explanation.minimal = false;
    const auto items = [&](const ConnectionSet& set, Constraint constraint, const char* what) {
      for_each_connection(set.view(), [&](ConnectionIndex c) {
        if (system.start().contains(c))
          explanation.conflict.push_back(
              {constraint, "", in_quotes(problem.connection_id(c)) + what});
      });
    };
    items(situation.not_next, Constraint::NotNext, " cannot be the next step");
    items(situation.late, Constraint::Late,
          " waits for a late part until nothing else can be done");
    return explanation;
  }
  explanation.status = whole.status;
  explanation.stop = whole.stop;
  explanation.tests = 1;
  if (whole.status != Status::Infeasible) {
    explanation.plan = whole.order;
    if (problem.direction() == Direction::Assembly) std::ranges::reverse(explanation.plan);
    return explanation;
  }

  ConflictFinder finder(system, budget, explanation);
  const std::vector<Atom> atoms = atoms_of(problem, system.kept());
  Units entries;
  if (at_once && at_once->constraint == Constraint::MaxSubassemblies) {
    entries.push_back(
        Unit{Atom{Kind::Subassemblies}});  // the start breaks it, so nothing else is needed
  } else {
    const auto [needed, unsure] = finder.filtered(units_of(atoms, same_group));
    // A limit that was needed beside more constraints is needed beside fewer.
    Units background;
    Units candidates;
    for (const Unit& group : needed) {
      const Kind kind = group.front().kind;
      const bool is_limit =
          kind != Kind::Blocked && kind != Kind::Inaccessible && !is_precedence(kind);
      for (const Unit& unit : units_of(group, same_entry))
        (is_limit ? background : candidates).push_back(unit);
    }
    for (const Unit& group : unsure) {
      for (const Unit& unit : units_of(group, same_entry)) candidates.push_back(unit);
    }
    entries = ConflictFinder::joined(background, finder.halved(background, false, candidates));

    // Inside the entries: which ids, which directions.
    background.clear();
    candidates.clear();
    for (const Unit& entry : entries) {
      for (const Atom& atom : entry)
        (entry.size() == 1 ? background : candidates).push_back(Unit{atom});
    }
    const bool minimal = explanation.minimal;
    const Stop stop = explanation.stop;
    entries = ConflictFinder::joined(background, finder.halved(background, false, candidates));
    explanation.minimal = minimal;  // of constraints; too many words are no constraint too many
    explanation.stop = stop;
  }
  for (const Unit& unit : units_of(atoms_in(entries), same_entry))
    explanation.conflict.push_back(described(problem, unit, at_once));
  if (explanation.conflict.size() == 1)
    explanation.minimal = true;  // without any constraint there is a plan
  return explanation;
}

// -------------------------------------------------------------------------------------------------
// One connection

namespace {

constexpr std::uint64_t kStatesBreadthFirst = 20'000;
constexpr std::uint64_t kStatesDepthFirst = 200'000;

std::vector<BlockedDirection> blocked_directions(const Problem& problem, const Step& step) {
  std::vector<char> moved(problem.num_parts(), 0);
  std::vector<char> kept(problem.num_parts(), 0);
  for (const PartIndex part : step.moved()) moved[part] = 1;
  for (const PartIndex part : step.kept()) kept[part] = 1;
  std::vector<BlockedDirection> directions;
  for (std::size_t d = 0; d < kDirectionNames.size(); ++d) {
    if ((problem.directions() >> d & 1U) == 0) continue;
    BlockedDirection found;
    found.direction = kDirectionNames[d];
    std::set<PartIndex> blocked;
    std::set<PartIndex> in_the_way;
    const auto& entries = problem.spec().blocking->blocked;
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const auto along = [&](std::size_t direction) {
        return std::ranges::find(entries[i].directions, kDirectionNames[direction]) !=
               entries[i].directions.end();
      };
      const PartIndex part = problem.find_part(entries[i].part, "");
      const PartIndex by = problem.find_part(entries[i].by, "");
      const bool forward = moved[part] != 0 && kept[by] != 0 && along(d);
      const bool backward = moved[by] != 0 && kept[part] != 0 && along(opposite(d));
      if (!forward && !backward) continue;
      blocked.insert(forward ? part : by);
      in_the_way.insert(forward ? by : part);
      found.entries.push_back(i);
    }
    found.moved.assign(blocked.begin(), blocked.end());
    found.in_the_way.assign(in_the_way.begin(), in_the_way.end());
    directions.push_back(std::move(found));
  }
  std::ranges::stable_sort(directions, {}, [](const BlockedDirection& direction) {
    return std::pair(direction.in_the_way.size(), direction.entries.size());
  });
  return directions;
}

/// Pieces of two or more parts where the step's connection is absent: what max_subassemblies
/// judges.
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
    case Constraint::PrecedenceAny: {
      const bool any = violation.constraint == Constraint::PrecedenceAny;
      remedy.first = violation.blocking_connections;
      const std::string names = quoted_list(ids(remedy.first, connection), any ? "or" : "and");
      if (std::ranges::find(remedy.first, step.connection) != remedy.first.end()) {
        remedy.message = "the entry makes it wait for itself; take that out";
      } else {
        remedy.message = (assembly ? "make it before " : "remove first ") + names;
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
    case Constraint::Blocking: {
      remedy.directions = blocked_directions(problem, step);
      const BlockedDirection& best = remedy.directions.front();
      remedy.message = "fewest parts are in the way along " + best.direction + ": " +
                       quoted_list(ids(best.in_the_way, part), "and") + " in the way of " +
                       quoted_list(ids(best.moved, part), "and") + " (";
      for (std::size_t i = 0; i < best.entries.size(); ++i)
        remedy.message +=
            (i > 0 ? ", " : "") + ("blocking.blocked[" + std::to_string(best.entries[i]) + "]");
      remedy.message += ")";
      break;
    }
    case Constraint::Inaccessible: remedy.message = "it would have to be accessible again"; break;
    case Constraint::NotNext: remedy.message = "it may be a later step"; break;
    case Constraint::Late:
      remedy.first = violation.blocking_connections;
      remedy.message = "what does not wait for the part comes first";
      break;
    case Constraint::NotOpen: remedy.message = "it is not there to be handled again"; break;
  }
  return remedy;
}

/// The steps to the nearest state in which the connection is legal, breadth first.
void search_breadth_first(const TransitionSystem& system, const ConnectionSet& open,
                          ConnectionIndex connection, const Budget& budget,
                          ConnectionExplanation& explanation) {
  struct Origin {
    std::uint32_t parent;
    ConnectionIndex step;
  };
  Expander expander(system);
  detail::StateTable<0> states(system.words());
  std::vector<Origin> origins;
  states.insert(open.view().data());
  origins.push_back({0, 0});
  for (std::uint32_t s = 0; s < states.size(); ++s) {
    if (s % 64 == 0 && budget.expired(states.bytes()) != Stop::None) return;
    ConnectionSet state(system.num_connections(), SetView{states.key(s), system.words()});
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

/// Follows the steps as long as they are legal, to the first state in which `connection` is:
/// whether there is one, and how many steps it takes.
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

/// The steps of some plan up to where the connection is legal, less what can be left out.
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
