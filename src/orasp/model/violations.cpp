#include <algorithm>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "orasp/model/detail/step_scratch.h"
#include "orasp/model/detail/wording.h"

namespace orasp {

using detail::at_most;
using detail::Side;
using detail::StepFacts;

namespace {

/// Collects why one step is not legal. Each member looks at one kind of constraint.
class Reasons {
 public:
  Reasons(const Problem& problem, const detail::Rules& rules, SetView open,
          ConnectionIndex connection)
      : problem_(problem),
        rules_(rules),
        open_(open),
        connection_(connection),
        id_(detail::in_quotes(problem.connection_id(connection))) {}

  [[nodiscard]] std::vector<Violation> found() && { return std::move(found_); }

  void add(Constraint constraint, std::string where, std::string message,
           std::vector<ConnectionIndex> in_the_way = {}, bool too_late = false) {
    found_.push_back(
        {constraint, std::move(where), std::move(message), std::move(in_the_way), too_late});
  }

  /// Whether the connection can be handled at all.
  bool open() {
    if (rules_.kept.contains(connection_)) {
      add(Constraint::Inaccessible, "", id_ + " is inaccessible");
      return false;
    }
    if (!contains(open_, connection_)) {
      add(Constraint::NotOpen, "",
          id_ + (rules_.assembly ? " was made before" : " was removed before"));
      return false;
    }
    return true;
  }

  void precedence() { rules_.making ? precedence_of_making() : precedence_of_removal(); }

  void precedence_of_removal() {
    for (const PrecedenceClause& clause : problem_.precedence()) {
      if (clause.connection != connection_) continue;
      const std::vector<ConnectionIndex> after =
          those(clause.after, [this](ConnectionIndex other) { return is_there(other); });
      if (!after.empty()) {
        add(Constraint::Precedence, place(clause.entry),
            id_ + " may be removed only after " + names(after), after);
      }
      if (clause.after_any.empty() ||
          !std::ranges::all_of(clause.after_any,
                               [this](ConnectionIndex other) { return is_there(other); }))
        continue;
      const std::vector<ConnectionIndex> any = sorted(clause.after_any);
      add(Constraint::PrecedenceAny, place(clause.entry),
          id_ + " may be removed only after at least one of " + names(any), any);
    }
    for_each_shut(&PrecedenceClause::made_after_any, [this](const PrecedenceClause& clause) {
      add(Constraint::PrecedenceMadeAny, place(clause.entry),
          "without " + id_ + " nothing is left that " + name(clause.connection) +
              " needs: as long as it is there, one of " + names(sorted(clause.made_after_any)) +
              " must be",
          {clause.connection});
    });
  }

  void precedence_of_making() {
    for (const PrecedenceClause& clause : problem_.precedence()) {
      const ConnectionIndex c = clause.connection;
      const auto names_it = [this](const std::vector<ConnectionIndex>& list) {
        return std::ranges::find(list, connection_) != list.end();
      };
      if (names_it(clause.after) && contains(open_, c)) {
        add(Constraint::Precedence, place(clause.entry),
            id_ + (c == connection_ ? " may not be made before itself"
                                    : " may be made only after " + name(c)),
            {c});
      }
      if (c != connection_) continue;
      const auto made = [this](ConnectionIndex other) {
        return other != connection_ && is_there(other);
      };
      const std::vector<ConnectionIndex> early = those(clause.after, made);
      if (!early.empty()) {
        add(Constraint::Precedence, place(clause.entry),
            id_ + " must be made before " + names(early) +
                (early.size() == 1 ? ", which is made already" : ", which are made already"),
            early, true);
      }
      const std::vector<ConnectionIndex> any = sorted(clause.after_any);
      if (!any.empty() && std::ranges::all_of(any, [&](ConnectionIndex other) {
            return other == connection_ || made(other);
          })) {
        add(Constraint::PrecedenceAny, place(clause.entry),
            id_ + " must be made before at least one of " + names(any) +
                ", which are all made already",
            any, true);
      }
      const std::vector<ConnectionIndex> needed = sorted(clause.made_after_any);
      if (needed.empty() || std::ranges::any_of(needed, made)) continue;
      add(Constraint::PrecedenceMadeAny, place(clause.entry),
          id_ + " may be made only after at least one of " + names(needed), needed);
    }
    for_each_shut(&PrecedenceClause::after_any, [this](const PrecedenceClause& clause) {
      add(Constraint::PrecedenceAny, place(clause.entry),
          "after " + id_ + " " + name(clause.connection) +
              " could no longer be made, which must be made before at least one of " +
              names(sorted(clause.after_any)),
          {clause.connection});
    });
  }

  void order(bool ruled_out_first, std::optional<ConnectionIndex> waits_for) {
    if (ruled_out_first) add(Constraint::NotNext, "", id_ + " cannot be the next step");
    if (!waits_for) return;
    add(Constraint::Late, "",
        id_ + " waits for a late part while " +
            detail::in_quotes(problem_.connection_id(*waits_for)) + " can be handled",
        {*waits_for});
  }

  /// Of a step that cuts or joins `pieces`.
  void limits(const StepFacts& facts, const detail::StepPieces& pieces) {
    if (facts.subassemblies_apart > rules_.max_subassemblies) {
      add(Constraint::MaxSubassemblies, "limits.max_subassemblies",
          cut() + (rules_.assembly ? " starts from " : " leaves ") +
              std::to_string(facts.subassemblies_apart) + " subassemblies; at most " +
              std::to_string(rules_.max_subassemblies) + " are allowed");
    }
    const detail::Movement movement = pieces.movement(facts);
    const std::size_t moved_parts = movement.moved_parts;
    if (moved_parts > rules_.max_moved_parts) {
      add(Constraint::MaxMovedParts, "limits.max_moved_parts",
          cut() + " moves " + std::to_string(moved_parts) + " parts; at most " +
              std::to_string(rules_.max_moved_parts) + " are allowed");
    }
    const double moved_mass = movement.moved_mass;
    if (!at_most(moved_mass, rules_.max_moved_mass)) {
      add(Constraint::MaxMovedMass, "limits.max_moved_mass",
          cut() + " moves " + detail::number_text(moved_mass) + " kg; at most " +
              detail::number_text(rules_.max_moved_mass) + " kg are allowed");
    }
  }

  /// Of a step after which a subassembly holds no base part.
  void grounded(const StepFacts& facts, const detail::StepPieces& pieces) {
    std::string loose;
    if (rules_.making) {
      loose = parts(pieces.a) + ", " + parts(pieces.b);
    } else {
      const bool a_is_loose = facts.a_parts > 1 && !pieces.has_base(pieces.a);
      loose = parts(a_is_loose ? pieces.a : pieces.b);
    }
    add(Constraint::Grounded, "limits.grounded",
        cut() + (rules_.assembly ? " starts from or makes" : " leaves") + " a subassembly of " +
            loose + " without a base part; each must hold one");
  }

  /// Of a step for which no direction is free.
  void blocking(const detail::StepPieces& pieces) {
    const bool a_is_few = pieces.a.parts() <= pieces.b.parts();
    add(Constraint::Blocking, "blocking",
        cut() + " is blocked: no direction is free to move " +
            parts(a_is_few ? pieces.a : pieces.b) + " off " +
            parts(a_is_few ? pieces.b : pieces.a));
  }

 private:
  /// Whether `other` is there now, the connection itself among them.
  [[nodiscard]] bool is_there(ConnectionIndex other) const {
    const bool open = contains(open_, other) || rules_.kept.contains(other);
    return other == connection_ || open != rules_.making;
  }
  /// Calls visit(clause) for each clause of precedence whose list of that kind the step makes
  /// impossible to meet.
  template <class Visit>
  void for_each_shut(std::vector<ConnectionIndex> PrecedenceClause::*kind, Visit&& visit) const {
    if (problem_.precedence().empty() || rules_.named_in[connection_].empty()) return;
    const auto shut = rules_.lists_shut(open_, connection_);
    std::vector<std::size_t> met(problem_.num_connections(), 0);  // by connection: lists so far
    for (const PrecedenceClause& clause : problem_.precedence()) {
      if ((clause.*kind).empty()) continue;
      const std::size_t list = met[clause.connection]++;
      if (std::ranges::any_of(shut, [&](const detail::Rules::ListOfMany& one) {
            return one.connection == clause.connection && one.list == list;
          }))
        visit(clause);
    }
  }
  template <class Wanted>
  [[nodiscard]] static std::vector<ConnectionIndex> those(const std::vector<ConnectionIndex>& list,
                                                          Wanted&& wanted) {
    std::vector<ConnectionIndex> found;
    std::ranges::copy_if(list, std::back_inserter(found), wanted);
    return sorted(std::move(found));
  }
  [[nodiscard]] static std::vector<ConnectionIndex> sorted(std::vector<ConnectionIndex> list) {
    std::ranges::sort(list);
    return list;
  }
  [[nodiscard]] static std::string place(std::size_t entry) {
    return "precedence[" + std::to_string(entry) + "]";
  }
  [[nodiscard]] std::string name(ConnectionIndex c) const {
    return detail::in_quotes(problem_.connection_id(c));
  }
  [[nodiscard]] std::string names(const std::vector<ConnectionIndex>& list) const {
    std::string text;
    for (const ConnectionIndex c : list) text += (text.empty() ? "" : ", ") + name(c);
    return text;
  }
  [[nodiscard]] std::string parts(const Side& side) const {
    std::string text;
    side.for_each([&](PartIndex part) {
      text += (text.empty() ? "" : ", ") + detail::in_quotes(problem_.part_id(part));
    });
    return text;
  }
  [[nodiscard]] std::string cut() const {
    return (rules_.assembly ? "making " : "removing ") + id_;
  }

  const Problem& problem_;
  const detail::Rules& rules_;
  SetView open_;
  ConnectionIndex connection_;
  std::string id_;
  std::vector<Violation> found_;
};

}  // namespace

std::vector<Violation> Expander::violations(SetView open, ConnectionIndex connection) {
  Scratch& s = *scratch_;
  Reasons reasons(s.problem, s.rules, open, connection);
  if (!reasons.open()) return std::move(reasons).found();
  reasons.precedence();
  reasons.order(s.ruled_out_first(open, connection), s.waiting(open, connection));
  const StepFacts facts = s.flooded_facts(open, connection);
  if (facts.separates) {
    reasons.limits(facts, s.pieces);
    if (s.rules.grounded && !s.leaves_grounded(facts)) reasons.grounded(facts, s.pieces);
    const bool moves = !s.rules.fixed_parts || s.pieces.movement(facts).moves;
    if (s.rules.blocking && moves && !s.some_direction_free()) reasons.blocking(s.pieces);
  }
  return std::move(reasons).found();
}

std::string_view constraint_name(Constraint constraint) {
  switch (constraint) {
    case Constraint::Precedence:
    case Constraint::PrecedenceAny:
    case Constraint::PrecedenceMadeAny: return "precedence";
    case Constraint::MaxSubassemblies: return "max_subassemblies";
    case Constraint::MaxMovedParts: return "max_moved_parts";
    case Constraint::MaxMovedMass: return "max_moved_mass";
    case Constraint::Grounded: return "grounded";
    case Constraint::Blocking: return "blocking";
    case Constraint::Inaccessible: return "inaccessible";
    case Constraint::NotNext: return "not_next";
    case Constraint::Late: return "late";
    case Constraint::Goal: return "goal";
    case Constraint::NotOneStep: return "action";
    case Constraint::NotOpen: break;
  }
  return "sequence";
}

}  // namespace orasp
