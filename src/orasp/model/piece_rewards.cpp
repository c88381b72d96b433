#include <algorithm>
#include <cmath>

#include "orasp/model/detail/step_scratch.h"

namespace orasp {

using detail::Facts;
using detail::Term;
using detail::TermKind;

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

}  // namespace orasp
