#include "orasp/model/detail/rules.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>

#include "orasp/model/detail/reward_size.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/objectives/objective_kind.h"
#include "orasp/model/tolerance.h"

namespace orasp::detail {

namespace {

void insert(std::span<std::uint64_t> set, ConnectionIndex c) {
  set[c / 64] |= std::uint64_t{1} << (c % 64);
}

/// The greatest size of what the term adds to a reward; empty where that shows step by step alone.
std::optional<double> greatest_size(const WeightedTerm& addend, const Problem& problem) {
  if (addend.weight == 0) return 0;
  if (addend.term->sees.calls_out) return std::nullopt;
  // A range depends on the connection by its duration, or by its place, which is no large number.
  RangeQuestion question;
  question.most_before = static_cast<double>(problem.num_connections());
  for (const Connection& connection : problem.connections())
    question.duration = std::max(question.duration, connection.duration);
  double size = 0;
  if (const SizeCosts* const all = addend.term->size_costs()) {
    double dearest = 0;
    for (const double cost : all->costs) dearest = std::max(dearest, std::abs(cost));
    size = std::max({std::abs(all->last[0]), std::abs(all->last[1]), std::abs(all->alone),
                     std::abs(all->base) + 2 * dearest});
    return std::abs(addend.weight) * size;
  }
  for (const bool completes : {false, true}) {
    question.completes = completes;
    const RewardRange range = addend.term->range(question);
    size = std::max({size, std::abs(range.least), std::abs(range.greatest)});
  }
  if (!std::isfinite(size)) return std::nullopt;
  return std::abs(addend.weight) * size;
}

}  // namespace

Rules::Rules(const Problem& problem, const Situation& situation, Walk walk)
    : assembly(problem.direction() == Direction::Assembly),
      making(assembly && walk == Walk::Forwards),
      words(words_for(problem.num_connections())),
      graph(problem),
      totals(problem, graph) {
  set_precedence(problem);
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
  size_up_rewards(problem);
  one_counting_term =
      terms.size() == 1 && terms[0].weight == 1 && !needs_movement && !checks_rewards;
  needs_sides = needs_movement || blocking || limits.max_moved_mass.has_value();
  const bool from_both_ends = !made_any.empty() && std::ranges::any_of(any, [](const auto& lists) {
    return !lists.empty();
  });
  may_shut_out = cuts_checked || from_both_ends;
  set_situation(situation);
}

void Rules::set_precedence(const Problem& problem) {
  const std::size_t connections = problem.num_connections();
  constrained.assign(words, 0);
  if (problem.precedence().empty()) return;
  const auto row = [this](Words& rows, ConnectionIndex c) {
    return std::span(rows).subspan(c * words, words);
  };
  const auto list_of = [this](const std::vector<ConnectionIndex>& members) {
    Words list(words, 0);
    for (const ConnectionIndex c : members) insert(list, c);
    return list;
  };
  const bool any_made_after_any = std::ranges::any_of(
      problem.precedence(),
      [](const PrecedenceClause& clause) { return !clause.made_after_any.empty(); });
  after.assign(connections * words, 0);
  any.resize(connections);
  if (making || any_made_after_any) before.assign(connections * words, 0);
  if (any_made_after_any) made_any.resize(connections);
  named_in.resize(connections);
  for (const PrecedenceClause& clause : problem.precedence()) {
    const ConnectionIndex c = clause.connection;
    insert(constrained, c);
    for (const ConnectionIndex other : clause.after) {
      insert(row(after, c), other);
      if (!before.empty()) insert(row(before, other), c);
      if (making) insert(constrained, other);
    }
    if (!clause.after_any.empty()) any[c].push_back(list_of(clause.after_any));
    if (!clause.made_after_any.empty()) made_any[c].push_back(list_of(clause.made_after_any));
    const bool ahead = making ? !clause.after_any.empty() : !clause.made_after_any.empty();
    if (!ahead) continue;
    const ListOfMany list{c, (making ? any : made_any)[c].size() - 1};
    for (const ConnectionIndex other : making ? clause.after_any : clause.made_after_any) {
      named_in[other].push_back(list);
      insert(constrained, other);
    }
  }
}

void Rules::set_situation(const Situation& situation) {
  const std::size_t connections = graph.num_connections();
  situation.require_over(connections);
  start = kept = not_next = late = ConnectionSet(connections);
  for_each_connection(situation.open.view(), [&](ConnectionIndex c) {
    if (situation.inaccessible.contains(c)) {
      kept.insert(c);
      return;
    }
    start.insert(c);
    if (situation.not_next.contains(c)) not_next.insert(c);
    if (situation.late.contains(c)) late.insert(c);
  });
  ordered = !not_next.empty() || !late.empty();
  whole = start.size() == connections && !ordered;
  if (assembly && !making) {
    // What is made already stays, and what is inaccessible is never there.
    kept = ConnectionSet(connections);
    for (ConnectionIndex c = 0; c < connections; ++c) {
      if (!situation.open.contains(c)) kept.insert(c);
    }
  }
  num_kept = kept.size();
  num_steps = start.size();
}

bool Rules::precedence_met(SetView open, ConnectionIndex c) const {
  if (!contains(constrained, c)) return true;
  // Its own clauses, as one who removes it from the state with it sees them. A connection that is
  // handled is itself there: nothing goes before or after itself.
  const std::uint64_t* const mine = after.data() + c * words;
  for (std::size_t w = 0; w < words; ++w) {
    const std::uint64_t self = w == c / 64 ? std::uint64_t{1} << (c % 64) : 0;
    if ((mine[w] & (there_without(open, c, w) | self)) != 0) return false;
  }
  const bool can_go = std::ranges::all_of(any[c], [&](const Words& list) {
    for (std::size_t w = 0; w < words; ++w) {
      const std::uint64_t self = w == c / 64 ? std::uint64_t{1} << (c % 64) : 0;
      if ((list[w] & ~(there_without(open, c, w) | self)) != 0) return true;
    }
    return false;
  });
  if (!can_go) return false;
  if (making) {
    // What must be made before it, unless it is given up.
    const std::uint64_t* const others = before.data() + c * words;
    for (std::size_t w = 0; w < words; ++w) {
      if ((others[w] & open[w]) != 0) return false;
    }
    const auto is_held = [&](const Words& list) {
      for (std::size_t w = 0; w < words; ++w) {
        if ((list[w] & there_without(open, c, w)) != 0) return true;
      }
      return false;
    };
    if (!made_any.empty() && !std::ranges::all_of(made_any[c], is_held)) return false;
  }
  return named_in[c].empty() || lists_shut(open, c).empty();
}

std::vector<Rules::ListOfMany> Rules::lists_shut(SetView open, ConnectionIndex c) const {
  // In assembly: take off whatever may go of what is missing, from the product that has it all.
  // In disassembly: put on whatever may be put on of what is there, upon what stays. `left` ends as
  // what cannot.
  Words left(words);
  Words there(words);  // in assembly with what is missing, in disassembly what is put on
  for (std::size_t w = 0; w < words; ++w) {
    const std::uint64_t self = w == c / 64 ? std::uint64_t{1} << (c % 64) : 0;
    const std::uint64_t without = there_without(open, c, w);
    if (making) {
      left[w] = open[w] & ~self;
      there[w] = without | open[w];
    } else {
      left[w] = without & ~kept.view()[w];
      there[w] = kept.view()[w];
    }
  }
  const auto may_go = [&](ConnectionIndex one) {
    for (std::size_t w = 0; w < words; ++w) {
      if ((after[one * words + w] & there[w]) != 0) return false;
    }
    return std::ranges::all_of(any[one], [&](const Words& list) {
      for (std::size_t w = 0; w < words; ++w) {
        if ((list[w] & ~there[w]) != 0) return true;
      }
      return false;
    });
  };
  const auto may_be_put_on = [&](ConnectionIndex one) {
    for (std::size_t w = 0; w < words; ++w) {
      if ((before[one * words + w] & left[w]) != 0) return false;
    }
    return std::ranges::all_of(made_any[one], [&](const Words& list) {
      for (std::size_t w = 0; w < words; ++w) {
        if ((list[w] & there[w]) != 0) return true;
      }
      return false;
    });
  };
  for (bool moving = true; moving;) {
    moving = false;
    for_each_connection(left, [&](ConnectionIndex one) {
      if (!(making ? may_go(one) : may_be_put_on(one))) return;
      const std::uint64_t bit = std::uint64_t{1} << (one % 64);
      left[one / 64] &= ~bit;
      there[one / 64] ^= bit;
      moving = true;
    });
  }
  std::vector<ListOfMany> shut;
  for (const ListOfMany& named : named_in[c]) {
    // What stays in a disassembly goes on to need one of its list.
    const bool stays = !assembly && kept.contains(named.connection);
    if (!stays && !contains(left, named.connection)) continue;
    const Words& list = (making ? any : made_any)[named.connection][named.list];
    bool met = false;
    for (std::size_t w = 0; w < words && !met; ++w) {
      const std::uint64_t meets = making ? ~there[w] : stays ? there[w] | left[w] : there[w];
      met = (list[w] & meets) != 0;
    }
    if (!met) shut.push_back(named);
  }
  return shut;
}

/// Refuses rewards whose sums may not be finite, where their sizes are known.
void Rules::size_up_rewards(const Problem& problem) {
  double known = 0;
  for (const WeightedTerm& addend : terms) {
    const std::optional<double> size = greatest_size(addend, problem);
    // A single formula or function checks what it yields itself.
    const bool checks_itself =
        addend.term->sees.calls_out && terms.size() == 1 && addend.weight == 1;
    if (!size && !checks_itself) checks_rewards = true;
    known += size.value_or(0);
  }
  if (known <= largest_reward(problem.num_connections())) return;
  throw InputError("objective: a step may earn or cost " + number_text(known) + ", and " +
                   std::to_string(problem.num_connections()) +
                   " such steps add up to no finite number; choose larger units");
}

}  // namespace orasp::detail
