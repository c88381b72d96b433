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
  size_up_rewards(problem);
  one_counting_term =
      terms.size() == 1 && terms[0].weight == 1 && !needs_movement && !checks_rewards;
  needs_sides = needs_movement || blocking || limits.max_moved_mass.has_value();
  set_situation(situation);
}

void Rules::set_situation(const Situation& situation) {
  const std::size_t connections = graph.num_connections();
  situation.require_over(connections);
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
