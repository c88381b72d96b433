#include "orasp/model/detail/rules.h"

#include <algorithm>
#include <span>
#include <string>

#include "orasp/model/objectives/objective_kind.h"
#include "orasp/model/tolerance.h"

namespace orasp::detail {

namespace {

void insert(std::span<std::uint64_t> set, ConnectionIndex c) {
  set[c / 64] |= std::uint64_t{1} << (c % 64);
}

}  // namespace

Rules::Rules(const Problem& problem, const Situation& situation)
    : assembly(problem.direction() == Direction::Assembly),
      words(words_for(problem.num_connections())),
      graph(problem),
      totals(problem, graph) {
  const std::size_t connections = problem.num_connections();
  // Constraints.
  constrained.assign(words, 0);
  if (!problem.precedence().empty()) {
    after.assign(connections * words, 0);
    any.resize(connections);
  }
  for (const PrecedenceClause& clause : problem.precedence()) {
    insert(constrained, clause.connection);
    const auto mine = std::span(after).subspan(clause.connection * words, words);
    for (const ConnectionIndex c : clause.after) insert(mine, c);
    if (clause.after_any.empty()) continue;
    auto& list = any[clause.connection].emplace_back(words, 0);
    for (const ConnectionIndex c : clause.after_any) insert(list, c);
  }
  const Limits& limits = problem.limits();
  max_subassemblies = limits.max_subassemblies.value_or(kUnlimited);
  max_moved_parts = limits.max_moved_parts.value_or(kUnlimited);
  max_moved_mass = limits.max_moved_mass.value_or(kInfinity);
  blocking =
      std::ranges::any_of(problem.blockers(), [](const auto& list) { return !list.empty(); });
  cuts_checked =
      blocking || limits.max_subassemblies || limits.max_moved_parts || limits.max_moved_mass;

  // Objective.
  kind_of(problem.objective()).add_terms(problem.objective().parameters, 1, totals, terms);
  needs_movement = std::ranges::any_of(
      terms, [](const WeightedTerm& addend) { return !addend.term->sees.counting; });
  one_counting_term = terms.size() == 1 && terms[0].weight == 1 && !needs_movement;
  needs_sides = needs_movement || blocking || limits.max_moved_mass.has_value();
  set_situation(situation);
}

void Rules::set_situation(const Situation& situation) {
  const std::size_t connections = graph.num_connections();
  for (const ConnectionSet* set :
       {&situation.open, &situation.inaccessible, &situation.not_next, &situation.late}) {
    if (set->universe() != connections) {
      throw InputError("the situation is over " + std::to_string(set->universe()) +
                       " connections, the problem has " + std::to_string(connections));
    }
  }
  start = kept = not_next = late = ConnectionSet(connections);
  for_each_connection(situation.open.view(), [&](ConnectionIndex c) {
    if (situation.inaccessible.contains(c)) {
      kept.insert(c);
      ++num_kept;
      return;
    }
    start.insert(c);
    if (situation.not_next.contains(c)) not_next.insert(c);
    if (situation.late.contains(c)) late.insert(c);
  });
  ordered = !not_next.empty() || !late.empty();
  whole = start.size() == connections && !ordered;
}

// Precedence is written for disassembly: removing c needs every `after` gone. In assembly the step
// that makes c is the reverse of removing it from the state that follows, so there every `after`
// must still be missing. While c itself is handled it is there, in both directions.
bool Rules::precedence_met(SetView open, ConnectionIndex c) const {
  if (!contains(constrained, c)) return true;
  const std::uint64_t flip = assembly ? ~std::uint64_t{0} : 0;
  const std::uint64_t* const mine = after.data() + c * words;
  const std::uint64_t self = std::uint64_t{1} << (c % 64);
  const SetView stays = kept.view();
  for (std::size_t w = 0; w < words; ++w) {
    const std::uint64_t present = ((open[w] | stays[w]) ^ flip) | (w == c / 64 ? self : 0);
    if ((mine[w] & present) != 0) return false;
  }
  return std::ranges::all_of(any[c], [&](const std::vector<std::uint64_t>& list) {
    for (std::size_t w = 0; w < words; ++w) {
      const std::uint64_t present = ((open[w] | stays[w]) ^ flip) | (w == c / 64 ? self : 0);
      if ((list[w] & ~present) != 0) return true;
    }
    return false;
  });
}

}  // namespace orasp::detail
