#include "orasp/io/formats/pddl.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "orasp/io/formats/detail/left_out.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"
#include "orasp/model/transition_system.h"

namespace orasp {
namespace {

constexpr std::string_view kDomain = "assembly-order";

[[noreturn]] void refuse(std::string_view why) {
  throw InputError(fmt::format("pddl cannot say it: {}", why));
}

/// Why the problem cannot be said in PDDL's preconditions.
void require_sayable(const Problem& problem) {
  const ProblemSpec& spec = problem.spec();
  if (spec.limits.any())
    refuse("the limits of the problem look at the pieces that a step makes, not at what was done");
  const bool blocked = std::ranges::any_of(
      problem.blockers(), [](const std::vector<Blocker>& blockers) { return !blockers.empty(); });
  if (blocked) refuse("blocking looks at the pieces that a step makes, not at what was done");
  if (spec.action == StepKind::Part) refuse("steps take parts off, not single connections");
  if (problem.objective().of_fleet() || spec.fleet) refuse("the problem is one of several robots");
  for (const Connection& connection : spec.connections) {
    if (!connection.on_failure.retries()) {
      refuse(fmt::format("a failure at the connection {} changes more than it fails to do",
                         detail::in_quotes(connection.id)));
    }
  }
  if (spec.goal && TransitionSystem(problem).may_shut_out())
    refuse("with this precedence a step may shut out what the goal does not ask for");
}

/// Whether an id is a name of PDDL as it stands: small letters, for case means nothing there.
bool is_name(std::string_view id) {
  return !id.empty() && std::ranges::all_of(id, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
}

/// How the connections are called; "c" in front where the id begins with no letter.
std::vector<std::string> names_of(const Problem& problem) {
  std::vector<std::string> names(problem.num_connections());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string& id = problem.connections()[i].id;
    if (!is_name(id)) continue;
    names[i] = "c-" + id;
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!names[i].empty()) continue;
    names[i] = fmt::format("c{}", i + 1);
  }
  return names;
}

class DomainWriter {
 public:
  explicit DomainWriter(const Problem& problem)
      : problem_(problem),
        names_(names_of(problem)),
        assembly_(problem.direction() == Direction::Assembly),
        conditions_(problem.num_connections()) {
    for (const PrecedenceClause& clause : problem.precedence()) add(clause);
  }

  [[nodiscard]] std::string text() const {
    std::string text = fmt::format(
        "(define (domain {})\n  (:requirements :strips :typing "
        ":negative-preconditions{})\n  (:types connection)\n",
        kDomain, disjunctive_ ? " :disjunctive-preconditions" : "");
    text += "  (:constants";
    for (std::size_t i = 0; i < names_.size(); ++i) {
      text += fmt::format("\n    {}", names_[i]);
      if (i + 1 == names_.size()) text += " - connection";
      text += "  ; " + detail::in_quotes(problem_.connections()[i].id);
    }
    text += names_.empty() ? ")\n" : "\n  )\n";
    text += "  (:predicates (done ?c - connection))\n";
    for (std::size_t i = 0; i < names_.size(); ++i) {
      text += fmt::format(
          "  (:action {}-{}  ; {}\n    :parameters ()\n    :precondition (and (not "
          "(done {}))",
          assembly_ ? "make" : "remove", names_[i], detail::in_quotes(problem_.connections()[i].id),
          names_[i]);
      for (const std::string& condition : conditions_[i]) text += " " + condition;
      text += fmt::format(")\n    :effect (done {}))\n", names_[i]);
    }
    return text + ")\n";
  }

 private:
  [[nodiscard]] std::string done(ConnectionIndex c) const {
    return fmt::format("(done {})", names_[c]);
  }
  [[nodiscard]] std::string not_done(ConnectionIndex c) const {
    return fmt::format("(not (done {}))", names_[c]);
  }
  /// One of several; of none, what never holds before the step itself.
  void require_any(ConnectionIndex step, std::vector<std::string> choices) {
    if (choices.empty()) choices.push_back(done(step));
    if (choices.size() == 1) {
      require(step, choices.front());
      return;
    }
    disjunctive_ = true;
    require(step, fmt::format("(or {})", fmt::join(choices, " ")));
  }
  void require(ConnectionIndex step, std::string condition) {
    std::vector<std::string>& known = conditions_[step];
    if (std::ranges::find(known, condition) == known.end()) known.push_back(std::move(condition));
  }

  /// In disassembly `done` means gone, in assembly it means there.
  void add(const PrecedenceClause& clause) {
    const ConnectionIndex c = clause.connection;
    for (const ConnectionIndex early : clause.after) {
      if (assembly_) {
        require(early, done(c));
      } else {
        require(c, done(early));
      }
    }
    if (!clause.after_any.empty()) {
      std::vector<std::string> choices;
      for (const ConnectionIndex other : clause.after_any)
        if (other != c) choices.push_back(assembly_ ? not_done(other) : done(other));
      require_any(c, std::move(choices));
    }
    if (clause.made_after_any.empty()) return;
    if (assembly_) {
      std::vector<std::string> choices;
      for (const ConnectionIndex other : clause.made_after_any)
        if (other != c) choices.push_back(done(other));
      require_any(c, std::move(choices));
      return;
    }
    for (const ConnectionIndex taken : clause.made_after_any) {
      if (taken == c) continue;
      std::vector<std::string> choices = {done(c)};
      for (const ConnectionIndex other : clause.made_after_any)
        if (other != taken) choices.push_back(not_done(other));
      require_any(taken, std::move(choices));
    }
  }

  const Problem& problem_;
  std::vector<std::string> names_;
  bool assembly_;
  bool disjunctive_ = false;
  std::vector<std::vector<std::string>> conditions_;
};

Written with_note(std::string text, const Problem& problem) {
  ProblemSpec spec = problem.spec();
  spec.precedence.clear();
  spec.goal.reset();
  spec.blocking.reset();  // it blocks nothing
  Written written{.text = std::move(text)};
  if (std::string note = detail::left_out_sentence(spec, {.direction = false, .values = true});
      !note.empty())
    written.notes.push_back(std::move(note));
  return written;
}

}  // namespace

Written write_pddl_domain(const WriteRequest& request) {
  require_sayable(request.problem);
  return with_note(DomainWriter(request.problem).text(), request.problem);
}

Written write_pddl_problem(const WriteRequest& request) {
  const Problem& problem = request.problem;
  require_sayable(problem);
  const std::vector<std::string> names = names_of(problem);
  std::string goal;
  const auto want = [&](std::size_t c) { goal += fmt::format("\n    (done {})", names[c]); };
  if (problem.spec().goal) {
    for (const ConnectionIndex c : problem.goal()) want(c);
  } else {
    for (std::size_t c = 0; c < names.size(); ++c) want(c);
  }
  return with_note(fmt::format("(define (problem {}-problem)\n  (:domain {})\n  (:init)\n  (:goal "
                               "(and{}))\n)\n",
                               kDomain, kDomain, goal),
                   problem);
}

}  // namespace orasp
