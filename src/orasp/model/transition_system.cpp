#include "orasp/model/transition_system.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "orasp/model/detail/connectivity.h"
#include "orasp/model/detail/rules.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/tolerance.h"

namespace orasp {

using detail::kUnlimited;
using detail::Side;
using detail::Term;
using detail::TermKind;

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

bool at_most(double value, double limit) {
  return value <= limit + kRelativeTolerance * std::abs(limit);
}

bool nearly_equal(double a, double b) {
  return std::abs(a - b) <= kRelativeTolerance * std::max(std::abs(a), std::abs(b));
}

/// What a step is before its legality and reward are judged. A holds the connection's first part.
struct Facts {
  ConnectionIndex connection = 0;
  bool separates = false;
  bool completes = false;
  std::uint32_t a_parts = 0;
  std::uint32_t b_parts = 0;
  std::size_t before = 0;
  std::size_t after = 0;
  std::size_t subassemblies_apart = 0;   ///< without the connection
  std::size_t subassemblies_joined = 0;  ///< with it
};

/// Which side moves, and what it weighs.
struct Movement {
  bool a_moves = false;
  double moved_mass = 0;
  double kept_mass = 0;
};

}  // namespace

/// The rules, behind the header.
struct TransitionSystem::Rules : detail::Rules {
  using detail::Rules::Rules;
};

// -------------------------------------------------------------------------------------------------

/// Scratch memory of one thread, and the rules applied to facts.
struct Expander::Scratch {
  const Problem& problem;
  const TransitionSystem::Rules& rules;

  std::vector<Action> actions;
  std::vector<std::unique_ptr<Formula>> formulas;  ///< by term
  /// By term, for formulas of sizes alone: values met so far, NaN before; at ((moved + kept)^2 / 4
  /// + moved) * 2 + completes.
  mutable std::vector<std::vector<double>> tables;
  std::vector<std::uint64_t> present_words;  ///< where what is there differs from the open set
  std::vector<std::uint64_t> present_batch;  ///< the same for several states
  detail::Connectivity connectivity;
  Side
      /// Parts of A and B of the step at hand; set by whoever makes its Facts, if
      /// rules.needs_sides.
      a;
  Side b;
  std::vector<unsigned char> mark;  ///< by part; all 0 between uses
  std::vector<PartIndex> fill_a;
  std::vector<PartIndex> fill_b;

  Scratch(const Problem& the_problem, const TransitionSystem::Rules& the_rules);

  [[nodiscard]] SetView present(SetView open);
  [[nodiscard]] std::span<const std::uint64_t> present_of_all(
      std::span<const std::uint64_t> states);
  [[nodiscard]] Facts counts(ConnectionIndex c, std::size_t num_open) const;
  [[nodiscard]] Facts removal_facts(ConnectionIndex c, std::size_t num_open);
  [[nodiscard]] Facts joining_facts(ConnectionIndex c, std::size_t num_open);
  [[nodiscard]] Facts flooded_facts(SetView open, ConnectionIndex c);

  [[nodiscard]] double mass(const Side& side) const;
  [[nodiscard]] Movement movement(const Facts& facts) const;
  [[nodiscard]] DirectionMask free_directions();
  [[nodiscard]] bool separation_legal(const Facts& facts);
  [[nodiscard]] std::optional<double> distance(bool a_moves, const Vector3& depot) const;
  [[nodiscard]] double reward(const Facts& facts);
  [[nodiscard]] double counting_reward(const Term& term, const Facts& facts) const;
  [[nodiscard]] double sized_expression(const Term& term, const Facts& facts) const;
  [[nodiscard]] double checked(double reward, const Facts& facts) const;
  [[nodiscard]] double moving_reward(const Term& term, std::size_t index, const Facts& facts,
                                     const Movement& movement);
  [[nodiscard]] std::span<const Action> legal_actions(SetView open);
  [[nodiscard]] std::span<const Action> in_order(SetView open, std::span<Action> legal) const;
  [[nodiscard]] Step full_step(const Facts& facts) const;
  [[nodiscard]] bool constraints_met(SetView open, ConnectionIndex c);
  [[nodiscard]] bool ruled_out_first(SetView open, ConnectionIndex c) const;
  [[nodiscard]] std::optional<ConnectionIndex> waiting(SetView open, ConnectionIndex c);
};

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

[[gnu::always_inline]] inline Facts Expander::Scratch::counts(ConnectionIndex c,
                                                              std::size_t num_open) const {
  Facts facts;
  facts.connection = c;
  facts.before = num_open + rules.num_kept;
  if (rules.assembly) facts.before = problem.num_connections() - facts.before;
  facts.after = rules.assembly ? facts.before + 1 : facts.before - 1;
  facts.completes = num_open == 1;
  return facts;
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

inline double Expander::Scratch::reward(const Facts& facts) {
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

double Expander::own_reward(ConnectionIndex connection) {
  Facts facts = scratch_->counts(connection, 2);
  facts.completes = false;
  return scratch_->reward(facts);
}

std::optional<double> Expander::cut_gain(std::span<const PartIndex> a, std::span<const PartIndex> b,
                                         ConnectionIndex connection) {
  Scratch& s = *scratch_;
  Facts facts = s.counts(connection, 2);
  facts.completes = false;
  const double own = s.reward(facts);
  facts.separates = true;
  facts.a_parts = static_cast<std::uint32_t>(a.size());
  facts.b_parts = static_cast<std::uint32_t>(b.size());
  s.a = {{a, {}}};
  s.b = {{b, {}}};
  // How many subassemblies there are is not the piece's own matter: facts.subassemblies_apart is 0
  // here.
  if (s.rules.cuts_checked && !s.separation_legal(facts)) return std::nullopt;
  return s.reward(facts) - own;
}

double Expander::greatest_gain(std::size_t moved, std::size_t kept) {
  Scratch& s = *scratch_;
  double sum = 0;
  for (std::size_t i = 0; i < s.rules.terms.size(); ++i) {
    const Term& term = s.rules.terms[i];
    if (term.weight == 0) continue;
    double gain = kInfinity;
    switch (term.kind) {
      case TermKind::PieceCost:
      case TermKind::Completion:
        gain = term.weight * (size_reward(term, moved, kept, false, false) -
                              size_reward(term, 0, 0, false, false));
        break;
      case TermKind::CubesatZone:
        gain = std::max(term.weight * size_reward(term, moved, kept, false, false),
                        term.weight * size_reward(term, moved, kept, false, true));
        break;
      case TermKind::Fuel: {
        const auto& lightest = s.rules.lightest;
        const auto& heaviest = s.rules.heaviest;
        gain = term.weight * fuel_reward(term, term.weight > 0 ? lightest[moved] : heaviest[moved]);
        break;
      }
      case TermKind::Time:
        if (term.counting) {
          gain = term.weight * (0.0 - term.q);
        } else if (term.weight > 0) {
          gain = 0;
        } else {
          gain = 0.0 - term.weight * std::max(term.q, 2 * s.rules.farthest[i] / term.p);
        }
        break;
      case TermKind::Travel: {
        const double most = static_cast<double>(moved) * s.rules.farthest[i] * s.rules.farthest[i];
        gain = term.weight > 0 ? 0.0 : 0.0 - term.weight * most;
        break;
      }
      case TermKind::Expression: {
        if (!term.gain_by_sizes) break;
        FormulaVariables variables;
        const double own = s.formulas[i]->value(variables);
        variables.separates = 1;
        variables.moved_parts = static_cast<double>(moved);
        variables.kept_parts = static_cast<double>(kept);
        gain = term.weight * (s.formulas[i]->value(variables) - own);
        if (!std::isfinite(gain)) gain = kInfinity;
        break;
      }
      case TermKind::Indexed:
      case TermKind::Callable: break;
    }
    sum += gain;
  }
  return sum;
}

double Expander::greatest_gain_of_moving(std::span<const PartIndex> moved) {
  Scratch& s = *scratch_;
  s.a = {{moved, {}}};
  double sum = 0;
  for (const Term& term : s.rules.terms) {
    if (term.weight == 0) continue;
    double gain = kInfinity;
    switch (term.kind) {
      case TermKind::Fuel: gain = term.weight * fuel_reward(term, s.mass(s.a)); break;
      case TermKind::Time:
        gain = term.weight * time_reward(term, 0, s.distance(true, term.depot));
        break;
      case TermKind::Travel: {
        const double metres = s.distance(true, term.depot).value_or(0);
        gain = 0.0 - term.weight * static_cast<double>(moved.size()) * metres * metres;
        break;
      }
      default: break;
    }
    sum += gain;
  }
  return sum;
}

bool Expander::moving_more_costs_more() const {
  return std::ranges::all_of(scratch_->rules.terms, [](const Term& term) {
    return term.weight >= 0 &&
           (term.kind == TermKind::Fuel || (term.kind == TermKind::Time && term.counting));
  });
}

double Expander::completion_surplus(ConnectionIndex connection) {
  Scratch& s = *scratch_;
  const auto& ends = s.problem.ends(connection);
  Facts facts = s.counts(connection, 1);
  facts.separates = ends[0] != ends[1];
  if (s.rules.num_kept > 0) {
    ConnectionSet alone(system_.num_connections());
    alone.insert(connection);
    facts = s.flooded_facts(alone.view(), connection);
  } else if (facts.separates) {
    facts.a_parts = facts.b_parts = 1;
    facts.subassemblies_joined = 1;
    s.a = {{std::span(ends).first(1), {}}};
    s.b = {{std::span(ends).last(1), {}}};
  }
  const double last = s.reward(facts);
  facts.completes = false;
  return last - s.reward(facts);
}

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

// Precedence holds `connection` until `other` is gone, which stays.
Violation TransitionSystem::waits_in_vain(ConnectionIndex connection, ConnectionIndex other,
                                          std::size_t entry) const {
  const std::string id = detail::in_quotes(problem_.connection_id(connection));
  const std::string other_id = detail::in_quotes(problem_.connection_id(other));
  return {Constraint::Precedence,
          "precedence[" + std::to_string(entry) + "]",
          rules_->assembly ? id + " must be made before " + other_id + ", which is made already"
                           : id + " waits for " + other_id + ", which is inaccessible",
          {other}};
}

std::optional<Violation> TransitionSystem::infeasibility() const {
  const Rules& rules = *rules_;
  // In disassembly order: the state at which it begins (in assembly, the one that is the goal), and
  // what it ends with.
  const ConnectionSet none(num_connections());
  const ConnectionSet first = present(rules.assembly ? none.view() : start().view());
  const ConnectionSet last = present(rules.assembly ? start().view() : none.view());
  const std::size_t start_pieces = subassemblies(first.view());
  if (num_steps() > 0 && start_pieces > rules.max_subassemblies) {
    return Violation{Constraint::MaxSubassemblies,
                     "limits.max_subassemblies",
                     (rules.whole ? "the whole product is " : "the product as it stands is ") +
                         std::to_string(start_pieces) + " subassemblies; at most " +
                         std::to_string(rules.max_subassemblies) + " are allowed",
                     {}};
  }
  // Precedence alone, in disassembly order: remove whatever may go until nothing more may. The
  // clauses are monotone, so if connections are left, each of them waits for another that stays,
  // and following these ends in a cycle, or at one that is kept. Every clause is looked at again
  // only when a connection that it names goes.
  std::vector<bool> stays(num_connections());
  for (ConnectionIndex c = 0; c < num_connections(); ++c) stays[c] = first.contains(c);
  std::vector<std::vector<ConnectionIndex>> waiting(num_connections());
  for (const PrecedenceClause& clause : problem_.precedence()) {
    for (const ConnectionIndex c : clause.after) waiting[c].push_back(clause.connection);
    for (const ConnectionIndex c : clause.after_any) waiting[c].push_back(clause.connection);
  }
  std::vector<std::vector<const PrecedenceClause*>> clauses(num_connections());
  for (const PrecedenceClause& clause : problem_.precedence())
    clauses[clause.connection].push_back(&clause);
  /// A connection that `c` waits for and the entry that says so.
  const auto waits_for =
      [&](ConnectionIndex c) -> std::optional<std::pair<ConnectionIndex, std::size_t>> {
    for (const PrecedenceClause* clause : clauses[c]) {
      for (const ConnectionIndex other : clause->after) {
        if (stays[other]) return std::pair{other, clause->entry};
      }
      if (!clause->after_any.empty() &&
          std::ranges::all_of(clause->after_any,
                              [&](ConnectionIndex other) { return stays[other]; })) {
        return std::pair{clause->after_any.front(), clause->entry};
      }
    }
    return std::nullopt;
  };
  std::vector<ConnectionIndex> check(num_connections());
  std::iota(check.begin(), check.end(), ConnectionIndex{0});
  std::size_t left = num_steps();
  while (!check.empty()) {
    const ConnectionIndex c = check.back();
    check.pop_back();
    if (!stays[c] || last.contains(c) || waits_for(c)) continue;
    stays[c] = false;
    --left;
    check.insert(check.end(), waiting[c].begin(), waiting[c].end());
  }
  if (left == 0) return std::nullopt;
  // Walk from the first that is left until a connection comes up again: from there on it is the
  // cycle. Or until one that is kept comes up.
  std::vector<std::size_t> met(num_connections(), kUnlimited);
  std::vector<std::pair<ConnectionIndex, std::size_t>> path;
  ConnectionIndex c = 0;
  while (!stays[c] || last.contains(c)) ++c;
  while (met[c] == kUnlimited) {
    if (last.contains(c)) return waits_in_vain(path.back().first, c, path.back().second);
    met[c] = path.size();
    const auto next = waits_for(c);
    path.emplace_back(c, next->second);
    c = next->first;
  }
  Violation violation;
  violation.constraint = Constraint::Precedence;
  std::string chain;
  for (std::size_t i = met[c]; i < path.size(); ++i) {
    const ConnectionIndex next = i + 1 < path.size() ? path[i + 1].first : c;
    violation.blocking_connections.push_back(path[i].first);
    chain += (chain.empty() ? "" : ", ") +
             detail::in_quotes(problem_.connection_id(path[i].first)) + " after " +
             detail::in_quotes(problem_.connection_id(next)) + " (precedence[" +
             std::to_string(path[i].second) + "])";
  }
  violation.where = "precedence[" + std::to_string(path[met[c]].second) + "]";
  violation.message = "precedence is a cycle: " + chain;
  std::ranges::sort(violation.blocking_connections);
  return violation;
}

RewardRange TransitionSystem::reward_range(ConnectionIndex connection, std::size_t open,
                                           bool completes) const {
  const Rules& rules = *rules_;
  const double duration = problem_.connections()[connection].duration;
  RewardRange sum{0, 0};
  for (std::size_t i = 0; i < rules.terms.size(); ++i) {
    const Term& term = rules.terms[i];
    RewardRange range{0, 0};
    switch (term.kind) {
      case TermKind::PieceCost: {
        if (completes) {
          range = {term.q, term.q};
          break;
        }
        const auto costs =
            std::span(term.piece_cost).subspan(std::min<std::size_t>(1, term.piece_cost.size()));
        if (costs.empty()) break;
        const auto [cheapest, dearest] = std::ranges::minmax(costs);
        range = {0.0 - term.p - std::max(0.0, 2 * dearest),
                 0.0 - term.p - std::min(0.0, 2 * cheapest)};
        break;
      }
      case TermKind::CubesatZone:
        range = completes ? RewardRange{1, 1} : RewardRange{-2 * 0.0967, 0};
        break;
      case TermKind::Indexed: {
        // `before` is at most `open` and what is kept in disassembly, and at most all but one in
        // assembly; the reward grows with it.
        const double most =
            static_cast<double>(rules.assembly ? num_connections() - 1 : open + rules.num_kept);
        range = {-1, connection < most - 1 ? most - connection : -1.0};
        break;
      }
      case TermKind::Time: {
        const double transfer = std::max(term.q, 2 * rules.farthest[i] / term.p);
        range = {0.0 - duration - transfer, 0.0 - duration};
        break;
      }
      case TermKind::Travel: {
        const double parts = static_cast<double>(problem_.num_parts() / 2);
        range = {0.0 - parts * rules.farthest[i] * rules.farthest[i], 0};
        break;
      }
      case TermKind::Fuel: range = {0.0 - (2 * term.p + rules.total_mass) * term.q, 0}; break;
      case TermKind::Completion: {
        const double always = (completes ? term.r : 0.0) - term.q;
        range = {always + std::min(0.0, term.p), always + std::max(0.0, term.p)};
        break;
      }
      case TermKind::Expression: range = {-kInfinity, kInfinity}; break;
      case TermKind::Callable: range = {term.callable->least, term.callable->greatest}; break;
    }
    if (term.weight == 0) continue;
    sum.least += term.weight > 0 ? term.weight * range.least : term.weight * range.greatest;
    sum.greatest += term.weight > 0 ? term.weight * range.greatest : term.weight * range.least;
  }
  return sum;
}

bool TransitionSystem::sees_piece_only() const {
  return std::ranges::all_of(rules_->terms, &Term::piece_only);
}

bool TransitionSystem::gain_by_sizes() const {
  return std::ranges::all_of(rules_->terms, &Term::gain_by_sizes);
}

bool TransitionSystem::gain_by_connection() const {
  return std::ranges::any_of(rules_->terms, &Term::gain_by_connection);
}

bool TransitionSystem::sees_sizes_only() const {
  return std::ranges::all_of(rules_->terms,
                             [](const Term& term) { return detail::sees_sizes_only(term.kind); });
}

double TransitionSystem::greatest_size_reward(std::size_t a, std::size_t b, bool completes) const {
  double sum = 0;
  for (const Term& term : rules_->terms) {
    const double inside = size_reward(term, a, b, completes, false);
    const double whole = size_reward(term, a, b, completes, true);
    sum += std::max(term.weight * inside, term.weight * whole);
  }
  return sum;
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
