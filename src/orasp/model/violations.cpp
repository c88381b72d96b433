#include <algorithm>
#include <iterator>

#include "orasp/model/detail/step_scratch.h"
#include "orasp/model/detail/wording.h"

namespace orasp {

using detail::at_most;
using detail::Facts;
using detail::Side;

std::vector<Violation> Expander::violations(SetView open, ConnectionIndex connection) {
  Scratch& s = *scratch_;
  const Problem& problem = s.problem;
  const TransitionSystem::Rules& rules = s.rules;
  const std::string id = detail::in_quotes(problem.connection_id(connection));
  std::vector<Violation> found;
  if (rules.kept.contains(connection)) {
    found.push_back({Constraint::Inaccessible, "", id + " is inaccessible", {}});
    return found;
  }
  if (!contains(open, connection)) {
    found.push_back({Constraint::NotOpen,
                     "",
                     id + (rules.assembly ? " was made before" : " was removed before"),
                     {}});
    return found;
  }
  const auto stands_in_the_way = [&](ConnectionIndex other) {
    const bool missing_or_there = contains(open, other) || rules.kept.contains(other);
    return other == connection || missing_or_there != rules.assembly;
  };
  const auto names = [&](const std::vector<ConnectionIndex>& list) {
    std::string text;
    for (const ConnectionIndex c : list)
      text += (text.empty() ? "" : ", ") + detail::in_quotes(problem.connection_id(c));
    return text;
  };
  for (const PrecedenceClause& clause : problem.precedence()) {
    if (clause.connection != connection) continue;
    const std::string where = "precedence[" + std::to_string(clause.entry) + "]";
    std::vector<ConnectionIndex> after;
    std::ranges::copy_if(clause.after, std::back_inserter(after), stands_in_the_way);
    std::ranges::sort(after);
    if (!after.empty()) {
      found.push_back({Constraint::Precedence, where,
                       rules.assembly ? id + " must be made before " + names(after)
                                      : id + " may be removed only after " + names(after),
                       after});
    }
    if (!clause.after_any.empty() && std::ranges::all_of(clause.after_any, stands_in_the_way)) {
      std::vector<ConnectionIndex> any = clause.after_any;
      std::ranges::sort(any);
      found.push_back({Constraint::PrecedenceAny, where,
                       rules.assembly
                           ? id + " must be made before at least one of " + names(any)
                           : id + " may be removed only after at least one of " + names(any),
                       any});
    }
  }
  if (s.ruled_out_first(open, connection))
    found.push_back({Constraint::NotNext, "", id + " cannot be the next step", {}});
  if (const auto other = s.waiting(open, connection)) {
    found.push_back({Constraint::Late,
                     "",
                     id + " waits for a late part while " +
                         detail::in_quotes(problem.connection_id(*other)) + " can be handled",
                     {*other}});
  }
  const Facts facts = s.flooded_facts(open, connection);
  if (!facts.separates) return found;
  const std::string cut = (rules.assembly ? "making " : "removing ") + id;
  if (facts.subassemblies_apart > rules.max_subassemblies) {
    found.push_back({Constraint::MaxSubassemblies,
                     "limits.max_subassemblies",
                     (rules.assembly ? cut + " starts from " : cut + " leaves ") +
                         std::to_string(facts.subassemblies_apart) + " subassemblies; at most " +
                         std::to_string(rules.max_subassemblies) + " are allowed",
                     {}});
  }
  const std::size_t moved_parts = std::min(facts.a_parts, facts.b_parts);
  if (moved_parts > rules.max_moved_parts) {
    found.push_back({Constraint::MaxMovedParts,
                     "limits.max_moved_parts",
                     cut + " moves " + std::to_string(moved_parts) + " parts; at most " +
                         std::to_string(rules.max_moved_parts) + " are allowed",
                     {}});
  }
  const double moved_mass = s.movement(facts).moved_mass;
  if (!at_most(moved_mass, rules.max_moved_mass)) {
    found.push_back({Constraint::MaxMovedMass,
                     "limits.max_moved_mass",
                     cut + " moves " + detail::number_text(moved_mass) + " kg; at most " +
                         detail::number_text(rules.max_moved_mass) + " kg are allowed",
                     {}});
  }
  if (rules.blocking && s.free_directions() == 0) {
    const auto part_list = [&](const Side& side) {
      std::string text;
      side.for_each([&](PartIndex part) {
        text += (text.empty() ? "" : ", ") + detail::in_quotes(problem.part_id(part));
      });
      return text;
    };
    const Side& few = s.a.parts() <= s.b.parts() ? s.a : s.b;
    const Side& many = s.a.parts() <= s.b.parts() ? s.b : s.a;
    found.push_back({Constraint::Blocking,
                     "blocking",
                     cut + " is blocked: no direction is free to move " + part_list(few) + " off " +
                         part_list(many),
                     {}});
  }
  return found;
}

std::string_view constraint_name(Constraint constraint) {
  switch (constraint) {
    case Constraint::Precedence:
    case Constraint::PrecedenceAny: return "precedence";
    case Constraint::MaxSubassemblies: return "max_subassemblies";
    case Constraint::MaxMovedParts: return "max_moved_parts";
    case Constraint::MaxMovedMass: return "max_moved_mass";
    case Constraint::Blocking: return "blocking";
    case Constraint::Inaccessible: return "inaccessible";
    case Constraint::NotNext: return "not_next";
    case Constraint::Late: return "late";
    case Constraint::NotOpen: break;
  }
  return "sequence";
}

}  // namespace orasp
