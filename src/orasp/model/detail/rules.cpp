#include "orasp/model/detail/rules.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
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
  const std::size_t asked = addend.term->sees.range_by_connection ? problem.num_connections() : 1;
  for (std::size_t c = 0; c < asked; ++c) {
    question.connection = static_cast<ConnectionIndex>(c);
    for (const bool completes : {false, true}) {
      question.completes = completes;
      const RewardRange range = addend.term->range(question);
      size = std::max({size, std::abs(range.least), std::abs(range.greatest)});
    }
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
  cuts_checked = blocking || limits.any();
  fixed_parts = !problem.base().empty();
  grounded = limits.grounded;

  // Objective.
  kind_of(problem.objective()).add_terms(problem.objective().parameters, 1, totals, terms);
  needs_movement = std::ranges::any_of(
      terms, [](const WeightedTerm& addend) { return !addend.term->sees.counting; });
  needs_elapsed = std::ranges::any_of(
      terms, [](const WeightedTerm& addend) { return addend.term->sees.elapsed; });
  size_up_rewards(problem);
  one_counting_term =
      terms.size() == 1 && terms[0].weight == 1 && !needs_movement && !checks_rewards;
  needs_sides = needs_movement || blocking || limits.max_moved_mass.has_value() || grounded ||
                (fixed_parts && limits.max_moved_parts);
  const bool from_both_ends = !made_any.empty() && std::ranges::any_of(any, [](const auto& lists) {
    return !lists.empty();
  });
  set_wide(problem, situation);
  may_shut_out = cuts_checked || from_both_ends || by_part;
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

void Rules::set_wide(const Problem& problem, const Situation& situation) {
  by_part = problem.spec().action == StepKind::Part;
  has_goal = problem.spec().goal.has_value();
  may_stop = has_goal && problem.spec().goal->stop == Goal::Stop::Best;
  const bool looks_back = std::ranges::any_of(
      terms, [](const WeightedTerm& addend) { return addend.term->sees.looks_back; });
  wide = by_part || has_goal || looks_back;
  if (!wide) return;
  needs_sides = needs_movement = true;
  cuts_checked = cuts_checked || by_part;
  one_counting_term = false;
  if (has_goal) {
    goal.assign(words, 0);
    for (const ConnectionIndex c : problem.goal()) insert(goal, c);
  }
  if (!looks_back) return;
  const auto take_room = [this](std::uint64_t numbers, std::uint64_t& room) {
    const std::uint64_t stride = room;
    if (room > std::numeric_limits<std::uint64_t>::max() / std::max<std::uint64_t>(1, numbers))
      throw InputError(
          "objective: the attributes that it looks back at have too many values together; the "
          "numbers of values, multiplied, must stay below 2^64");
    room *= numbers;
    return stride;
  };
  std::uint64_t room = 1;
  for (const AttributeValues& attribute : totals.attributes) {
    context.radix.push_back(attribute.values.size() + 1);
    context.stride.push_back(take_room(context.radix.back(), room));
    std::vector<std::uint64_t>& with_value = context.with_value.emplace_back();
    if (attribute.of_connection.empty()) continue;
    with_value.assign(words, 0);
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
      if (attribute.of_connection[c] != 0) insert(with_value, c);
    }
  }
  context.words = 1;
  if (!totals.looks_at_places) return;
  std::map<Vector3, std::uint32_t> number;
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const Vector3 place = problem.place(c).value_or(Vector3{});
    const auto [entry, is_new] =
        number.try_emplace(place, static_cast<std::uint32_t>(context.places.size() + 1));
    if (is_new) context.places.push_back(place);
    context.place_of.push_back(entry->second);
  }
  if (situation.last_place && !number.contains(*situation.last_place))
    context.places.push_back(*situation.last_place);
  context.coordinates = by_part;
  context.place_stride = take_room(by_part ? 2 : context.places.size() + 1, room);
  if (by_part) context.words += 3;
}

Rules::Words Rules::start_context(const Situation& situation) const {
  Words found(context.words, 0);
  for (std::size_t i = 0; i < totals.attributes.size() && context.words > 0; ++i) {
    const AttributeValues& attribute = totals.attributes[i];
    const auto value = situation.in_force.find(attribute.name);
    if (value == situation.in_force.end()) continue;
    const auto known = std::ranges::find(attribute.values, value->second);
    if (known == attribute.values.end())
      throw InputError("no step has the value " + in_quotes(value->second) + " of " +
                       in_quotes(attribute.name) + ", which is said to be in force");
    found[0] +=
        static_cast<std::uint64_t>(known - attribute.values.begin() + 1) * context.stride[i];
  }
  if (context.place_stride == 0 || !situation.last_place) return found;
  if (!context.coordinates) {
    const auto place = std::ranges::find(context.places, *situation.last_place);
    found[0] +=
        static_cast<std::uint64_t>(place - context.places.begin() + 1) * context.place_stride;
    return found;
  }
  found[0] += context.place_stride;
  for (std::size_t axis = 0; axis < 3; ++axis)
    found[1 + axis] = std::bit_cast<std::uint64_t>((*situation.last_place)[axis] + 0.0);
  return found;
}

bool Rules::state_allowed(SetView open) const {
  if (after.empty()) return true;
  const auto is_there = [&](std::size_t w) {
    return making ? ~(open[w] | kept.view()[w]) : open[w] | kept.view()[w];
  };
  for (ConnectionIndex c = 0; c < graph.num_connections(); ++c) {
    const bool there = (is_there(c / 64) >> (c % 64) & 1U) != 0;
    if (there) {
      if (made_any.empty()) continue;
      for (const Words& list : made_any[c]) {
        bool held = false;
        for (std::size_t w = 0; w < words && !held; ++w) {
          const std::uint64_t self = w == c / 64 ? std::uint64_t{1} << (c % 64) : 0;
          held = (list[w] & is_there(w) & ~self) != 0;
        }
        if (!held) return false;
      }
      continue;
    }
    // What stays away from an assembly waits for nothing.
    if (assembly && kept.contains(c) && making) continue;
    for (std::size_t w = 0; w < words; ++w) {
      const std::uint64_t self = w == c / 64 ? std::uint64_t{1} << (c % 64) : 0;
      if ((after[c * words + w] & (is_there(w) | self)) != 0) return false;
    }
    for (const Words& list : any[c]) {
      bool can_go = false;
      for (std::size_t w = 0; w < words && !can_go; ++w) {
        const std::uint64_t self = w == c / 64 ? std::uint64_t{1} << (c % 64) : 0;
        can_go = (list[w] & ~(is_there(w) | self)) != 0;
      }
      if (!can_go) return false;
    }
  }
  return true;
}

bool Rules::precedence_met_within(SetView open, std::span<const ConnectionIndex> handled) const {
  if (after.empty()) return true;
  return std::ranges::all_of(handled, [&](ConnectionIndex c) {
    for (std::size_t w = 0; w < words; ++w) {
      const std::uint64_t self = w == c / 64 ? std::uint64_t{1} << (c % 64) : 0;
      if ((after[c * words + w] & (open[w] | self)) != 0) return false;
    }
    return true;
  });
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
