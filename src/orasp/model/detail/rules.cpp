#include "orasp/model/detail/rules.h"

#include <cmath>
#include <memory>
#include <numeric>
#include <span>
#include <utility>
#include <variant>

#include "orasp/model/tolerance.h"

namespace orasp::detail {

namespace {

constexpr double kStandardGravity = 9.80665;  // m/s^2

void insert(std::span<std::uint64_t> set, ConnectionIndex c) {
  set[c / 64] |= std::uint64_t{1} << (c % 64);
}

}  // namespace

Rules::Rules(const Problem& problem, const Situation& situation)
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
  for (const Part& part : problem.parts()) heaviest.push_back(part.mass);
  std::ranges::sort(heaviest);
  lightest = heaviest;
  std::ranges::reverse(heaviest);
  for (std::vector<double>* masses : {&lightest, &heaviest}) {
    masses->insert(masses->begin(), 0.0);
    std::partial_sum(masses->begin(), masses->end(), masses->begin());
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
    look_at_gain(problem, term);
    if (term.kind == TermKind::Expression)
      term.counting = term.gain_by_sizes && problem.num_parts() <= kMostPartsInTable;
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
  take(situation);
}

void Rules::take(const Situation& situation) {
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

void Rules::look_at_gain(const Problem& problem, Term& term) const {
  switch (term.kind) {
    case TermKind::PieceCost:
    case TermKind::Completion: term.piece_only = term.gain_by_sizes = true; return;
    case TermKind::CubesatZone:
      // Whether a piece of two or three parts is a piece_size starting piece matters too.
      term.piece_only = true;
      term.gain_by_sizes = std::ranges::none_of(problem.parts(), [&](const Part& part) {
        const auto index = static_cast<std::size_t>(&part - problem.parts().data());
        const std::size_t piece_size = graph.starting_piece(static_cast<PartIndex>(index));
        return piece_size == 2 || piece_size == 3;
      });
      return;
    case TermKind::Time:
    case TermKind::Fuel:
      term.piece_only = true;
      term.gain_by_sizes = term.counting;
      return;
    case TermKind::Travel: term.piece_only = true; return;
    case TermKind::Indexed:
    case TermKind::Callable: return;
    case TermKind::Expression: break;
  }
  if (!term.expression->compiler) return;
  const auto formula =
      term.expression->compiler(term.expression->formula, term.expression->constants);
  const auto uses = [&](std::string_view name) { return formula->uses(name); };
  term.piece_only = !uses("before") && !uses("after") && !uses("subassemblies");
  term.gain_by_connection = uses("duration") || uses("index");
  term.gain_by_sizes = term.piece_only && !term.gain_by_connection && !uses("moved_mass") &&
                       !uses("kept_mass") && !uses("distance");
}

void Rules::add_terms(const Problem& problem, const Objective& objective, double weight) {
  Term term;
  term.weight = weight;
  struct Visitor {
    const Problem& problem;
    Rules& rules;
    Term& term;

    void add() {
      term.index = rules.terms.size();
      rules.terms.push_back(std::move(term));
    }
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
    void operator()(const Makespan&) { refuse("makespan"); }
    void operator()(const FleetTravel&) { refuse("fleet_travel"); }
    [[noreturn]] static void refuse(const std::string& type) {
      throw InputError("objective: \"" + type +
                       "\" judges plans of several robots and no plan of one; name another "
                       "objective, or plan for the fleet");
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
