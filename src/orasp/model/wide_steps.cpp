#include <algorithm>
#include <bit>
#include <cassert>
#include <numeric>
#include <span>
#include <stdexcept>
#include <vector>

#include "orasp/model/detail/step_scratch.h"

// Steps where there is more to them than one open connection (TransitionSystem::wide): plans that
// end at a goal, states with a context, steps that take parts off.

namespace orasp {

using detail::at_most;
using detail::Movement;
using detail::StepFacts;

namespace {

/// A number of a context that is written in mixed radix.
std::uint32_t digit(std::uint64_t word, std::uint64_t stride, std::uint64_t radix) {
  return static_cast<std::uint32_t>(word / stride % radix);
}

/// Lists the connected sets of parts that hold a given part and none of those that are left out,
/// once each. Reference: Wernicke (2006), IEEE/ACM Trans. Computational Biology and Bioinformatics
/// 3(4), 347-359.
template <class Visit>
class ConnectedSets {
 public:
  /// `neighbours`: by part. visit(set) is called for each connected set of at most `most` parts.
  ConnectedSets(const std::vector<std::vector<PartIndex>>& neighbours, std::size_t most,
                Visit visit)
      : neighbours_(neighbours), most_(most), state_(neighbours.size(), 0), visit_(visit) {}

  void list(std::span<const PartIndex> parts) {
    for (const PartIndex root : parts) {
      set_.assign(1, root);
      state_[root] = kTaken;
      std::vector<PartIndex> frontier;
      add_neighbours(root, frontier);
      grow(frontier);
      for (const PartIndex part : frontier) state_[part] = kFree;
      state_[root] = kOut;
    }
    for (const PartIndex part : parts) state_[part] = kFree;
  }

 private:
  static constexpr unsigned char kFree = 0;
  static constexpr unsigned char kTaken = 1;     // in the set
  static constexpr unsigned char kFrontier = 2;  // to be decided on, or decided against
  static constexpr unsigned char kOut = 3;

  void add_neighbours(PartIndex part, std::vector<PartIndex>& frontier) {
    for (const PartIndex other : neighbours_[part]) {
      if (state_[other] != kFree) continue;
      state_[other] = kFrontier;
      frontier.push_back(other);
    }
  }

  void grow(const std::vector<PartIndex>& frontier) {
    visit_(std::span<const PartIndex>(set_));
    if (set_.size() == most_) return;
    for (std::size_t i = 0; i < frontier.size(); ++i) {
      const PartIndex part = frontier[i];
      std::vector<PartIndex> next(frontier.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                                  frontier.end());
      const std::size_t known = next.size();
      set_.push_back(part);
      state_[part] = kTaken;
      add_neighbours(part, next);
      grow(next);
      for (std::size_t k = known; k < next.size(); ++k) state_[next[k]] = kFree;
      state_[part] = kFrontier;
      set_.pop_back();
    }
  }

  const std::vector<std::vector<PartIndex>>& neighbours_;
  std::size_t most_;
  std::vector<unsigned char> state_;
  std::vector<PartIndex> set_;
  Visit visit_;
};

}  // namespace

// Reads the context of a state.
void Expander::Scratch::recall(SetView state) {
  const detail::ContextLayout& layout = rules.context;
  if (layout.words == 0) {
    pieces.memory = nullptr;
    return;
  }
  // A set of open connections alone: nothing was done before.
  const bool plain = state.size() == rules.words;
  const std::uint64_t word = plain ? 0 : state[rules.words];
  in_force.resize(layout.radix.size());
  here.assign(layout.radix.size(), 0);
  for (std::size_t i = 0; i < layout.radix.size(); ++i)
    in_force[i] = digit(word, layout.stride[i], layout.radix[i]);
  memory = {};
  memory.in_force = in_force;
  memory.here = here;
  pieces.memory = &memory;
  if (layout.place_stride == 0) return;
  if (!layout.coordinates) {
    const auto last = word / layout.place_stride;
    if (last != 0) memory.last_place = layout.places[last - 1];
  } else if (word / layout.place_stride != 0) {
    Vector3 place{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      place[axis] = std::bit_cast<double>(state[rules.words + 1 + axis]);
    memory.last_place = place;
  }
}

std::span<const Action> Expander::Scratch::wide_actions(SetView state) {
  wide_legal.clear();
  moves.clear();
  move_connections.clear();
  move_successors.clear();
  if (std::ranges::all_of(state, [](std::uint64_t word) { return word == 0; })) return {};
  const SetView open = state.first(rules.words);
  recall(state);
  set_elapsed(open);
  if (rules.may_stop && rules.goal_holds(present(open))) add_stop();
  if (!rules.by_part) {
    connection_moves(open);
  } else if (!target.empty()) {
    part_moves_to(open, target);
  } else if (rules.making) {
    making_part_moves(open);
  } else {
    part_moves(open);
  }
  pieces.several = {};
  pieces.rest_sizes = {};
  pieces.memory = nullptr;
  if (!rules.ordered) return wide_legal;
  const auto any_of = [&](const Action& action, const ConnectionSet& set) {
    const Move& move = moves[action.number];
    return std::ranges::any_of(std::span(move_connections).subspan(move.first, move.size),
                               [&](ConnectionIndex c) { return set.contains(c); });
  };
  if (std::ranges::equal(open, rules.start.view()))
    std::erase_if(wide_legal, [&](const Action& a) { return any_of(a, rules.not_next); });
  // Where a step may leave no way to the end, what is late may come sooner, so that no plan is
  // missed.
  const bool others = !rules.may_shut_out && std::ranges::any_of(wide_legal, [&](const Action& a) {
    return !any_of(a, rules.late);
  });
  if (others) std::erase_if(wide_legal, [&](const Action& a) { return any_of(a, rules.late); });
  return wide_legal;
}

// The plan may end here.
void Expander::Scratch::add_stop() {
  wide_legal.emplace_back(ConnectionIndex{0}, 0.0, static_cast<std::uint32_t>(moves.size()));
  moves.push_back({move_connections.size(), 0, std::nullopt});
  move_successors.resize(
      move_successors.size() + rules.words + std::max<std::size_t>(1, rules.context.words), 0);
}

void Expander::Scratch::connection_moves(SetView open) {
  connectivity.analyse(present(open), rules.making);
  const std::size_t num_open = count(open);
  for_each_connection(open, [&](ConnectionIndex c) {
    if (!rules.precedence_met(open, c)) return;
    StepFacts facts = rules.making ? joining_facts(c, num_open) : removal_facts(c, num_open);
    if (rules.cuts_checked && facts.separates && !separation_legal(facts)) return;
    offer_move(open, facts, facts.separates ? pieces.movement(facts) : Movement{}, {&c, 1});
  });
}

// The directions in which the piece that moves can leave.
std::vector<DirectionIndex> Expander::Scratch::ways_of_moved(const Movement& movement) {
  const auto of_few = free_directions_of_few();
  std::vector<DirectionIndex> free;
  if (of_few.empty()) return free;
  const bool few_moves = movement.a_moves == (pieces.a.parts() <= pieces.b.parts());
  for (const DirectionIndex d : problem.directions()) {
    const DirectionIndex way_of_few = few_moves ? d : opposite(d);
    if ((of_few[way_of_few / 64U] >> way_of_few % 64U & 1U) != 0) free.push_back(d);
  }
  return free;
}

// Adds a step that is legal: once, or once for each direction where the objective looks at it.
void Expander::Scratch::offer_move(SetView open, StepFacts& facts, const Movement& movement,
                                   std::span<const ConnectionIndex> connections) {
  next_open.assign(open.begin(), open.end());
  for (const ConnectionIndex c : connections) next_open[c / 64] &= ~(std::uint64_t{1} << (c % 64));
  const bool nothing_left =
      std::ranges::all_of(next_open, [](std::uint64_t word) { return word == 0; });
  facts.completes = nothing_left;
  if (rules.has_goal && !rules.may_stop && rules.goal_holds(present(next_open)))
    facts.completes = true;
  // Backwards, the step that completes is the first one.
  if (rules.assembly && !rules.making)
    facts.completes = std::ranges::equal(open, rules.start.view());
  if (piece_completes) facts.completes = *piece_completes && (rules.assembly || nothing_left);
  std::optional<std::size_t> by_direction;
  for (std::size_t i = 0; i < rules.context.radix.size(); ++i) {
    here[i] = 0;
    const auto& of_connection = rules.totals.attributes[i].of_connection;
    if (of_connection.empty()) {
      by_direction = i;
      continue;
    }
    bool differ = false;
    for (const ConnectionIndex c : connections) {
      if (of_connection[c] == 0) continue;
      differ = differ || (here[i] != 0 && here[i] != of_connection[c]);
      here[i] = of_connection[c];
    }
    if (differ) here[i] = 0;
  }
  if (rules.context.place_stride != 0) {
    Vector3 sum{};
    for (const ConnectionIndex c : connections) {
      const Vector3& place = rules.context.places[rules.context.place_of[c] - 1];
      for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += place[axis];
    }
    for (double& x : sum) x /= static_cast<double>(connections.size());
    memory.place = sum;
  }
  if (!by_direction || !movement.moves) {
    add_move(facts, movement, connections, std::nullopt);
    return;
  }
  const std::vector<DirectionIndex> free = ways_of_moved(movement);
  for (std::size_t i = 0, next = 0; i < problem.directions().size() && next < free.size(); ++i) {
    if (problem.directions()[i] != free[next]) continue;
    here[*by_direction] = static_cast<std::uint32_t>(i + 1);
    add_move(facts, movement, connections, free[next++]);
  }
  here[*by_direction] = 0;
}

void Expander::Scratch::add_move(const StepFacts& facts, const Movement& movement,
                                 std::span<const ConnectionIndex> connections,
                                 std::optional<DirectionIndex> direction) {
  double sum = 0;
  for (const TermOfThread& addend : terms)
    sum += addend.weight * addend.term->reward(facts, movement, pieces);
  if (rules.checks_rewards) sum = pieces.checked(sum, facts);
  wide_legal.emplace_back(facts.connection, sum, static_cast<std::uint32_t>(moves.size()));
  moves.push_back({move_connections.size(), connections.size(), direction});
  move_connections.insert(move_connections.end(), connections.begin(), connections.end());
  write_successor();
}

// Appends the state after the step at hand: next_open and what it leaves behind.
void Expander::Scratch::write_successor() {
  const detail::ContextLayout& layout = rules.context;
  const std::size_t begin = move_successors.size();
  move_successors.resize(begin + rules.words + std::max<std::size_t>(1, layout.words), 0);
  const bool nothing_left =
      std::ranges::all_of(next_open, [](std::uint64_t word) { return word == 0; });
  if (nothing_left) return;
  if (rules.has_goal && !rules.may_stop && rules.goal_holds(present(next_open))) return;
  const std::span<std::uint64_t> next = std::span(move_successors).subspan(begin);
  std::ranges::copy(next_open, next.begin());
  if (layout.words == 0) return;
  std::uint64_t& word = next[rules.words];
  for (std::size_t i = 0; i < layout.radix.size(); ++i) {
    const std::uint64_t value = here[i] != 0 ? here[i] : in_force[i];
    // What no step can have any more is forgotten.
    const std::vector<std::uint64_t>& with_value = layout.with_value[i];
    bool matters = with_value.empty();
    for (std::size_t w = 0; w < with_value.size() && !matters; ++w)
      matters = (with_value[w] & next_open[w]) != 0;
    if (matters) word += value * layout.stride[i];
  }
  if (layout.place_stride == 0) return;
  if (!layout.coordinates) {
    word += static_cast<std::uint64_t>(layout.place_of[move_connections[moves.back().first]]) *
            layout.place_stride;
    return;
  }
  word += layout.place_stride;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double x = (*memory.place)[axis] + 0.0;
    next[rules.words + 1 + axis] = std::bit_cast<std::uint64_t>(x);
  }
}

// Whether some direction is free in which these parts leave all that is marked.
bool Expander::Scratch::leaves_somewhere(std::span<const PartIndex> moved,
                                         std::span<const unsigned char> marked) {
  const auto all = problem.direction_bits();
  free_bits.assign(all.begin(), all.end());
  bool some = true;
  for (const PartIndex part : moved) {
    for (const Blocker& blocker : problem.blockers()[part]) {
      if (marked[blocker.by] == 0) continue;
      some = problem.take_out(blocker, free_bits);
      if (!some) return false;
    }
  }
  return some;
}

std::size_t Expander::Scratch::subassemblies_of(SetView there) const {
  std::size_t number = 0;
  rules.graph.for_each_piece(there, [&](std::span<const PartIndex> piece) {
    if (piece.size() >= 2) ++number;
  });
  return number;
}

// Leaves a list of steps that has grown too long for whoever asked for it.
void Expander::Scratch::leave_list_if_told(std::uint64_t& asked) const {
  constexpr std::uint64_t kPollEvery = 256;
  if (++asked % kPollEvery != 0 || !rules.listing.stop) return;
  const std::uint64_t bytes = wide_legal.capacity() * sizeof(Action) +
                              moves.capacity() * sizeof(Move) +
                              move_connections.capacity() * sizeof(ConnectionIndex) +
                              move_successors.capacity() * sizeof(std::uint64_t);
  if (rules.listing.stop(bytes)) throw detail::ListingStopped{bytes};
}

// The pieces, each with its parts ascending, and for each the others that some of `connections`
// lead to, ascending.
Expander::Scratch::TouchingPieces Expander::Scratch::touching_pieces(SetView there,
                                                                     SetView connections) const {
  TouchingPieces found;
  std::vector<std::size_t> piece_of(problem.num_parts(), 0);
  rules.graph.for_each_piece(there, [&](std::span<const PartIndex> piece) {
    for (const PartIndex part : piece) piece_of[part] = found.pieces.size();
    found.pieces.emplace_back(piece.begin(), piece.end());
    std::ranges::sort(found.pieces.back());
  });
  found.touched.resize(found.pieces.size());
  for_each_connection(connections, [&](ConnectionIndex c) {
    const std::size_t first = piece_of[problem.ends(c)[0]];
    const std::size_t second = piece_of[problem.ends(c)[1]];
    if (first == second) return;
    found.touched[first].push_back(second);
    found.touched[second].push_back(first);
  });
  for (std::vector<std::size_t>& others : found.touched) {
    std::ranges::sort(others);
    others.erase(std::unique(others.begin(), others.end()), others.end());
  }
  return found;
}

// The steps after which the connections of `wanted` are open: whatever moves is one of the pieces
// that what is handled stands between.
void Expander::Scratch::part_moves_to(SetView open, SetView wanted) {
  const std::vector<std::uint64_t> there(present(open).begin(), present(open).end());
  std::vector<std::uint64_t> apart = there;  // what is there while the pieces are apart
  std::vector<std::uint64_t> handled(open.begin(), open.end());
  for (std::size_t w = 0; w < rules.words; ++w) {
    handled[w] &= ~wanted[w];
    apart[w] &= ~handled[w];
  }
  subassemblies_now = subassemblies_of(there);
  const auto [all, touched] = touching_pieces(apart, handled);
  for (std::size_t p = 0; p < all.size(); ++p) {
    const std::vector<std::size_t>& others = touched[p];
    const auto is_base = [this](PartIndex part) { return problem.in_base(part); };
    if (others.empty() || all[p].size() > rules.max_moved_parts ||
        std::ranges::any_of(all[p], is_base))
      continue;
    std::vector<std::vector<PartIndex>> rest;
    for (const std::size_t other : others) rest.push_back(all[other]);
    offer_part(open, all[p], rest);
  }
}

// Takes a connected set of parts off its piece: all such sets of all pieces.
void Expander::Scratch::part_moves(SetView open) {
  const std::vector<std::uint64_t> there(present(open).begin(), present(open).end());
  const std::size_t parts = problem.num_parts();
  std::vector<std::vector<PartIndex>> neighbours(parts);
  for_each_connection(there, [&](ConnectionIndex c) {
    const auto [first, second] = problem.ends(c);
    if (first == second) return;
    neighbours[first].push_back(second);
    neighbours[second].push_back(first);
  });
  for (std::vector<PartIndex>& list : neighbours) {
    std::ranges::sort(list);
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  std::vector<unsigned char> in_rest(parts, 0);
  std::uint64_t asked = 0;
  subassemblies_now = subassemblies_of(there);
  rules.graph.for_each_piece(there, [&](std::span<const PartIndex> piece) {
    if (piece.size() < 2) return;
    const std::size_t most =
        std::min({piece.size() - 1, rules.max_moved_parts, rules.listing.most});
    if (most == 0) return;
    std::vector<PartIndex> loose;  // the parts that may move
    for (const PartIndex part : piece) {
      if (!problem.in_base(part)) loose.push_back(part);
    }
    std::ranges::sort(loose);
    // Sets may hold parts that may move only.
    std::vector<std::vector<PartIndex>> among(parts);
    for (const PartIndex part : loose) {
      for (const PartIndex other : neighbours[part]) {
        if (!problem.in_base(other)) among[part].push_back(other);
      }
    }
    const auto visit = [&](std::span<const PartIndex> moved) {
      leave_list_if_told(asked);
      for (const PartIndex part : piece) in_rest[part] = 1;
      for (const PartIndex part : moved) in_rest[part] = 0;
      // Most sets that cannot move are found out before the rest is looked at.
      if (rules.blocking && !leaves_somewhere(moved, in_rest)) {
        for (const PartIndex part : piece) in_rest[part] = 0;
        return;
      }
      // The pieces that the rest falls into.
      std::vector<std::vector<PartIndex>> rest;
      for (const PartIndex root : piece) {
        if (in_rest[root] == 0) continue;
        std::vector<PartIndex>& found = rest.emplace_back(1, root);
        in_rest[root] = 0;
        for (std::size_t i = 0; i < found.size(); ++i) {
          for (const PartIndex other : neighbours[found[i]]) {
            if (in_rest[other] == 0) continue;
            in_rest[other] = 0;
            found.push_back(other);
          }
        }
        std::ranges::sort(found);
      }
      offer_part(open, moved, rest);
    };
    ConnectedSets<decltype(visit)>(among, most, visit).list(loose);
  });
}

// Puts a piece onto one or several others that it touches.
void Expander::Scratch::making_part_moves(SetView open) {
  const std::vector<std::uint64_t> there(present(open).begin(), present(open).end());
  std::uint64_t asked = 0;
  subassemblies_now = subassemblies_of(there);
  const auto [all, touched] = touching_pieces(there, open);
  for (std::size_t p = 0; p < all.size(); ++p) {
    const std::vector<std::size_t>& others = touched[p];
    const auto is_base = [this](PartIndex part) { return problem.in_base(part); };
    if (all[p].size() > rules.max_moved_parts || std::ranges::any_of(all[p], is_base)) continue;
    // Every choice of pieces among those that it touches: first those that end with the first of
    // them, then those that end with the second, and so on.
    std::vector<std::vector<PartIndex>> rest;
    const auto choose = [&](const auto& self, std::size_t before) -> void {
      for (std::size_t i = 0; i < before; ++i) {
        leave_list_if_told(asked);
        rest.insert(rest.begin(), all[others[i]]);
        offer_part(open, all[p], rest);
        if (rest.size() < rules.listing.most) self(self, i);
        rest.erase(rest.begin());
      }
    };
    choose(choose, others.size());
  }
}

// Adds the step that takes `moved` off the pieces of `rest`, or puts it onto them, if it is legal.
void Expander::Scratch::offer_part(SetView open, std::span<const PartIndex> moved,
                                   std::span<const std::vector<PartIndex>> rest) {
  fill_a.assign(moved.begin(), moved.end());
  std::ranges::sort(fill_a);
  fill_b.clear();
  for (const std::vector<PartIndex>& piece : rest)
    fill_b.insert(fill_b.end(), piece.begin(), piece.end());
  std::ranges::sort(fill_b);
  pieces.a = {{fill_a, {}}};
  pieces.b = {{fill_b, {}}};
  StepFacts facts;
  facts.separates = true;
  facts.a_parts = static_cast<std::uint32_t>(fill_a.size());
  facts.b_parts = static_cast<std::uint32_t>(fill_b.size());
  const bool rest_is_base = pieces.has_base(pieces.b);
  Movement movement = pieces.movement(facts);
  if (rest.size() == 1 && !rest_is_base && !movement.a_moves) return;  // then the rest moves
  if (!movement.a_moves) std::swap(movement.moved_mass, movement.kept_mass);
  movement.moves = movement.a_moves = true;
  movement.moved_parts = facts.a_parts;
  movement.kept_parts = facts.b_parts;
  if (movement.moved_parts > rules.max_moved_parts ||
      !at_most(movement.moved_mass, rules.max_moved_mass))
    return;
  // All connections between the two, which must be there to be handled.
  std::vector<ConnectionIndex> between;
  for (const PartIndex part : fill_b) mark[part] = 1;
  bool accessible = true;
  for (const PartIndex part : fill_a) {
    for (const auto& half : rules.graph.around(part)) {
      if (mark[half.other] == 0) continue;
      if (contains(open, half.connection)) {
        between.push_back(half.connection);
      } else if (!rules.making && rules.kept.contains(half.connection)) {
        accessible = false;
      }
    }
  }
  for (const PartIndex part : fill_b) mark[part] = 0;
  if (!accessible || between.empty()) return;
  std::ranges::sort(between);
  // Subassemblies where the pieces are apart.
  const SetView before = present(open);
  const std::size_t now = subassemblies_now;
  std::size_t of_pieces = fill_a.size() >= 2 ? 1 : 0;
  rest_sizes.clear();
  for (const std::vector<PartIndex>& piece : rest) {
    of_pieces += piece.size() >= 2 ? 1 : 0;
    rest_sizes.push_back(static_cast<std::uint32_t>(piece.size()));
  }
  facts.subassemblies_apart = rules.making ? now : now - 1 + of_pieces;
  facts.subassemblies_joined = rules.making ? now - of_pieces + 1 : now;
  if (facts.subassemblies_apart > rules.max_subassemblies) return;
  if (rules.grounded) {
    if (fill_a.size() > 1) return;
    for (const std::vector<PartIndex>& piece : rest) {
      const auto is_base = [this](PartIndex part) { return problem.in_base(part); };
      if (std::ranges::none_of(piece, is_base)) return;
    }
  }
  next_open.assign(open.begin(), open.end());
  for (const ConnectionIndex c : between) next_open[c / 64] &= ~(std::uint64_t{1} << (c % 64));
  const bool allowed = piece_completes ? rules.precedence_met_within(next_open, between)
                                       : rules.state_allowed(next_open);
  if (!allowed) return;
  if (rules.blocking && !some_direction_free()) return;
  facts.connection = between.front();
  const std::size_t there = count(before);
  facts.before = there;
  facts.after = rules.making ? there + between.size() : there - between.size();
  if (rules.assembly && !rules.making) std::swap(facts.before, facts.after);
  facts.elapsed = handled_seconds;
  pieces.several = between;
  pieces.rest_sizes = rest_sizes;
  if (rules.assembly && !rules.making) facts.elapsed -= pieces.duration(facts);
  offer_move(open, facts, movement, between);
}

std::span<const Action> Expander::piece_steps(SetView piece, bool completes) {
  // An Expander whose list was left (ListingStopped) is not used again.
  scratch_->piece_completes = completes;
  const std::span<const Action> steps = scratch_->wide_actions(piece);
  scratch_->piece_completes.reset();
  return steps;
}

void Expander::successor(SetView state, const Action& action, std::span<std::uint64_t> next) const {
  const Scratch& s = *scratch_;
  if (s.rules.wide) {
    const std::size_t words = system_.words();
    std::ranges::copy(std::span(s.move_successors).subspan(action.number * words, next.size()),
                      next.begin());
    return;
  }
  std::ranges::copy(state, next.begin());
  next[action.connection / 64] &= ~(std::uint64_t{1} << (action.connection % 64));
}

PlanStep Expander::plan_step(const Action& action) const {
  const Scratch& s = *scratch_;
  if (!s.rules.wide) return {{action.connection}, std::nullopt};
  const Scratch::Move& move = s.moves[action.number];
  const auto first = s.move_connections.begin() + static_cast<std::ptrdiff_t>(move.first);
  return {{first, first + static_cast<std::ptrdiff_t>(move.size)}, move.direction};
}

// Of the legal actions that lead from one state to the other one that earns most.
std::optional<Action> Expander::best_action_to(SetView from, SetView to) {
  // Where steps take parts off there may be too many of them to go through. Where a goal is
  // reached, what is left open is not known.
  const bool over = system_.ends(to) && scratch_->rules.has_goal;
  if (!over) scratch_->target.assign(to.begin(), to.begin() + scratch_->rules.words);
  std::vector<std::uint64_t> next(system_.words());
  std::optional<Action> best;
  for (const Action& action : legal_actions(from)) {
    successor(from, action, next);
    if (std::ranges::equal(next, to) && (!best || action.reward > best->reward)) best = action;
  }
  scratch_->target.clear();
  return best;
}

bool Expander::leads_to(SetView from, SetView to) {
  return best_action_to(from, to).has_value();
}

PlanWalk Expander::steps_along(std::span<const std::uint64_t> states) {
  const std::size_t words = system_.words();
  PlanWalk walk;
  for (std::size_t i = 0; (i + 2) * words <= states.size(); ++i) {
    const auto best =
        best_action_to(states.subspan(i * words, words), states.subspan((i + 1) * words, words));
    if (!best) throw std::logic_error("no step leads from one state of a plan to the next");
    PlanStep step = plan_step(*best);
    walk.reward += best->reward;
    if (!step.connections.empty()) walk.steps.push_back(std::move(step));
  }
  return walk;
}

}  // namespace orasp
