#include "orasp/model/transition_system.h"

#include <algorithm>
#include <cassert>
#include <memory>
#include <utility>

#include "orasp/model/detail/step_scratch.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/tolerance.h"

namespace orasp {

using detail::at_most;
using detail::Movement;
using detail::Side;
using detail::StepFacts;

Expander::Scratch::Scratch(const Problem& the_problem, const TransitionSystem::Rules& the_rules,
                           const TransitionSystem* any_order)
    : problem(the_problem),
      rules(the_rules),
      present_words(the_rules.words),
      connectivity(the_rules.graph, the_rules.needs_sides || the_rules.making),
      pieces{the_rules.totals, {}, {}},
      mark(the_problem.num_parts(), 0) {
  actions.resize(problem.num_connections());
  for (const WeightedTerm& addend : rules.terms) {
    std::unique_ptr<const ObjectiveTerm> own = addend.term->for_one_thread();
    const ObjectiveTerm* const term = own ? own.get() : addend.term.get();
    terms.push_back({addend.weight, term, std::move(own)});
  }
  if (rules.one_counting_term) size_costs = terms.front().term->size_costs();
  if (!rules.wide && terms.size() == 1 && terms.front().weight == 1 &&
      terms.front().term->can_take_notes())
    notes = terms.front().term;
  if (any_order != nullptr) in_any_order = std::make_unique<Expander>(*any_order);
}

SetView Expander::Scratch::present(SetView open) {
  if (!rules.making && rules.num_kept == 0) return open;
  const SetView kept = rules.kept.view();
  for (std::size_t w = 0; w < rules.words; ++w) present_words[w] = open[w] | kept[w];
  if (!rules.making) return present_words;
  for (std::uint64_t& word : present_words) word = ~word;
  const std::size_t tail = problem.num_connections() % 64;
  if (tail != 0) present_words.back() &= (std::uint64_t{1} << tail) - 1;
  if (problem.num_connections() == 0) present_words.back() = 0;
  return present_words;
}

// The durations of all that is handled in a state: in a disassembly what is gone, in an assembly
// what is there.
void Expander::Scratch::set_elapsed(SetView open) {
  if (!rules.needs_elapsed) return;
  const SetView there = present(open);
  handled_seconds = 0;
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    if (contains(there, c) == rules.assembly) handled_seconds += problem.connections()[c].duration;
  }
}

// Where steps take connections away.
std::span<const std::uint64_t> Expander::Scratch::present_of_all(
    std::span<const std::uint64_t> states) {
  if (rules.num_kept == 0) return states;
  const SetView kept = rules.kept.view();
  present_batch.assign(states.begin(), states.end());
  for (std::size_t i = 0; i < present_batch.size(); ++i) present_batch[i] |= kept[i % rules.words];
  return present_batch;
}

// Where steps make connections, after connectivity.analyse(): c joins the pieces of its two parts,
// if they are two.
StepFacts Expander::Scratch::joining_facts(ConnectionIndex c, std::size_t num_open) {
  StepFacts facts = counts(c, num_open);
  const auto [first, second] = problem.ends(c);
  facts.separates = !connectivity.same_piece(first, second);
  facts.subassemblies_apart = connectivity.subassemblies();
  facts.subassemblies_joined = facts.subassemblies_apart;
  if (!facts.separates) return facts;
  pieces.a = connectivity.piece_of(first);
  pieces.b = connectivity.piece_of(second);
  facts.a_parts = static_cast<std::uint32_t>(pieces.a.parts());
  facts.b_parts = static_cast<std::uint32_t>(pieces.b.parts());
  facts.subassemblies_joined += 1;
  facts.subassemblies_joined -= std::size_t{facts.a_parts >= 2} + std::size_t{facts.b_parts >= 2};
  return facts;
}

// One step on its own, by definition: take the connection away and see what hangs together. Shares
// nothing with the analysis of all steps at once; drawings and explanations use it.
StepFacts Expander::Scratch::flooded_facts(SetView open, ConnectionIndex c) {
  set_elapsed(open);
  StepFacts facts = counts(c, count(open));
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
  std::size_t subassemblies = 0;
  for (PartIndex part = 0; part < problem.num_parts(); ++part) {
    if (mark[part] != 0) continue;
    fill(part, fill_a);
    if (fill_a.size() >= 2) ++subassemblies;
  }
  std::ranges::fill(mark, 0);
  const auto [first, second] = problem.ends(c);
  fill(first, fill_a);
  facts.separates = mark[second] == 0;
  fill_b.clear();
  if (facts.separates) fill(second, fill_b);
  std::ranges::fill(mark, 0);
  facts.subassemblies_apart = subassemblies;
  facts.subassemblies_joined = subassemblies;
  if (!facts.separates) return facts;
  std::ranges::sort(fill_a);
  std::ranges::sort(fill_b);
  pieces.a = {{fill_a, {}}};
  pieces.b = {{fill_b, {}}};
  facts.a_parts = static_cast<std::uint32_t>(fill_a.size());
  facts.b_parts = static_cast<std::uint32_t>(fill_b.size());
  facts.subassemblies_joined += 1;
  facts.subassemblies_joined -= std::size_t{fill_a.size() >= 2} + std::size_t{fill_b.size() >= 2};
  return facts;
}

// Calls visit(blocker) for each blocker of a part of the smaller side that is on the other one.
// What a part blocks for another, the other blocks for it along the opposite, so it does not matter
// which of the two sides is looked at.
template <class Visit>
[[gnu::always_inline]] inline void Expander::Scratch::for_each_blocker_across(Visit&& visit) {
  const bool a_is_few = pieces.a.parts() <= pieces.b.parts();
  const Side& few = a_is_few ? pieces.a : pieces.b;
  const Side& many = a_is_few ? pieces.b : pieces.a;
  many.for_each([&](PartIndex part) { mark[part] = 1; });
  few.for_each([&](PartIndex part) {
    for (const Blocker& blocker : problem.blockers()[part]) {
      if (mark[blocker.by] != 0) visit(blocker);
    }
  });
  many.for_each([&](PartIndex part) { mark[part] = 0; });
}

// Whether there is a direction in which no part of A is blocked by a part of B.
bool Expander::Scratch::some_direction_free() {
  if (!problem.has_direction_masks()) return !free_directions_of_few().empty();
  DirectionMask blocked = 0;
  for_each_blocker_across([&](const Blocker& blocker) { blocked |= blocker.directions; });
  return (problem.direction_mask() & ~blocked) != 0;
}

// The directions in which the smaller side (A if there is none) can leave the other, as bits; empty
// where none is free.
std::span<const std::uint64_t> Expander::Scratch::free_directions_of_few() {
  const auto all = problem.direction_bits();
  free_bits.assign(all.begin(), all.end());
  bool some = true;
  for_each_blocker_across(
      [&](const Blocker& blocker) { some = some && problem.take_out(blocker, free_bits); });
  return some ? free_bits : std::span<const std::uint64_t>{};
}

bool Expander::Scratch::separation_legal(const StepFacts& facts, bool direction_free) {
  if (facts.subassemblies_apart > rules.max_subassemblies) return false;
  if (rules.fixed_parts) return separation_legal_on_base(facts, direction_free);
  if (std::min(facts.a_parts, facts.b_parts) > rules.max_moved_parts) return false;
  if (rules.max_moved_mass != kInfinity &&
      !at_most(pieces.movement(facts).moved_mass, rules.max_moved_mass))
    return false;
  return direction_free || !rules.blocking || some_direction_free();
}

// The same where some parts are fixed.
bool Expander::Scratch::separation_legal_on_base(const StepFacts& facts, bool direction_free) {
  if (rules.grounded && !leaves_grounded(facts)) return false;
  const bool limited = rules.max_moved_parts != detail::kUnlimited ||
                       rules.max_moved_mass != kInfinity || rules.blocking;
  if (!limited) return true;
  const Movement movement = pieces.movement(facts);
  if (!movement.moves) return true;
  if (movement.moved_parts > rules.max_moved_parts) return false;
  if (!at_most(movement.moved_mass, rules.max_moved_mass)) return false;
  return direction_free || !rules.blocking || some_direction_free();
}

// Whether each subassembly that the step makes holds a base part.
bool Expander::Scratch::leaves_grounded(const StepFacts& facts) const {
  const bool a_has = pieces.has_base(pieces.a);
  const bool b_has = pieces.has_base(pieces.b);
  if (rules.making) return a_has || b_has;
  return (a_has || facts.a_parts == 1) && (b_has || facts.b_parts == 1);
}

double Expander::Scratch::reward(const StepFacts& facts) const {
  if (size_costs != nullptr)
    return size_costs->reward(facts.a_parts, facts.b_parts, facts.separates, facts.completes);
  if (rules.one_counting_term) return terms.front().term->reward(facts, {}, pieces);
  Movement moved;
  if (rules.needs_movement && facts.separates) moved = pieces.movement(facts);
  double sum = 0;
  for (const TermOfThread& addend : terms)
    sum += addend.weight * addend.term->reward(facts, moved, pieces);
  return rules.checks_rewards ? pieces.checked(sum, facts) : sum;
}

// Disassembly with a single counting term: what legal_actions does, with the questions left out
// whose answer is known.
template <class Reward>
[[gnu::always_inline]] inline std::span<Action> Expander::Scratch::removals(SetView open,
                                                                            Reward&& reward_of) {
  Action* next = actions.data();
  const std::size_t num_open = count(open);
  for_each_connection(open, [&](ConnectionIndex c) {
    if (contains(rules.constrained, c) && !rules.precedence_met(open, c)) return;
    const StepFacts facts = removal_facts(c, num_open);
    if (rules.cuts_checked && facts.separates && !separation_legal(facts)) return;
    *next++ = {c, reward_of(facts)};
  });
  return {actions.data(), next};
}

// After connectivity's analysis of this state.
std::span<const Action> Expander::Scratch::legal_actions(SetView open) {
  set_elapsed(open);
  if (size_costs != nullptr && !rules.making) {
    const SizeCosts& costs = *size_costs;
    return in_order(open, removals(open, [&costs](const StepFacts& facts) {
                      return costs.reward(facts.a_parts, facts.b_parts, facts.separates,
                                          facts.completes);
                    }));
  }
  if (rules.one_counting_term && !rules.making) {
    const ObjectiveTerm& term = *terms.front().term;
    return in_order(open, removals(open, [&](const StepFacts& facts) {
                      return term.reward(facts, {}, pieces);
                    }));
  }
  Action* next = actions.data();
  const std::size_t num_open = count(open);
  if (notes != nullptr && !asking_many) notes->take_notes(true);
  for_each_connection(open, [&](ConnectionIndex c) {
    if (!rules.precedence_met(open, c)) return;
    const StepFacts facts = rules.making ? joining_facts(c, num_open) : removal_facts(c, num_open);
    if (rules.cuts_checked && facts.separates && !separation_legal(facts)) return;
    *next++ = {c, reward(facts)};
  });
  if (notes != nullptr && !asking_many) fill_in_rewards({actions.data(), next});
  return in_order(open, {actions.data(), next});
}

// Their rewards are the places of the steps in the notes, so far.
void Expander::Scratch::fill_in_rewards(std::span<Action> noted) const {
  const std::span<const double> rewards = notes->noted_rewards();
  for (Action& action : noted) action.reward = rewards[static_cast<std::size_t>(action.reward)];
}

// Leaves out what cannot be next, and what is late while something else can be done.
inline std::span<const Action> Expander::Scratch::in_order(SetView open, std::span<Action> legal) {
  if (!rules.ordered) return legal;
  const auto is_late = [&](const Action& action) { return rules.late.contains(action.connection); };
  auto end = legal.end();
  if (std::ranges::equal(open, rules.start.view())) {
    end = std::remove_if(legal.begin(), end, [&](const Action& action) {
      return rules.not_next.contains(action.connection);
    });
  }
  const bool others = std::any_of(legal.begin(), end, [&](const Action& action) {
    return !is_late(action) && goes_on(open, action.connection);
  });
  if (others) end = std::remove_if(legal.begin(), end, is_late);
  return {legal.begin(), end};
}

// Whether it is known that the goal can be reached after a legal step, in any order. What is late
// may come sooner where finding out takes too long, so that no plan is missed.
bool Expander::Scratch::goes_on(SetView open, ConnectionIndex c) {
  if (in_any_order == nullptr) return true;
  ConnectionSet next(problem.num_connections(), open);
  next.erase(c);
  return goal_in_reach(std::move(next)).value_or(false);
}

// Depth first, with a memory of states; empty where that is full.
std::optional<bool> Expander::Scratch::goal_in_reach(ConnectionSet from) {
  constexpr std::size_t kMostStates = 200'000;
  struct Frame {
    ConnectionSet state;
    std::vector<Action> untried;
  };
  std::vector<Frame> path;
  const auto known = [this](const ConnectionSet& state) -> std::optional<bool> {
    if (state.empty()) return true;
    const auto found = leads_to_goal.find(state);
    return found == leads_to_goal.end() ? std::nullopt : std::optional(found->second);
  };
  const auto enter = [&](ConnectionSet state) {
    const auto span = in_any_order->legal_actions(state.view());
    path.push_back({std::move(state), {span.begin(), span.end()}});
  };
  if (const auto answer = known(from)) return *answer;
  enter(std::move(from));
  while (!path.empty()) {
    if (leads_to_goal.size() > kMostStates) return std::nullopt;
    Frame& at = path.back();
    if (at.untried.empty()) {
      leads_to_goal.emplace(std::move(at.state), false);
      path.pop_back();
      continue;
    }
    ConnectionSet next = at.state;
    next.erase(at.untried.back().connection);
    at.untried.pop_back();
    const auto answer = known(next);
    if (!answer) {
      enter(std::move(next));
    } else if (*answer) {
      for (Frame& frame : path) leads_to_goal.emplace(std::move(frame.state), true);
      return true;
    }
  }
  return false;
}

// -------------------------------------------------------------------------------------------------

Expander::Expander(const TransitionSystem& system)
    : system_(system),
      scratch_(
          std::make_unique<Scratch>(system.problem_, *system.rules_, system.in_any_order_.get())) {}
Expander::~Expander() = default;
Expander::Expander(Expander&&) noexcept = default;

std::span<const Action> Expander::legal_actions(SetView open) {
  Scratch& s = *scratch_;
  if (s.rules.wide) return s.wide_actions(open);
  s.connectivity.analyse(s.present(open), s.rules.making);
  return s.legal_actions(open);
}

void Expander::load(std::span<const std::uint64_t> states) {
  static_assert(kBatch == detail::Connectivity::kLanes);
  Scratch& s = *scratch_;
  if (s.rules.wide) return;
  if (s.connectivity.takes_batches()) s.connectivity.analyse_batch(s.present_of_all(states));
}

std::span<const Action> Expander::loaded_actions(std::span<const std::uint64_t> states,
                                                 std::size_t i) {
  Scratch& s = *scratch_;
  const SetView open = states.subspan(i * system_.words(), system_.words());
  if (s.rules.wide || !s.connectivity.takes_batches()) return legal_actions(open);
  s.connectivity.select(i);
  return s.legal_actions(open);
}

bool Expander::asks_for_many() const {
  return scratch_->notes != nullptr;
}

void Expander::expand_many(std::span<const std::uint64_t> states) {
  Scratch& s = *scratch_;
  s.actions_of_many.clear();
  s.ends_of_many.clear();
  s.asking_many = true;
  s.notes->take_notes(true);
  const std::size_t words = system_.words();
  const std::size_t size = states.size() / words;
  for (std::size_t begin = 0; begin < size; begin += kBatch) {
    const std::size_t batch = std::min(kBatch, size - begin);
    const auto loaded = states.subspan(begin * words, batch * words);
    load(loaded);
    for (std::size_t i = 0; i < batch; ++i) {
      const std::span<const Action> actions = loaded_actions(loaded, i);
      s.actions_of_many.insert(s.actions_of_many.end(), actions.begin(), actions.end());
      s.ends_of_many.push_back(s.actions_of_many.size());
    }
  }
  s.asking_many = false;
  s.fill_in_rewards(s.actions_of_many);
}

std::span<const Action> Expander::actions_of_many(std::size_t i) const {
  const std::size_t begin = i == 0 ? 0 : scratch_->ends_of_many[i - 1];
  return std::span(scratch_->actions_of_many).subspan(begin, scratch_->ends_of_many[i] - begin);
}

Step Expander::step(SetView open, ConnectionIndex connection) {
  assert(contains(open, connection));
  const StepFacts facts = scratch_->flooded_facts(open, connection);
  Step step = scratch_->pieces.full_step(facts);
  step.reward = scratch_->reward(facts);
  if (step.moves() && !scratch_->problem.directions().empty())
    step.free_directions = scratch_->free_directions_of_moved(facts);
  return step;
}

double Expander::completing_reward(SetView open, ConnectionIndex connection) {
  StepFacts facts = scratch_->flooded_facts(open, connection);
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
  const StepFacts facts = flooded_facts(open, c);
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
        constraints_met(open, candidate) && goes_on(open, candidate))
      other = candidate;
  });
  return other;
}

std::vector<DirectionIndex> Expander::free_directions(SetView open, ConnectionIndex connection) {
  Scratch& s = *scratch_;
  if (s.problem.directions().empty()) return {};
  const StepFacts facts = s.flooded_facts(open, connection);
  const bool moves = facts.separates && s.pieces.movement(facts).moves;
  return moves ? s.free_directions_of_moved(facts) : std::vector<DirectionIndex>{};
}

std::vector<DirectionIndex> Expander::Scratch::free_directions_of_moved(const StepFacts& facts) {
  const auto of_few = free_directions_of_few();
  if (of_few.empty()) return {};
  const bool few_moves = pieces.movement(facts).a_moves == (facts.a_parts <= facts.b_parts);
  std::vector<DirectionIndex> free;
  for (const DirectionIndex d : problem.directions()) {
    const DirectionIndex way_of_few = few_moves ? d : opposite(d);
    if ((of_few[way_of_few / 64U] >> way_of_few % 64U & 1U) != 0) free.push_back(d);
  }
  return free;
}

// -------------------------------------------------------------------------------------------------

TransitionSystem::TransitionSystem(const Problem& problem)
    : TransitionSystem(problem, Situation::whole(problem.num_connections())) {}
TransitionSystem::TransitionSystem(const Problem& problem, const Situation& situation)
    : TransitionSystem(problem, situation, detail::Walk::Forwards) {}
TransitionSystem::TransitionSystem(const Problem& problem, const Situation& situation,
                                   detail::Walk walk)
    : problem_(problem),
      rules_(std::make_unique<const Rules>(problem, situation, walk)),
      situation_(situation),
      num_steps_(rules_->start.size()),
      words_(rules_->words + (rules_->wide ? std::max<std::size_t>(1, rules_->context.words) : 0)),
      start_state_(words_, 0) {
  std::ranges::copy(rules_->start.view(), start_state_.begin());
  std::ranges::copy(rules_->start_context(situation),
                    start_state_.begin() + static_cast<std::ptrdiff_t>(rules_->words));
  // The work may be done before it begins.
  const bool reached = rules_->has_goal && !rules_->may_stop &&
                       rules_->goal_holds(present(rules_->start.view()).view());
  if (reached || rules_->start.empty()) std::ranges::fill(start_state_, std::uint64_t{0});
  if (rules_->late.empty() || !rules_->may_shut_out) return;
  Situation in_any_order = situation;
  in_any_order.not_next = in_any_order.late = ConnectionSet(problem.num_connections());
  in_any_order_ = std::make_unique<const TransitionSystem>(problem, in_any_order);
}
TransitionSystem::~TransitionSystem() = default;

TransitionSystem TransitionSystem::backwards() const {
  assert(rules_->making && !rules_->ordered);
  return {problem_, situation_, detail::Walk::Backwards};
}

bool TransitionSystem::takes_apart() const {
  return !rules_->making;
}

bool TransitionSystem::completes_first() const {
  return rules_->assembly && !rules_->making;
}

const ConnectionSet& TransitionSystem::start() const {
  return rules_->start;
}

bool TransitionSystem::whole() const {
  return rules_->whole;
}

const detail::Rules& TransitionSystem::rules() const {
  return *rules_;
}

bool TransitionSystem::wide() const {
  return rules_->wide;
}

bool TransitionSystem::looks_back() const {
  return rules_->context.words > 0;
}

bool TransitionSystem::may_shut_out() const {
  return rules_->may_shut_out;
}

bool TransitionSystem::ordered() const {
  return rules_->ordered;
}

const ConnectionSet& TransitionSystem::kept() const {
  return rules_->kept;
}

ConnectionSet TransitionSystem::present(SetView open) const {
  ConnectionSet there(num_connections());
  for (ConnectionIndex c = 0; c < num_connections(); ++c) {
    if ((contains(open, c) || kept().contains(c)) != rules_->making) there.insert(c);
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
