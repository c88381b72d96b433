#include "orasp/model/transition_system.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "orasp/model/detail/step_scratch.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/tolerance.h"

namespace orasp {

using detail::at_most;
using detail::Facts;
using detail::Movement;
using detail::Side;
using detail::Term;
using detail::TermKind;

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

bool nearly_equal(double a, double b) {
  return std::abs(a - b) <= kRelativeTolerance * std::max(std::abs(a), std::abs(b));
}

}  // namespace

Expander::Scratch::Scratch(const Problem& the_problem, const TransitionSystem::Rules& the_rules)
    : problem(the_problem),
      rules(the_rules),
      present_words(the_rules.words),
      connectivity(the_rules.graph, the_rules.needs_sides || the_rules.assembly),
      mark(the_problem.num_parts(), 0) {
  actions.resize(problem.num_connections());
  for (const Term& term : rules.terms) {
    std::unique_ptr<Formula>& formula = formulas.emplace_back();
    tables.emplace_back();
    if (term.kind != TermKind::Expression) continue;
    if (!term.expression->compiler) {
      throw InputError(
          "objective: an expression needs a compiler (use parse_objective, or set "
          "Expression::compiler)");
    }
    formula = term.expression->compiler(term.expression->formula, term.expression->constants);
  }
}

SetView Expander::Scratch::present(SetView open) {
  if (!rules.assembly && rules.num_kept == 0) return open;
  const SetView kept = rules.kept.view();
  for (std::size_t w = 0; w < rules.words; ++w) present_words[w] = open[w] | kept[w];
  if (!rules.assembly) return present_words;
  for (std::uint64_t& word : present_words) word = ~word;
  const std::size_t tail = problem.num_connections() % 64;
  if (tail != 0) present_words.back() &= (std::uint64_t{1} << tail) - 1;
  if (problem.num_connections() == 0) present_words.back() = 0;
  return present_words;
}

// In disassembly.
std::span<const std::uint64_t> Expander::Scratch::present_of_all(
    std::span<const std::uint64_t> states) {
  if (rules.num_kept == 0) return states;
  const SetView kept = rules.kept.view();
  present_batch.assign(states.begin(), states.end());
  for (std::size_t i = 0; i < present_batch.size(); ++i) present_batch[i] |= kept[i % rules.words];
  return present_batch;
}

// Disassembly, after connectivity.analyse(): the piece that holds c falls apart into A and B.
[[gnu::always_inline]] inline Facts Expander::Scratch::removal_facts(ConnectionIndex c,
                                                                     std::size_t num_open) {
  Facts facts = counts(c, num_open);
  const std::uint32_t below = connectivity.below(c);
  facts.separates = below != 0;
  facts.subassemblies_joined = connectivity.subassemblies();
  facts.subassemblies_apart = facts.subassemblies_joined;
  if (!facts.separates) return facts;
  const std::uint32_t above = connectivity.piece(c) - below;
  const bool lower_is_a = connectivity.lower_end(c) == problem.ends(c)[0];
  facts.a_parts = lower_is_a ? below : above;
  facts.b_parts = lower_is_a ? above : below;
  facts.subassemblies_apart += std::size_t{below >= 2} + std::size_t{above >= 2};
  facts.subassemblies_apart -= 1;
  if (rules.needs_sides) {
    a = connectivity.lower_side(c);
    b = connectivity.upper_side(c);
    if (!lower_is_a) std::swap(a, b);
  }
  return facts;
}

// Assembly, after connectivity.analyse(): c joins the pieces of its two parts, if they are two.
Facts Expander::Scratch::joining_facts(ConnectionIndex c, std::size_t num_open) {
  Facts facts = counts(c, num_open);
  const auto [first, second] = problem.ends(c);
  facts.separates = !connectivity.same_piece(first, second);
  facts.subassemblies_apart = connectivity.subassemblies();
  facts.subassemblies_joined = facts.subassemblies_apart;
  if (!facts.separates) return facts;
  a = connectivity.piece_of(first);
  b = connectivity.piece_of(second);
  facts.a_parts = static_cast<std::uint32_t>(a.parts());
  facts.b_parts = static_cast<std::uint32_t>(b.parts());
  facts.subassemblies_joined += 1;
  facts.subassemblies_joined -= std::size_t{facts.a_parts >= 2} + std::size_t{facts.b_parts >= 2};
  return facts;
}

// One step on its own, by definition: take the connection away and see what hangs together. Shares
// nothing with the analysis of all steps at once; drawings and explanations use it.
Facts Expander::Scratch::flooded_facts(SetView open, ConnectionIndex c) {
  Facts facts = counts(c, count(open));
  const SetView there = present(open);
  const auto fill = [&](PartIndex start, std::vector<PartIndex>& parts) {
    parts.assign(1, start);
    mark[start] = 1;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      for (const auto& half : rules.graph.around(parts[i])) {
        if (half.connection == c || !contains(there, half.connection) || mark[half.other] != 0)
          continue;
        mark[half.other] = 1;
        parts.push_back(half.other);
      }
    }
  };
  // All pieces without c, then the two that c joins.
  std::size_t pieces = 0;
  for (PartIndex part = 0; part < problem.num_parts(); ++part) {
    if (mark[part] != 0) continue;
    fill(part, fill_a);
    if (fill_a.size() >= 2) ++pieces;
  }
  std::ranges::fill(mark, 0);
  const auto [first, second] = problem.ends(c);
  fill(first, fill_a);
  facts.separates = mark[second] == 0;
  fill_b.clear();
  if (facts.separates) fill(second, fill_b);
  std::ranges::fill(mark, 0);
  facts.subassemblies_apart = pieces;
  facts.subassemblies_joined = pieces;
  if (!facts.separates) return facts;
  std::ranges::sort(fill_a);
  std::ranges::sort(fill_b);
  a = {{fill_a, {}}};
  b = {{fill_b, {}}};
  facts.a_parts = static_cast<std::uint32_t>(fill_a.size());
  facts.b_parts = static_cast<std::uint32_t>(fill_b.size());
  facts.subassemblies_joined += 1;
  facts.subassemblies_joined -= std::size_t{fill_a.size() >= 2} + std::size_t{fill_b.size() >= 2};
  return facts;
}

double Expander::Scratch::mass(const Side& side) const {
  if (rules.uniform_mass) return static_cast<double>(side.parts()) * problem.parts().front().mass;
  double sum = 0;
  side.for_each([&](PartIndex part) { sum += problem.parts()[part].mass; });
  return sum;
}

// The moved piece of docs/format.md: the side with fewer parts moves; on a tie the lighter; on a
// tie the one that does not hold the earliest listed of their parts.
Movement Expander::Scratch::movement(const Facts& facts) const {
  Movement result;
  const double mass_a = mass(a);
  const double mass_b = mass(b);
  if (facts.a_parts != facts.b_parts) {
    result.a_moves = facts.a_parts < facts.b_parts;
  } else if (!nearly_equal(mass_a, mass_b)) {
    result.a_moves = mass_a < mass_b;
  } else {
    PartIndex first_a = kNone;
    PartIndex first_b = kNone;
    a.for_each([&](PartIndex part) { first_a = std::min(first_a, part); });
    b.for_each([&](PartIndex part) { first_b = std::min(first_b, part); });
    result.a_moves = first_b < first_a;
  }
  result.moved_mass = result.a_moves ? mass_a : mass_b;
  result.kept_mass = result.a_moves ? mass_b : mass_a;
  return result;
}

// Directions in which no part of A is blocked by a part of B. By antisymmetry B may leave A along
// their opposites, so it does not matter which of the two moves: the smaller one is looked at.
DirectionMask Expander::Scratch::free_directions() {
  const Side& few = a.parts() <= b.parts() ? a : b;
  const Side& many = a.parts() <= b.parts() ? b : a;
  DirectionMask blocked = 0;
  many.for_each([&](PartIndex part) { mark[part] = 1; });
  few.for_each([&](PartIndex part) {
    for (const Blocker& blocker : problem.blockers()[part]) {
      if (mark[blocker.by] != 0) blocked |= blocker.directions;
    }
  });
  many.for_each([&](PartIndex part) { mark[part] = 0; });
  return static_cast<DirectionMask>(problem.directions() & ~blocked);
}

bool Expander::Scratch::separation_legal(const Facts& facts) {
  if (facts.subassemblies_apart > rules.max_subassemblies) return false;
  if (std::min(facts.a_parts, facts.b_parts) > rules.max_moved_parts) return false;
  if (rules.max_moved_mass != kInfinity &&
      !at_most(movement(facts).moved_mass, rules.max_moved_mass))
    return false;
  return !rules.blocking || free_directions() != 0;
}

std::optional<double> Expander::Scratch::distance(bool a_moves, const Vector3& depot) const {
  const Side& moved = a_moves ? a : b;
  Vector3 sum{};
  bool known = true;
  moved.for_each([&](PartIndex part) {
    const auto& position_of_part = problem.parts()[part].position;
    if (!position_of_part) {
      known = false;
      return;
    }
    for (std::size_t i = 0; i < 3; ++i) sum[i] += (*position_of_part)[i];
  });
  if (!known) return std::nullopt;
  const auto n = static_cast<double>(moved.parts());
  return std::hypot(sum[0] / n - depot[0], sum[1] / n - depot[1], sum[2] / n - depot[2]);
}

double Expander::Scratch::checked(double reward, const Facts& facts) const {
  if (std::isfinite(reward)) return reward;
  throw InputError("objective: the reward of " +
                   std::string(rules.assembly ? "making " : "removing ") +
                   detail::in_quotes(problem.connection_id(facts.connection)) + " with " +
                   std::to_string(facts.before) + " connections present is " +
                   (std::isnan(reward) ? "not a number" : "infinite") + "; rewards must be finite");
}

// A formula of sizes alone: a hundred times quicker from a table.
double Expander::Scratch::sized_expression(const Term& term, const Facts& facts) const {
  const std::size_t moved = std::min(facts.a_parts, facts.b_parts);
  const std::size_t parts = facts.a_parts + facts.b_parts;
  std::vector<double>& table = tables[term.index];
  const std::size_t place = (parts * parts / 4 + moved) * 2 + (facts.completes ? 1 : 0);
  if (place >= table.size()) table.resize(place + 1, std::numeric_limits<double>::quiet_NaN());
  double& value = table[place];
  if (std::isnan(value)) {
    FormulaVariables variables;
    variables.separates = facts.separates ? 1 : 0;
    variables.completes = facts.completes ? 1 : 0;
    variables.moved_parts = static_cast<double>(moved);
    variables.kept_parts = static_cast<double>(parts - moved);
    value = checked(formulas[term.index]->value(variables), facts);
  }
  return value;
}

// The objectives that look inside the pieces.
double Expander::Scratch::moving_reward(const Term& term, std::size_t index, const Facts& facts,
                                        const Movement& movement) {
  const ConnectionIndex c = facts.connection;
  const double duration = problem.connections()[c].duration;
  const double moved_parts = std::min(facts.a_parts, facts.b_parts);
  switch (term.kind) {
    case TermKind::Time: {
      if (!facts.separates) return 0.0 - duration;
      return time_reward(term, duration, distance(movement.a_moves, term.depot));
    }
    case TermKind::Travel: {
      if (!facts.separates) return 0;
      const double metres = distance(movement.a_moves, term.depot).value_or(0);
      return 0.0 - moved_parts * metres * metres;
    }
    case TermKind::Fuel: return facts.separates ? fuel_reward(term, movement.moved_mass) : 0;
    case TermKind::Expression: {
      FormulaVariables variables;
      variables.before = static_cast<double>(facts.before);
      variables.after = static_cast<double>(facts.after);
      variables.separates = facts.separates ? 1 : 0;
      variables.completes = facts.completes ? 1 : 0;
      variables.subassemblies = static_cast<double>(rules.assembly ? facts.subassemblies_joined
                                                                   : facts.subassemblies_apart);
      variables.duration = duration;
      variables.index = c;
      if (facts.separates) {
        variables.moved_parts = moved_parts;
        variables.kept_parts = std::max(facts.a_parts, facts.b_parts);
        variables.moved_mass = movement.moved_mass;
        variables.kept_mass = movement.kept_mass;
        variables.distance = distance(movement.a_moves, term.depot).value_or(0);
      }
      return checked(formulas[index]->value(variables), facts);
    }
    case TermKind::Callable: return checked(term.callable->reward(full_step(facts)), facts);
    default: break;
  }
  assert(false);
  return 0;
}

// The objectives that look at nothing but sizes and positions in the plan.
[[gnu::always_inline]] inline double Expander::Scratch::counting_reward(const Term& term,
                                                                        const Facts& facts) const {
  switch (term.kind) {
    case TermKind::Indexed: {
      const auto n = static_cast<double>(facts.before);
      const double i = facts.connection;
      return i < n - 1 ? n - i : -1;
    }
    case TermKind::CubesatZone: {
      const PartIndex part = problem.ends(facts.connection)[0];
      const bool whole = facts.a_parts + facts.b_parts == rules.graph.starting_piece(part);
      return size_reward(term, facts.a_parts, facts.b_parts, facts.completes, whole);
    }
    case TermKind::Fuel:
      return facts.separates
                 ? fuel_reward(term, std::min(facts.a_parts, facts.b_parts) * term.part_mass)
                 : 0;
    case TermKind::Time: {
      const double duration = problem.connections()[facts.connection].duration;
      return facts.separates ? time_reward(term, duration, std::nullopt) : 0.0 - duration;
    }
    case TermKind::Expression: return sized_expression(term, facts);
    default: return size_reward(term, facts.a_parts, facts.b_parts, facts.completes, false);
  }
}

double Expander::Scratch::reward(const Facts& facts) {
  if (rules.one_counting_term) return counting_reward(rules.terms.front(), facts);
  Movement moved;
  if (rules.needs_movement && facts.separates) moved = movement(facts);
  double sum = 0;
  for (std::size_t i = 0; i < rules.terms.size(); ++i) {
    const Term& term = rules.terms[i];
    sum += term.weight *
           (term.counting ? counting_reward(term, facts) : moving_reward(term, i, facts, moved));
  }
  return sum;
}

// After connectivity's analysis of this state.
std::span<const Action> Expander::Scratch::legal_actions(SetView open) {
  Action* next = actions.data();
  const std::size_t num_open = count(open);
  if (rules.one_counting_term && !rules.assembly) {
    // The same as below with the questions left out whose answer is known.
    const Term& term = rules.terms.front();
    for_each_connection(open, [&](ConnectionIndex c) {
      if (contains(rules.constrained, c) && !rules.precedence_met(open, c)) return;
      const Facts facts = removal_facts(c, num_open);
      if (rules.cuts_checked && facts.separates && !separation_legal(facts)) return;
      *next++ = {c, counting_reward(term, facts)};
    });
    return in_order(open, {actions.data(), next});
  }
  for_each_connection(open, [&](ConnectionIndex c) {
    if (!rules.precedence_met(open, c)) return;
    const Facts facts = rules.assembly ? joining_facts(c, num_open) : removal_facts(c, num_open);
    if (rules.cuts_checked && facts.separates && !separation_legal(facts)) return;
    *next++ = {c, reward(facts)};
  });
  return in_order(open, {actions.data(), next});
}

// Leaves out what cannot be next, and what is late while something else can be done.
inline std::span<const Action> Expander::Scratch::in_order(SetView open,
                                                           std::span<Action> legal) const {
  if (!rules.ordered) return legal;
  const auto is_late = [&](const Action& action) { return rules.late.contains(action.connection); };
  auto end = legal.end();
  if (std::ranges::equal(open, rules.start.view())) {
    end = std::remove_if(legal.begin(), end, [&](const Action& action) {
      return rules.not_next.contains(action.connection);
    });
  }
  if (!std::all_of(legal.begin(), end, is_late)) end = std::remove_if(legal.begin(), end, is_late);
  return {legal.begin(), end};
}

Step Expander::Scratch::full_step(const Facts& facts) const {
  Step step;
  step.connection = facts.connection;
  step.before = facts.before;
  step.after = facts.after;
  step.separates = facts.separates;
  step.completes = facts.completes;
  step.subassemblies = rules.assembly ? facts.subassemblies_joined : facts.subassemblies_apart;
  if (!facts.separates) return step;
  const Movement moved = movement(facts);
  step.a_moves = moved.a_moves;
  step.moved_mass = moved.moved_mass;
  step.kept_mass = moved.kept_mass;
  a.for_each([&](PartIndex part) { step.a.push_back(part); });
  b.for_each([&](PartIndex part) { step.b.push_back(part); });
  std::ranges::sort(step.a);
  std::ranges::sort(step.b);
  return step;
}

// -------------------------------------------------------------------------------------------------

Expander::Expander(const TransitionSystem& system)
    : system_(system), scratch_(std::make_unique<Scratch>(system.problem_, *system.rules_)) {}
Expander::~Expander() = default;
Expander::Expander(Expander&&) noexcept = default;

std::span<const Action> Expander::legal_actions(SetView open) {
  Scratch& s = *scratch_;
  s.connectivity.analyse(s.present(open), s.rules.assembly);
  return s.legal_actions(open);
}

void Expander::load(std::span<const std::uint64_t> states) {
  static_assert(kBatch == detail::Connectivity::kLanes);
  Scratch& s = *scratch_;
  if (s.connectivity.takes_batches()) s.connectivity.analyse_batch(s.present_of_all(states));
}

std::span<const Action> Expander::loaded_actions(std::span<const std::uint64_t> states,
                                                 std::size_t i) {
  Scratch& s = *scratch_;
  const SetView open = states.subspan(i * s.rules.words, s.rules.words);
  if (!s.connectivity.takes_batches()) return legal_actions(open);
  s.connectivity.select(i);
  return s.legal_actions(open);
}

Step Expander::step(SetView open, ConnectionIndex connection) {
  assert(contains(open, connection));
  const Facts facts = scratch_->flooded_facts(open, connection);
  Step step = scratch_->full_step(facts);
  step.reward = scratch_->reward(facts);
  return step;
}

double Expander::completing_reward(SetView open, ConnectionIndex connection) {
  Facts facts = scratch_->flooded_facts(open, connection);
  facts.completes = true;
  return scratch_->reward(facts);
}

bool Expander::legal(SetView open, ConnectionIndex connection) {
  Scratch& s = *scratch_;
  return contains(open, connection) && s.constraints_met(open, connection) &&
         (!s.rules.ordered ||
          (!s.ruled_out_first(open, connection) && !s.waiting(open, connection)));
}

// The problem's own constraints.
bool Expander::Scratch::constraints_met(SetView open, ConnectionIndex c) {
  if (!rules.precedence_met(open, c)) return false;
  if (!rules.cuts_checked) return true;
  const Facts facts = flooded_facts(open, c);
  return !facts.separates || separation_legal(facts);
}

bool Expander::Scratch::ruled_out_first(SetView open, ConnectionIndex c) const {
  return rules.not_next.contains(c) && std::ranges::equal(open, rules.start.view());
}

// For a late connection, the first of the others that can be handled now.
std::optional<ConnectionIndex> Expander::Scratch::waiting(SetView open, ConnectionIndex c) {
  if (!rules.late.contains(c)) return std::nullopt;
  std::optional<ConnectionIndex> other;
  for_each_connection(open, [&](ConnectionIndex candidate) {
    if (!other && !rules.late.contains(candidate) && !ruled_out_first(open, candidate) &&
        constraints_met(open, candidate))
      other = candidate;
  });
  return other;
}

DirectionMask Expander::free_directions(SetView open, ConnectionIndex connection) {
  Scratch& s = *scratch_;
  if (s.problem.directions() == 0 || !s.flooded_facts(open, connection).separates) return 0;
  const DirectionMask free = s.free_directions();  // of the smaller side
  if (s.a.parts() <= s.b.parts()) return free;
  DirectionMask of_a = 0;
  for (std::size_t d = 0; d < kDirectionNames.size(); ++d) {
    if ((free >> d & 1U) != 0) of_a = static_cast<DirectionMask>(of_a | 1U << opposite(d));
  }
  return of_a;
}

// -------------------------------------------------------------------------------------------------
// Pieces on their own.

// -------------------------------------------------------------------------------------------------

TransitionSystem::TransitionSystem(const Problem& problem)
    : TransitionSystem(problem, Situation::whole(problem.num_connections())) {}
TransitionSystem::TransitionSystem(const Problem& problem, const Situation& situation)
    : problem_(problem),
      rules_(std::make_unique<const Rules>(problem, situation)),
      num_steps_(rules_->start.size()) {}
TransitionSystem::~TransitionSystem() = default;

const ConnectionSet& TransitionSystem::start() const {
  return rules_->start;
}

bool TransitionSystem::whole() const {
  return rules_->whole;
}

bool TransitionSystem::ordered() const {
  return rules_->ordered;
}

const ConnectionSet& TransitionSystem::kept() const {
  return rules_->kept;
}

Situation TransitionSystem::situation() const {
  Situation now{rules_->start, rules_->kept, rules_->not_next, rules_->late};
  for_each_connection(kept().view(), [&](ConnectionIndex c) { now.open.insert(c); });
  return now;
}

ConnectionSet TransitionSystem::present(SetView open) const {
  ConnectionSet there(num_connections());
  for (ConnectionIndex c = 0; c < num_connections(); ++c) {
    if ((contains(open, c) || kept().contains(c)) != rules_->assembly) there.insert(c);
  }
  return there;
}

std::size_t TransitionSystem::subassemblies(SetView present) const {
  std::size_t pieces = 0;
  rules_->graph.for_each_piece(present, [&](std::span<const PartIndex> piece) {
    if (piece.size() >= 2) ++pieces;
  });
  return pieces;
}

}  // namespace orasp
