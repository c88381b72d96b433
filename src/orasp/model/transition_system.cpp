#include "orasp/model/transition_system.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "orasp/model/detail/connectivity.h"
#include "orasp/model/detail/wording.h"

namespace orasp {

using detail::Side;

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kUnlimited = std::numeric_limits<std::size_t>::max();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kStandardGravity = 9.80665;  // m/s^2

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

enum class TermKind {
  PieceCost,
  CubesatZone,
  Indexed,
  Time,
  Travel,
  Fuel,
  Completion,
  Expression,
  Callable
};

/// One addend of the objective with its parameters resolved.
struct Term {
  TermKind kind = TermKind::PieceCost;
  double weight = 1;
  std::vector<double> piece_cost;  ///< by number of parts
  double p = 0;  ///< PieceCost: operation; Time: speed; Fuel: dry mass; Completion: join
  double q = 0;  ///< PieceCost: completion; Time: transfer; Fuel: e^k - 1; Completion: step
  double r = 0;  ///< Completion: bonus
  Vector3 depot{};
  const Expression* expression = nullptr;
  const Callable* callable = nullptr;
  /// The reward depends on sizes and counts only, not on which parts are on which side: always so for some kinds, and for
  /// Fuel where all masses are equal (to `part_mass`), for Time where no part has a position.
  bool counting = false;
  double part_mass = 0;  ///< kg
};

double zone_cost(std::size_t parts, std::size_t piece_parts, bool whole_start) {
  switch (parts) {
    case 1: return piece_parts >= 4 || whole_start ? 0.0967 : 0.0823;
    case 2: return 0.0722;
    case 3: return 0.0782;
    default: return 0;
  }
}

double fuel_reward(const Term& term, double moved_mass) {
  return 0.0 - (term.p * term.q + (term.p + moved_mass) * term.q);
}

double time_reward(const Term& term, double duration, std::optional<double> metres) {
  return 0.0 - (duration + (metres ? 2 * *metres / term.p : term.q));
}

/// The objectives that see nothing but sizes: a step that cuts a piece into a and b parts (0 and 0: it separates
/// nothing). `whole`: the piece is a whole starting piece.
[[gnu::always_inline]] inline double size_reward(const Term& term, std::size_t a, std::size_t b,
                                                 bool completes, bool whole) {
  const bool separates = a != 0;
  switch (term.kind) {
    case TermKind::PieceCost:
      if (completes) return term.q;
      if (!separates) return 0.0 - term.p;
      return 0.0 - (term.p + term.piece_cost[a] + term.piece_cost[b]);
    case TermKind::CubesatZone:
      if (completes) return 1;
      if (!separates) return 0;
      return 0.0 - (zone_cost(a, a + b, whole) + zone_cost(b, a + b, whole));
    case TermKind::Completion:
      return (separates ? term.p : 0.0) - term.q + (completes ? term.r : 0.0);
    default: break;
  }
  assert(false);
  return 0;
}

constexpr bool sees_sizes_only(TermKind kind) {
  return kind == TermKind::PieceCost || kind == TermKind::CubesatZone ||
         kind == TermKind::Completion;
}

void insert(std::span<std::uint64_t> set, ConnectionIndex c) {
  set[c / 64] |= std::uint64_t{1} << (c % 64);
}

}  // namespace

/// The problem, arranged for work.
struct TransitionSystem::Rules {
  bool assembly = false;
  std::size_t words = 1;
  detail::AssemblyGraph graph;

  std::vector<std::uint64_t> constrained;  ///< connections with a clause of precedence
  std::vector<std::uint64_t> after;        ///< by connection: union of its `after` lists
  std::vector<std::vector<std::vector<std::uint64_t>>>
      any;  ///< by connection: its `after_any` lists
  std::size_t max_subassemblies = kUnlimited;
  std::size_t max_moved_parts = kUnlimited;
  double max_moved_mass = kInfinity;
  bool blocking = false;

  bool uniform_mass = true;
  double total_mass = 0;
  std::vector<Term> terms;
  std::vector<double> farthest;    ///< by term: greatest distance of a part to the term's depot
  bool one_counting_term = false;  ///< the objective is a single counting term of weight 1
  bool needs_movement = false;     ///< the objective looks at which side moves, or at masses
  bool needs_sides = false;        ///< the parts of A and B must be listed
  bool cuts_checked = false;       ///< some constraint judges separations

  explicit Rules(const Problem& problem);
  void add_terms(const Problem& problem, const Objective& objective, double weight);
  [[nodiscard]] bool precedence_met(SetView open, ConnectionIndex c) const;
};

TransitionSystem::Rules::Rules(const Problem& problem)
    : assembly(problem.direction() == Direction::Assembly),
      words(words_for(problem.num_connections())),
      graph(problem) {
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
  for (const Part& part : problem.parts()) {
    total_mass += part.mass;
    if (part.mass != problem.parts().front().mass) uniform_mass = false;
  }
  add_terms(problem, problem.objective(), 1);
  const bool no_positions = std::ranges::none_of(
      problem.parts(), [](const Part& part) { return part.position.has_value(); });
  for (Term& term : terms) {
    switch (term.kind) {
      case TermKind::PieceCost:
      case TermKind::CubesatZone:
      case TermKind::Indexed:
      case TermKind::Completion: term.counting = true; break;
      case TermKind::Time: term.counting = no_positions; break;
      case TermKind::Fuel: term.counting = uniform_mass; break;
      default: break;
    }
    if (!problem.parts().empty()) term.part_mass = problem.parts().front().mass;
    if (!term.counting) needs_movement = true;
    double distance = 0;
    for (const Part& part : problem.parts()) {
      if (!part.position) continue;
      const Vector3& x = *part.position;
      distance = std::max(
          distance, std::hypot(x[0] - term.depot[0], x[1] - term.depot[1], x[2] - term.depot[2]));
    }
    farthest.push_back(distance);
  }
  one_counting_term = terms.size() == 1 && terms[0].weight == 1 && terms[0].counting;
  needs_sides = needs_movement || blocking || limits.max_moved_mass.has_value();
}

void TransitionSystem::Rules::add_terms(const Problem& problem, const Objective& objective,
                                        double weight) {
  Term term;
  term.weight = weight;
  struct Visitor {
    const Problem& problem;
    Rules& rules;
    Term& term;

    void add() { rules.terms.push_back(std::move(term)); }
    void operator()(const PieceCost& cost) {
      term.kind = TermKind::PieceCost;
      term.piece_cost.assign(problem.num_parts() + 1, 0.0);
      for (const auto& [size, value] : cost.pieces) {
        if (size < term.piece_cost.size()) term.piece_cost[size] = value;
      }
      term.p = cost.operation;
      term.q = cost.completion;
      add();
    }
    void operator()(const CubesatZone&) {
      term.kind = TermKind::CubesatZone;
      add();
    }
    void operator()(const Indexed&) {
      term.kind = TermKind::Indexed;
      add();
    }
    void operator()(const TimeObjective& time) {
      term.kind = TermKind::Time;
      term.p = time.speed;
      term.q = time.transfer;
      term.depot = time.depot;
      add();
    }
    void operator()(const Travel& travel) {
      term.kind = TermKind::Travel;
      term.depot = travel.depot;
      add();
    }
    void operator()(const Fuel& fuel) {
      term.kind = TermKind::Fuel;
      term.p = fuel.dry_mass;
      term.q = std::expm1(fuel.delta_v / (fuel.isp * kStandardGravity));
      add();
    }
    void operator()(const CompletionObjective& completion) {
      term.kind = TermKind::Completion;
      term.p = completion.join;
      term.q = completion.step;
      term.r = completion.bonus;
      add();
    }
    void operator()(const Expression& expression) {
      term.kind = TermKind::Expression;
      term.depot = expression.depot;
      term.expression = &expression;
      add();
    }
    void operator()(const Callable& callable) {
      term.kind = TermKind::Callable;
      term.callable = &callable;
      add();
    }
    void operator()(const WeightedSum& sum) {
      const double outer = term.weight;
      for (const WeightedObjective& addend : sum.terms) {
        rules.add_terms(problem, addend.objective, outer * addend.weight);
      }
    }
  };
  std::visit(Visitor{problem, *this, term}, objective.parameters);
}

// Precedence is written for disassembly: removing c needs every `after` gone. In assembly the step that makes c is the
// reverse of removing it from the state that follows, so there every `after` must still be missing. While c itself is
// handled it is there, in both directions.
bool TransitionSystem::Rules::precedence_met(SetView open, ConnectionIndex c) const {
  if (!contains(constrained, c)) return true;
  const std::uint64_t flip = assembly ? ~std::uint64_t{0} : 0;
  const std::uint64_t* const mine = after.data() + c * words;
  const std::uint64_t self = std::uint64_t{1} << (c % 64);
  for (std::size_t w = 0; w < words; ++w) {
    const std::uint64_t present = (open[w] ^ flip) | (w == c / 64 ? self : 0);
    if ((mine[w] & present) != 0) return false;
  }
  return std::ranges::all_of(any[c], [&](const std::vector<std::uint64_t>& list) {
    for (std::size_t w = 0; w < words; ++w) {
      const std::uint64_t present = (open[w] ^ flip) | (w == c / 64 ? self : 0);
      if ((list[w] & ~present) != 0) return true;
    }
    return false;
  });
}

// ---------------------------------------------------------------------------------------------------------------------

/// Scratch memory of one thread, and the rules applied to facts.
struct Expander::Scratch {
  const Problem& problem;
  const TransitionSystem::Rules& rules;

  std::vector<Action> actions;
  std::vector<std::unique_ptr<Formula>> formulas;  ///< by term
  std::vector<std::uint64_t> present_words;        ///< assembly: complement of the open set
  detail::Connectivity connectivity;
  Side
      a;  ///< parts of A and B of the step at hand; set by whoever makes its Facts, if rules.needs_sides
  Side b;
  std::vector<unsigned char> mark;  ///< by part; all 0 between uses
  std::vector<PartIndex> fill_a;
  std::vector<PartIndex> fill_b;

  Scratch(const Problem& the_problem, const TransitionSystem::Rules& the_rules);

  [[nodiscard]] SetView present(SetView open);
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
  [[nodiscard]] double moving_reward(const Term& term, std::size_t index, const Facts& facts,
                                     const Movement& movement);
  [[nodiscard]] std::span<const Action> legal_actions(SetView open);
  [[nodiscard]] Step full_step(const Facts& facts) const;
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
  if (!rules.assembly) return open;
  for (std::size_t w = 0; w < rules.words; ++w) present_words[w] = ~open[w];
  const std::size_t tail = problem.num_connections() % 64;
  if (tail != 0) present_words.back() &= (std::uint64_t{1} << tail) - 1;
  if (problem.num_connections() == 0) present_words.back() = 0;
  return present_words;
}

[[gnu::always_inline]] inline Facts Expander::Scratch::counts(ConnectionIndex c,
                                                              std::size_t num_open) const {
  Facts facts;
  facts.connection = c;
  facts.before = rules.assembly ? problem.num_connections() - num_open : num_open;
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

// One step on its own, by definition: take the connection away and see what hangs together. Shares nothing with the
// analysis of all steps at once; the checker and the explanations use it.
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

// Design section 1: the side with fewer parts moves; on a tie the lighter; on a tie the one that
// does not hold the earliest listed of their parts.
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

// The objectives that look inside the pieces.
double Expander::Scratch::moving_reward(const Term& term, std::size_t index, const Facts& facts,
                                        const Movement& movement) {
  const ConnectionIndex c = facts.connection;
  const double duration = problem.connections()[c].duration;
  const double moved_parts = std::min(facts.a_parts, facts.b_parts);
  const auto checked = [&](double value) {
    if (std::isfinite(value)) return value;
    throw InputError(
        "objective: the reward of " + std::string(rules.assembly ? "making " : "removing ") +
        detail::in_quotes(problem.connection_id(c)) + " with " + std::to_string(facts.before) +
        " connections present is " + (std::isnan(value) ? "not a number" : "infinite") +
        "; rewards must be finite");
  };
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
      return checked(formulas[index]->value(variables));
    }
    case TermKind::Callable: return checked(term.callable->reward(full_step(facts)));
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
    return {actions.data(), next};
  }
  for_each_connection(open, [&](ConnectionIndex c) {
    if (!rules.precedence_met(open, c)) return;
    const Facts facts = rules.assembly ? joining_facts(c, num_open) : removal_facts(c, num_open);
    if (rules.cuts_checked && facts.separates && !separation_legal(facts)) return;
    *next++ = {c, reward(facts)};
  });
  return {actions.data(), next};
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

// ---------------------------------------------------------------------------------------------------------------------

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
  if (s.connectivity.takes_batches()) s.connectivity.analyse_batch(states);
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

bool Expander::legal(SetView open, ConnectionIndex connection) {
  Scratch& s = *scratch_;
  if (!contains(open, connection) || !s.rules.precedence_met(open, connection)) return false;
  if (!s.rules.cuts_checked) return true;
  const Facts facts = s.flooded_facts(open, connection);
  return !facts.separates || s.separation_legal(facts);
}

std::vector<Violation> Expander::violations(SetView open, ConnectionIndex connection) {
  Scratch& s = *scratch_;
  const Problem& problem = s.problem;
  const TransitionSystem::Rules& rules = s.rules;
  const std::string id = detail::in_quotes(problem.connection_id(connection));
  std::vector<Violation> found;
  if (!contains(open, connection)) {
    found.push_back({Constraint::NotOpen,
                     "",
                     id + (rules.assembly ? " was made before" : " was removed before"),
                     {}});
    return found;
  }
  const auto stands_in_the_way = [&](ConnectionIndex other) {
    return other == connection || (rules.assembly ? !contains(open, other) : contains(open, other));
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

// ---------------------------------------------------------------------------------------------------------------------

TransitionSystem::TransitionSystem(const Problem& problem)
    : problem_(problem), rules_(std::make_unique<const Rules>(problem)) {}
TransitionSystem::~TransitionSystem() = default;

std::size_t TransitionSystem::subassemblies(SetView present) const {
  std::size_t pieces = 0;
  rules_->graph.for_each_piece(present, [&](std::span<const PartIndex> piece) {
    if (piece.size() >= 2) ++pieces;
  });
  return pieces;
}

std::optional<Violation> TransitionSystem::infeasibility() const {
  const Rules& rules = *rules_;
  const std::size_t start_pieces = subassemblies(start().view());
  if (num_connections() > 0 && start_pieces > rules.max_subassemblies) {
    return Violation{Constraint::MaxSubassemblies,
                     "limits.max_subassemblies",
                     "the whole product is " + std::to_string(start_pieces) +
                         " subassemblies; at most " + std::to_string(rules.max_subassemblies) +
                         " are allowed",
                     {}};
  }
  // Precedence alone, in disassembly order: remove whatever may go until nothing more may. The
  // clauses are monotone, so if connections stay, each of them waits for another that stays, and
  // following these ends in a cycle. Every clause is looked at again only when a connection that it
  // names goes.
  std::vector<bool> stays(num_connections(), true);
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
  std::size_t left = num_connections();
  while (!check.empty()) {
    const ConnectionIndex c = check.back();
    check.pop_back();
    if (!stays[c] || waits_for(c)) continue;
    stays[c] = false;
    --left;
    check.insert(check.end(), waiting[c].begin(), waiting[c].end());
  }
  if (left == 0) return std::nullopt;
  // Walk from the first that stays until a connection comes up again: from there on it is the
  // cycle.
  std::vector<std::size_t> met(num_connections(), kUnlimited);
  std::vector<std::pair<ConnectionIndex, std::size_t>> path;
  auto c = static_cast<ConnectionIndex>(std::ranges::find(stays, true) - stays.begin());
  while (met[c] == kUnlimited) {
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
        // `before` is at most `open` in disassembly, and at most all but one in assembly; the
        // reward grows with it.
        const double most = static_cast<double>(rules.assembly ? num_connections() - 1 : open);
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

bool TransitionSystem::sees_sizes_only() const {
  return std::ranges::all_of(rules_->terms,
                             [](const Term& term) { return orasp::sees_sizes_only(term.kind); });
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
    case Constraint::NotOpen: break;
  }
  return "sequence";
}

}  // namespace orasp
