#include "orasp/explain/explain_problem.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "orasp/explain/explain_connection.h"
#include "orasp/model/detail/wording.h"
#include "orasp/planners/feasibility.h"
#include "orasp/planners/greedy.h"

namespace orasp {

namespace {

using detail::in_quotes;
using detail::quoted_list;

enum class Kind {
  After,
  AfterAny,
  MadeAfterAny,
  Subassemblies,
  MovedParts,
  MovedMass,
  Grounded,
  Blocked,
  Inaccessible
};

/// The least that can be dropped: a limit, one id of an `after` or `made_after`, a whole
/// `after_any` or `made_after_any` (of which fewer ids ask for more), one direction of an entry of
/// `blocked`, one inaccessible connection.
struct Atom {
  Kind kind;
  std::size_t entry = 0;
  /// For After and Inaccessible the connection, for Blocked the direction.
  std::size_t member = 0;
  /// Of precedence: the connection of the clause.
  std::size_t connection = 0;

  [[nodiscard]] friend auto operator<=>(const Atom&, const Atom&) = default;
};

/// Atoms that are dropped together, or kept.
using Unit = std::vector<Atom>;
using Units = std::vector<Unit>;

std::vector<Atom> atoms_of(const Problem& problem, const ConnectionSet& kept) {
  std::vector<Atom> atoms;
  for (const PrecedenceClause& clause : problem.precedence()) {
    for (const ConnectionIndex c : clause.after)
      atoms.push_back({Kind::After, clause.entry, c, clause.connection});
    if (!clause.after_any.empty())
      atoms.push_back({Kind::AfterAny, clause.entry, 0, clause.connection});
    if (!clause.made_after_any.empty())
      atoms.push_back({Kind::MadeAfterAny, clause.entry, 0, clause.connection});
  }
  const Limits& limits = problem.limits();
  if (limits.max_subassemblies) atoms.push_back({Kind::Subassemblies});
  if (limits.max_moved_parts) atoms.push_back({Kind::MovedParts});
  if (limits.max_moved_mass) atoms.push_back({Kind::MovedMass});
  if (limits.grounded) atoms.push_back({Kind::Grounded});
  if (const auto& blocking = problem.spec().blocking) {
    for (std::size_t i = 0; i < blocking->blocked.size(); ++i) {
      std::set<std::size_t> directions;
      for (const std::string& name : blocking->blocked[i].directions)
        directions.insert(*problem.find_direction(name));
      for (const std::size_t d : directions) atoms.push_back({Kind::Blocked, i, d});
    }
  }
  for_each_connection(kept.view(), [&](ConnectionIndex c) {
    atoms.push_back({Kind::Inaccessible, c, c});
  });
  return atoms;
}

/// Leaves only the blocking between two parts.
void keep_those_between(const Problem& problem, const std::array<PartIndex, 2>& pair,
                        std::vector<Atom>& atoms) {
  const std::string& a = problem.part_id(pair[0]);
  const std::string& b = problem.part_id(pair[1]);
  std::erase_if(atoms, [&](const Atom& atom) {
    if (atom.kind != Kind::Blocked) return true;
    const Blocked& entry = problem.spec().blocking->blocked[atom.entry];
    return !(entry.part == a && entry.by == b) && !(entry.part == b && entry.by == a);
  });
}

/// Joins atoms that stand next to each other to one unit wherever `same(a, b)` holds of the two.
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
  return kind == Kind::After || kind == Kind::AfterAny || kind == Kind::MadeAfterAny;
}

bool same_group(const Atom& a, const Atom& b) {
  return a.kind == b.kind || (is_precedence(a.kind) && is_precedence(b.kind));
}

bool same_entry(const Atom& a, const Atom& b) {
  return same_group(a, b) && a.entry == b.entry;
}

/// The problem with no constraints but those of `units`.
ProblemSpec reduced(const Problem& problem, const Units& units) {
  const ProblemSpec& full = problem.spec();
  ProblemSpec spec;
  spec.parts = full.parts;
  spec.connections = full.connections;
  spec.base = full.base;
  spec.goal = full.goal;
  spec.action = full.action;
  if (full.blocking) spec.blocking = Blocking{full.blocking->directions, {}};
  std::vector<Atom> atoms;
  for (const Unit& unit : units) atoms.insert(atoms.end(), unit.begin(), unit.end());
  std::ranges::sort(atoms);
  for (const Atom& atom : atoms) {
    switch (atom.kind) {
      case Kind::After:
        spec.precedence.push_back(
            {.connection = problem.connection_id(static_cast<ConnectionIndex>(atom.connection)),
             .after = {problem.connection_id(static_cast<ConnectionIndex>(atom.member))}});
        break;
      case Kind::AfterAny: {
        const Precedence& entry = full.precedence[atom.entry];
        spec.precedence.push_back({.connection = entry.connection, .after_any = entry.after_any});
        break;
      }
      case Kind::MadeAfterAny: {
        const Precedence& entry = full.precedence[atom.entry];
        spec.precedence.push_back(
            {.connection = entry.connection, .made_after_any = entry.made_after_any});
        break;
      }
      case Kind::Subassemblies:
        spec.limits.max_subassemblies = full.limits.max_subassemblies;
        break;
      case Kind::MovedParts: spec.limits.max_moved_parts = full.limits.max_moved_parts; break;
      case Kind::MovedMass: spec.limits.max_moved_mass = full.limits.max_moved_mass; break;
      case Kind::Grounded: spec.limits.grounded = true; break;
      // Which connections are inaccessible is said by the situation, not by the problem.
      case Kind::Inaccessible: break;
      case Kind::Blocked: {
        const Blocked& entry = full.blocking->blocked[atom.entry];
        spec.blocking->blocked.push_back(
            {entry.part, entry.by, {problem.direction_name(DirectionIndex(atom.member))}});
        break;
      }
    }
  }
  return spec;
}

/// Whether a plan exists under these atoms, which are all of precedence, none of MadeAfterAny. Each
/// connection goes as soon as no atom holds it any more. O(connections + ids).
bool precedence_can_be_met(const Problem& problem, std::span<const Atom> atoms) {
  const std::size_t connections = problem.num_connections();
  // How many atoms still hold each connection, and the atoms that wait for each connection to go.
  std::vector<std::size_t> waits(connections, 0);
  std::vector<std::vector<std::size_t>> waiting(connections);
  for (std::size_t i = 0; i < atoms.size(); ++i) {
    ++waits[atoms[i].connection];
    if (atoms[i].kind == Kind::After) {
      waiting[atoms[i].member].push_back(i);
    } else {
      for (const std::string& id : problem.spec().precedence[atoms[i].entry].after_any)
        waiting[problem.find_connection(id, "")].push_back(i);
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
      if (--waits[atoms[i].connection] == 0) gone.push_back(atoms[i].connection);
    }
  }
  return gone.size() == connections;
}

/// An order, in disassembly, of what is left to do under the constraints of `problem`, where only
/// `kept` stays.
Feasibility find_order_left(const Problem& problem, const TransitionSystem& system,
                            const ConnectionSet& kept, const Budget& budget) {
  // Everything that is open, but for `kept`.
  ConnectionSet left(problem.num_connections());
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

  /// Whether it is proved that no plan exists under `units`. A test that is not decided counts as
  /// no proof.
  [[nodiscard]] bool conflicts(const Units& units) {
    Stop stop = budget_.expired();
    if (stop == Stop::None) {
      ++explanation_.tests;
      budget_.report({.phase = "test", .done = explanation_.tests});
      std::vector<Atom> atoms;
      for (const Unit& unit : units) atoms.insert(atoms.end(), unit.begin(), unit.end());
      const auto is_of_precedence = [](const Atom& atom) {
        return is_precedence(atom.kind) && atom.kind != Kind::MadeAfterAny;
      };
      // Where no constraint judges the pieces, the order can be found without a search.
      if (system_.whole() && std::ranges::all_of(atoms, is_of_precedence))
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

  /// Drops every unit that is not needed from `units`, which conflict, one after the other. Returns
  /// the units that are proved to be needed, and those of which that was not decided.
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
  /// The states that a test may expand: enough for what a person may hope to understand.
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

/// The atoms of one entry of precedence, in the direction of the problem.
ConflictItem described_entry(const Problem& problem, const Unit& unit) {
  const Precedence& entry = problem.spec().precedence[unit.front().entry];
  const bool assembly = problem.direction() == Direction::Assembly;
  const std::string id = in_quotes(entry.connection);
  std::vector<std::string> after;
  std::vector<std::string> made_after;
  Constraint constraint = Constraint::Precedence;
  std::string text;
  const auto add = [&](const std::string& rule) { text += (text.empty() ? "" : ", and ") + rule; };
  for (const Atom& atom : unit) {
    if (atom.kind != Kind::After) continue;
    const auto named = [&](std::size_t c) {
      return problem.connection_id(static_cast<ConnectionIndex>(c));
    };
    const bool own = named(atom.connection) == entry.connection;
    (own ? after : made_after).push_back(named(own ? atom.member : atom.connection));
  }
  if (!after.empty())
    add(id + (assembly ? " must be made before " : " may be removed only after ") +
        quoted_list(after, "and"));
  if (!made_after.empty())
    add(assembly ? id + " may be made only after " + quoted_list(made_after, "and")
                 : quoted_list(made_after, "and") + " may be removed only after " + id);
  for (const Atom& atom : unit) {
    if (atom.kind == Kind::AfterAny) {
      if (text.empty()) constraint = Constraint::PrecedenceAny;
      add(id +
          (assembly ? " must be made before at least one of "
                    : " may be removed only after at least one of ") +
          quoted_list(entry.after_any, "and"));
    }
    if (atom.kind == Kind::MadeAfterAny) {
      if (text.empty()) constraint = Constraint::PrecedenceMadeAny;
      const std::string any = "at least one of " + quoted_list(entry.made_after_any, "and");
      add(assembly ? id + " may be made only after " + any
                   : "as long as " + id + " is there, " + any + " must be");
    }
  }
  return {constraint, "precedence[" + std::to_string(unit.front().entry) + "]", text};
}

ConflictItem described(const Problem& problem, const Unit& unit,
                       const std::optional<Violation>& at_once) {
  const ProblemSpec& spec = problem.spec();
  const bool assembly = problem.direction() == Direction::Assembly;
  const Atom& first = unit.front();
  switch (first.kind) {
    case Kind::After:
    case Kind::AfterAny:
    case Kind::MadeAfterAny: return described_entry(problem, unit);
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
    case Kind::Grounded:
      if (at_once && at_once->constraint == Constraint::Grounded)
        return {Constraint::Grounded, "limits.grounded", at_once->message};
      return {Constraint::Grounded, "limits.grounded",
              "each subassembly must hold a base part (" + quoted_list(spec.base, "or") + ")"};
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
    directions += problem.direction_name(DirectionIndex(unit[i].member));
    for (std::size_t d = 0; d < entry.widths.size(); ++d) {
      if (*problem.find_direction(entry.directions[d]) != unit[i].member) continue;
      directions += " (" + width_text(*spec.blocking, entry.widths[d]) + ")";
      break;
    }
  }
  return {Constraint::Blocking, "blocking.blocked[" + std::to_string(first.entry) + "]",
          in_quotes(entry.part) + " cannot leave " + in_quotes(entry.by) + " along " + directions};
}

/// The explanation of a problem that has a plan, but for connections that cannot be next or wait
/// for a late part: greedy says whether they alone rule one out.
ProblemExplanation explain_order(const TransitionSystem& system, const Situation& situation,
                                 const Budget& budget) {
  ProblemExplanation explanation;
  const Result plan = greedy(system, budget);
  explanation.tests = 2;
  explanation.status = plan.has_plan() ? Status::Feasible : plan.status;
  explanation.stop = plan.stop;
  explanation.plan = plan.sequence;
  if (plan.status != Status::Infeasible) return explanation;
  explanation.minimal = false;
  const auto add_items = [&](const ConnectionSet& set, Constraint constraint, const char* what) {
    for_each_connection(set.view(), [&](ConnectionIndex c) {
      if (system.start().contains(c))
        explanation.conflict.push_back(
            {constraint, "", in_quotes(system.problem().connection_id(c)) + what});
    });
  };
  add_items(situation.not_next, Constraint::NotNext, " cannot be the next step");
  add_items(situation.late, Constraint::Late,
            " waits for a late part until nothing else can be done");
  return explanation;
}

/// The entries of the file that conflict, each with only the ids and directions that are needed.
/// `atoms` are all constraints, which conflict.
Units conflicting_entries(ConflictFinder& finder, const std::vector<Atom>& atoms,
                          ProblemExplanation& explanation) {
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
  const Units entries =
      ConflictFinder::joined(background, finder.halved(background, false, candidates));

  // Which ids and which directions inside the entries matter. A test that is not decided here
  // leaves a word too many in a sentence, but no constraint too many in the conflict: it must not
  // change what is said of the conflict.
  background.clear();
  candidates.clear();
  for (const Unit& entry : entries) {
    for (const Atom& atom : entry)
      (entry.size() == 1 ? background : candidates).push_back(Unit{atom});
  }
  const bool minimal = explanation.minimal;
  const Stop stop = explanation.stop;
  const Units words =
      ConflictFinder::joined(background, finder.halved(background, false, candidates));
  explanation.minimal = minimal;
  explanation.stop = stop;
  return words;
}

}  // namespace

ProblemExplanation explain_problem(const Problem& problem, const Budget& budget) {
  return explain_problem(problem, Situation::whole(problem.num_connections()), budget);
}

ProblemExplanation explain_problem(const Problem& problem, const Situation& situation,
                                   const Budget& budget) {
  const TransitionSystem system(problem, situation);
  const auto at_once = system.infeasibility();
  Feasibility all;
  if (system.whole()) {
    all = find_order(problem.spec(), budget);
  } else if (at_once) {
    all.status = Status::Infeasible;
  } else {
    all = find_order_left(problem, system, system.kept(), budget);
  }
  if (all.status == Status::Feasible && system.ordered())
    return explain_order(system, situation, budget);
  ProblemExplanation explanation;
  explanation.status = all.status;
  explanation.stop = all.stop;
  explanation.tests = 1;
  if (all.status != Status::Infeasible) {
    explanation.plan = all.order;
    if (problem.direction() == Direction::Assembly) std::ranges::reverse(explanation.plan);
    return explanation;
  }

  Units entries;
  if (at_once && at_once->constraint == Constraint::MaxSubassemblies) {
    // The start alone breaks the limit, so no other constraint is needed for the conflict.
    entries.push_back(Unit{Atom{Kind::Subassemblies}});
  } else {
    std::vector<Atom> atoms = atoms_of(problem, system.kept());
    // Two parts that lock each other need no other constraint for the conflict either.
    if (at_once && at_once->constraint == Constraint::Blocking)
      keep_those_between(problem, *system.locked_pair(), atoms);
    ConflictFinder finder(system, budget, explanation);
    entries = conflicting_entries(finder, atoms, explanation);
  }
  for (const Unit& unit : units_of(atoms_in(entries), same_entry))
    explanation.conflict.push_back(described(problem, unit, at_once));
  // Without any constraint there is a plan, so a conflict of one constraint is always smallest.
  if (explanation.conflict.size() == 1) explanation.minimal = true;
  return explanation;
}

}  // namespace orasp
