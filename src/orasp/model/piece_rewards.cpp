#include <algorithm>
#include <span>

#include "orasp/model/detail/step_scratch.h"

namespace orasp {

using detail::StepFacts;

double Expander::own_reward(ConnectionIndex connection) {
  StepFacts facts = scratch_->counts(connection, 2);
  facts.completes = false;
  return scratch_->reward(facts);
}

std::optional<double> Expander::cut_gain(std::span<const PartIndex> a, std::span<const PartIndex> b,
                                         ConnectionIndex connection, bool direction_free) {
  Scratch& s = *scratch_;
  StepFacts facts = s.counts(connection, 2);
  facts.completes = false;
  const double own = s.reward(facts);
  facts.separates = true;
  facts.a_parts = static_cast<std::uint32_t>(a.size());
  facts.b_parts = static_cast<std::uint32_t>(b.size());
  s.pieces.a = {{a, {}}};
  s.pieces.b = {{b, {}}};
  // How many subassemblies there are is not the piece's own matter: facts.subassemblies_apart is 0
  // here.
  if (s.rules.cuts_checked && !s.separation_legal(facts, direction_free)) return std::nullopt;
  return s.reward(facts) - own;
}

double Expander::greatest_gain(std::size_t moved, std::size_t kept) {
  const std::size_t base_parts = system_.problem().spec().base.size();
  double sum = 0;
  for (const auto& addend : scratch_->terms) {
    if (addend.weight == 0) continue;
    double most = addend.term->greatest_gain(addend.weight, moved, kept);
    // The larger side moves where the smaller one is fixed, and neither where both are.
    if (base_parts > 0)
      most = std::max(most, addend.term->greatest_gain(addend.weight, kept, moved));
    if (base_parts > 1)
      most = std::max(most, addend.term->greatest_gain_unmoved(addend.weight, moved, kept));
    sum += most;
  }
  return sum;
}

double Expander::greatest_gain_of_moving(std::span<const PartIndex> moved) {
  Scratch& s = *scratch_;
  s.pieces.a = {{moved, {}}};
  double sum = 0;
  for (const auto& addend : s.terms) {
    if (addend.weight != 0) sum += addend.term->greatest_gain_of_moving(addend.weight, s.pieces);
  }
  return sum;
}

std::vector<double> Expander::least_extra_costs() const {
  std::vector<double> costs(system_.num_connections(), 0.0);
  for (const auto& addend : scratch_->terms)
    if (addend.weight != 0) addend.term->add_extra_costs(addend.weight, costs);
  return costs;
}

bool Expander::moving_more_costs_more() const {
  return std::ranges::all_of(scratch_->rules.terms, [](const WeightedTerm& addend) {
    return addend.weight >= 0 && addend.term->sees.moving_more_costs_more;
  });
}

double Expander::completion_surplus(ConnectionIndex connection) {
  Scratch& s = *scratch_;
  const auto& ends = s.problem.ends(connection);
  StepFacts facts = s.counts(connection, 1);
  facts.separates = ends[0] != ends[1];
  if (s.rules.num_kept > 0) {
    ConnectionSet alone(system_.num_connections());
    alone.insert(connection);
    facts = s.flooded_facts(alone.view(), connection);
  } else if (facts.separates) {
    facts.a_parts = facts.b_parts = 1;
    facts.subassemblies_joined = 1;
    s.pieces.a = {{std::span(ends).first(1), {}}};
    s.pieces.b = {{std::span(ends).last(1), {}}};
  }
  const double last = s.reward(facts);
  facts.completes = false;
  return last - s.reward(facts);
}

RewardRange TransitionSystem::reward_range(ConnectionIndex connection, std::size_t open,
                                           bool completes) const {
  const Rules& rules = *rules_;
  // Before a step in disassembly at most what is open or inaccessible is there, in assembly all but
  // the connection itself.
  const std::size_t most_before = rules.making ? num_connections() - 1
                                  : rules.assembly
                                      ? open + rules.num_kept - std::min<std::size_t>(1, open)
                                      : open + rules.num_kept;
  const RangeQuestion question{.connection = connection,
                               .duration = problem_.connections()[connection].duration,
                               .most_before = static_cast<double>(most_before),
                               .completes = completes};
  RewardRange sum{0, 0};
  for (const auto& [weight, term] : rules.terms) {
    if (weight == 0) continue;
    const RewardRange range = term->range(question);
    sum.least += weight > 0 ? weight * range.least : weight * range.greatest;
    sum.greatest += weight > 0 ? weight * range.greatest : weight * range.least;
  }
  return sum;
}

bool TransitionSystem::sees_piece_only() const {
  return std::ranges::all_of(rules_->terms, [](const auto& t) { return t.term->sees.piece_only; });
}

bool TransitionSystem::gain_by_sizes() const {
  return std::ranges::all_of(rules_->terms,
                             [](const auto& t) { return t.term->sees.gain_by_sizes; });
}

bool TransitionSystem::gain_by_moved() const {
  return std::ranges::all_of(rules_->terms,
                             [](const auto& t) { return t.term->sees.gain_by_moved; });
}

bool TransitionSystem::gain_by_connection() const {
  return std::ranges::any_of(rules_->terms,
                             [](const auto& t) { return t.term->sees.gain_by_connection; });
}

bool TransitionSystem::sees_sizes_only() const {
  return std::ranges::all_of(rules_->terms, [](const auto& t) { return t.term->sees.sizes_only; });
}

bool TransitionSystem::sees_starting_pieces() const {
  return std::ranges::any_of(rules_->terms,
                             [](const auto& t) { return t.term->sees.starting_pieces; });
}

bool TransitionSystem::sees_order_only() const {
  return std::ranges::all_of(rules_->terms, [](const auto& t) { return t.term->sees.order_only; });
}

bool TransitionSystem::calls_out() const {
  return std::ranges::any_of(rules_->terms, [](const auto& t) { return t.term->sees.calls_out; });
}

double TransitionSystem::greatest_gain_of_moving_with(std::span<const PartIndex> parts,
                                                      std::size_t least, std::size_t most,
                                                      double low_enough) const {
  LargerPiece piece{.least = least, .most = most};
  if (rules_->terms.size() == 1) piece.low_enough = low_enough;
  const detail::StepPieces pieces{.totals = rules_->totals, .a = {{parts, {}}}, .b = {}};
  double sum = 0;
  for (const auto& [weight, term] : rules_->terms) {
    if (weight != 0) sum += term->greatest_gain_of_moving_with(weight, pieces, piece);
  }
  return sum;
}

double TransitionSystem::greatest_size_reward(std::size_t a, std::size_t b, bool completes) const {
  double sum = 0;
  for (const auto& [weight, term] : rules_->terms) {
    const double inside = term->size_reward(a, b, completes, false);
    const double whole = term->size_reward(a, b, completes, true);
    sum += std::max(weight * inside, weight * whole);
  }
  return sum;
}

}  // namespace orasp
