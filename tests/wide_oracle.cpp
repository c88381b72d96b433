#include "tests/wide_oracle.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

namespace orasp::oracle {
namespace wide {
namespace {

/// A set of parts or of connections: bit i stands for the one at position i.
using Mask = std::uint64_t;

constexpr double kNever = -std::numeric_limits<double>::infinity();

Mask only(std::size_t member) {
  return Mask{1} << member;
}
bool has(Mask set, std::size_t member) {
  return (set >> member & 1U) != 0;
}
std::size_t size_of(Mask set) {
  return static_cast<std::size_t>(std::popcount(set));
}
std::vector<std::size_t> members(Mask set) {
  std::vector<std::size_t> list;
  for (std::size_t i = 0; i < 64; ++i) {
    if (has(set, i)) list.push_back(i);
  }
  return list;
}
/// Calls visit(subset) for each subset of a set but the empty one.
template <class Visit>
void for_each_subset(Mask set, Visit&& visit) {
  for (Mask subset = set; subset != 0; subset = (subset - 1) & set) visit(subset);
}

bool nearly(double x, double y) {
  return std::abs(x - y) <= 1e-9 * std::max(std::abs(x), std::abs(y));
}

std::string opposite_way(const std::string& direction) {
  if (direction[0] == '+') return "-" + direction.substr(1);
  if (direction[0] != '-') return "-" + direction;
  const std::string rest = direction.substr(1);
  return rest == "x" || rest == "y" || rest == "z" ? "+" + rest : rest;
}

/// All directions that blocking considers. One that is named stands there without its opposite.
std::vector<std::string> directions_of(const Blocking& blocking) {
  std::vector<std::string> all;
  for (const BlockingDirection& direction : blocking.directions) {
    for (const std::string& way : {direction.id, opposite_way(direction.id)}) {
      if (std::find(all.begin(), all.end(), way) == all.end()) all.push_back(way);
    }
  }
  return all;
}

/// What the terms of an objective look back at.
struct LooksBack {
  std::set<std::string> attributes;
  bool places = false;
};
void look_back_at(const Objective& objective, LooksBack& looks) {
  if (objective.type == "changeover")
    looks.attributes.insert(std::get<Changeover>(objective.parameters).attribute);
  if (objective.type == "route") looks.places = true;
  if (objective.type != "sum") return;
  for (const WeightedObjective& term : std::get<WeightedSum>(objective.parameters).terms)
    look_back_at(term.objective, looks);
}

double metres(const Vector3& x, const Vector3& y) {
  double squares = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) squares += (x[axis] - y[axis]) * (x[axis] - y[axis]);
  return std::sqrt(squares);
}

/// A legal step, told by what it does between the larger and the smaller of its two states.
struct Move {
  Mask connections = 0;
  std::size_t before = 0;  ///< connections present, in the problem's direction
  std::size_t after = 0;
  bool separates = false;
  bool completes = false;
  Mask a = 0;                ///< part steps: M; empty unless it separates, as all that follows
  Mask b = 0;                ///< part steps: the rest
  std::vector<Mask> pieces;  ///< what the larger piece falls into
  Mask moved = 0;            ///< empty also where both sides are fixed
  Mask kept = 0;
  std::size_t subassemblies = 0;
  double elapsed = 0;
  std::vector<std::string> directions;  ///< in which the moved piece is free
};

class World {
 public:
  explicit World(const ProblemSpec& spec);

  [[nodiscard]] Mask all() const { return all_; }
  [[nodiscard]] const LooksBack& looks() const { return looks_; }
  [[nodiscard]] bool blocks() const { return spec_.blocking.has_value(); }
  /// Whether the whole product obeys what holds at the start.
  [[nodiscard]] bool starts() const;
  [[nodiscard]] bool may_end(Mask open) const { return (open & wanted_) == 0; }
  [[nodiscard]] bool must_end(Mask open) const {
    return open == 0 || (may_end(open) && spec_.goal && spec_.goal->stop == Goal::Stop::Reached);
  }
  /// Ascending by their connections, read as numbers.
  [[nodiscard]] std::vector<Move> moves(Mask open) const;
  /// In which directions a planner may tell the moved piece to leave; "" where there is no choice.
  [[nodiscard]] std::vector<std::string> choices(const Move& move) const;
  [[nodiscard]] double reward(const Move& move, const std::string& direction,
                              const WideContext& context) const {
    return reward(spec_.objective, move, direction, context);
  }
  [[nodiscard]] WideContext after(const WideContext& context, const Move& move,
                                  const std::string& direction) const;
  [[nodiscard]] State state(Mask open) const;
  [[nodiscard]] Mask mask(const State& open) const;

 private:
  struct Clause {
    std::size_t connection;
    Mask after = 0;
    Mask after_any = 0;
    Mask made_after_any = 0;
  };
  using Block = std::pair<std::size_t, std::size_t>;  ///< part, blocked by part

  [[nodiscard]] bool assembles() const { return spec_.direction == Direction::Assembly; }
  [[nodiscard]] bool by_part() const { return spec_.action == StepKind::Part; }
  [[nodiscard]] std::size_t part(const std::string& id) const;
  [[nodiscard]] std::size_t connection(const std::string& id) const;
  void read_precedence();
  void read_blocking();

  [[nodiscard]] Mask piece_of(std::size_t part, Mask present) const;
  [[nodiscard]] std::vector<Mask> pieces(Mask present) const;
  [[nodiscard]] std::vector<Mask> pieces_within(Mask parts, Mask present) const;
  [[nodiscard]] std::size_t subassemblies(Mask present) const;
  [[nodiscard]] bool grounded(Mask present) const;
  [[nodiscard]] Mask between(Mask x, Mask y, Mask present) const;

  [[nodiscard]] double mass(Mask piece) const;
  [[nodiscard]] double sum(Mask piece, const std::string& number) const;
  [[nodiscard]] bool usual_move(Mask a, Mask b) const;
  [[nodiscard]] std::vector<std::string> free_directions(Mask moved, Mask kept) const;

  [[nodiscard]] std::optional<Move> removal(Mask larger, std::size_t connection) const;
  [[nodiscard]] std::optional<Move> taking_off(Mask larger, Mask piece, Mask taken) const;
  [[nodiscard]] bool rules_allow(Mask larger, Move& move) const;
  [[nodiscard]] bool precedence_allows(Mask larger, Mask removed) const;
  [[nodiscard]] std::vector<Move> connection_moves(Mask open) const;
  [[nodiscard]] std::vector<Move> parts_off(Mask open) const;
  [[nodiscard]] std::vector<Move> parts_on(Mask open) const;

  [[nodiscard]] double reward(const Objective& objective, const Move& move,
                              const std::string& direction, const WideContext& context) const;
  [[nodiscard]] double of_sizes(const Move& move, double operation,
                                const std::map<std::size_t, double>& costs,
                                double completion) const;
  [[nodiscard]] double of_zone(const Move& move) const;
  [[nodiscard]] double of_formula(const Expression& expression, const Move& move) const;
  [[nodiscard]] double of_change(const Changeover& changeover, const Move& move,
                                 const std::string& direction, const WideContext& context) const;
  [[nodiscard]] double duration(Mask connections) const;
  [[nodiscard]] std::optional<double> distance(Mask piece, const Vector3& depot) const;
  [[nodiscard]] std::optional<Vector3> place(Mask connections) const;
  [[nodiscard]] std::optional<std::string> value(const std::string& attribute, const Move& move,
                                                 const std::string& direction) const;

  ProblemSpec spec_;
  std::vector<std::pair<std::size_t, std::size_t>> ends_;
  Mask all_ = 0;     ///< connections
  Mask base_ = 0;    ///< parts
  Mask wanted_ = 0;  ///< connections that have to be handled
  std::vector<Clause> clauses_;
  std::vector<std::string> directions_;
  std::map<std::string, std::set<Block>> blocked_;  ///< by direction, both ways round
  std::set<std::string> numbers_;                   ///< the names that anybody states
  LooksBack looks_;
};

World::World(const ProblemSpec& spec) : spec_(spec) {
  if (spec_.parts.size() > 64 || spec_.connections.size() > 64)
    throw std::logic_error("oracle: too large for brute force");
  for (Connection& one : spec_.connections) {
    if (one.id.empty()) one.id = one.parts[0] + "-" + one.parts[1];
    all_ |= only(ends_.size());
    ends_.emplace_back(part(one.parts[0]), part(one.parts[1]));
    for (const auto& number : one.numbers) numbers_.insert(number.first);
  }
  for (const Part& one : spec_.parts) {
    for (const auto& number : one.numbers) numbers_.insert(number.first);
  }
  for (const std::string& id : spec_.base) base_ |= only(part(id));
  wanted_ = all_;
  if (spec_.goal) {
    wanted_ = 0;
    for (const std::string& id : spec_.goal->removed) wanted_ |= only(connection(id));
    for (const std::string& id : spec_.goal->free) {
      for (std::size_t c = 0; c < ends_.size(); ++c) {
        if (ends_[c].first == part(id) || ends_[c].second == part(id)) wanted_ |= only(c);
      }
    }
  }
  read_precedence();
  read_blocking();
  look_back_at(spec_.objective, looks_);
}

std::size_t World::part(const std::string& id) const {
  for (std::size_t i = 0; i < spec_.parts.size(); ++i) {
    if (spec_.parts[i].id == id) return i;
  }
  throw std::logic_error("oracle: no part " + id);
}

std::size_t World::connection(const std::string& id) const {
  for (std::size_t i = 0; i < spec_.connections.size(); ++i) {
    if (spec_.connections[i].id == id) return i;
  }
  throw std::logic_error("oracle: no connection " + id);
}

void World::read_precedence() {
  const auto all_of = [this](const std::vector<std::string>& ids) {
    Mask set = 0;
    for (const std::string& id : ids) set |= only(connection(id));
    return set;
  };
  for (const Precedence& entry : spec_.precedence) {
    const std::size_t c = connection(entry.connection);
    clauses_.push_back({.connection = c,
                        .after = all_of(entry.after),
                        .after_any = all_of(entry.after_any),
                        .made_after_any = all_of(entry.made_after_any)});
    for (const std::string& id : entry.made_after)
      clauses_.push_back({.connection = connection(id), .after = only(c)});
  }
}

void World::read_blocking() {
  if (!spec_.blocking) return;
  directions_ = directions_of(*spec_.blocking);
  for (const Blocked& entry : spec_.blocking->blocked) {
    for (const std::string& direction : entry.directions) {
      blocked_[direction].emplace(part(entry.part), part(entry.by));
      blocked_[opposite_way(direction)].emplace(part(entry.by), part(entry.part));
    }
  }
}

State World::state(Mask open) const {
  State state(ends_.size());
  for (const std::size_t c : members(open)) state[c] = true;
  return state;
}

Mask World::mask(const State& open) const {
  Mask mask = 0;
  for (std::size_t c = 0; c < open.size(); ++c) {
    if (open[c]) mask |= only(c);
  }
  return mask;
}

// -------------------------------------------------------------------------------------------------
// pieces

Mask World::piece_of(std::size_t part, Mask present) const {
  Mask piece = only(part);
  for (bool grows = true; grows;) {
    grows = false;
    for (const std::size_t c : members(present)) {
      const auto [first, second] = ends_[c];
      if (has(piece, first) == has(piece, second)) continue;
      piece |= only(first) | only(second);
      grows = true;
    }
  }
  return piece;
}

std::vector<Mask> World::pieces_within(Mask parts, Mask present) const {
  std::vector<Mask> found;
  Mask seen = 0;
  for (const std::size_t part : members(parts)) {
    if (has(seen, part)) continue;
    found.push_back(piece_of(part, present));
    seen |= found.back();
  }
  return found;
}

std::vector<Mask> World::pieces(Mask present) const {
  Mask parts = 0;
  for (std::size_t i = 0; i < spec_.parts.size(); ++i) parts |= only(i);
  return pieces_within(parts, present);
}

std::size_t World::subassemblies(Mask present) const {
  std::size_t number = 0;
  for (const Mask piece : pieces(present)) number += size_of(piece) >= 2 ? 1 : 0;
  return number;
}

bool World::grounded(Mask present) const {
  for (const Mask piece : pieces(present)) {
    if (size_of(piece) >= 2 && (piece & base_) == 0) return false;
  }
  return true;
}

/// The connections of `present` that join a part of x with a part of y.
Mask World::between(Mask x, Mask y, Mask present) const {
  Mask found = 0;
  for (const std::size_t c : members(present)) {
    const auto [first, second] = ends_[c];
    if ((has(x, first) && has(y, second)) || (has(y, first) && has(x, second))) found |= only(c);
  }
  return found;
}

double World::mass(Mask piece) const {
  double mass = 0;
  for (const std::size_t part : members(piece)) mass += spec_.parts[part].mass;
  return mass;
}

double World::sum(Mask piece, const std::string& number) const {
  double sum = 0;
  for (const std::size_t part : members(piece)) {
    const auto stated = spec_.parts[part].numbers.find(number);
    if (stated != spec_.parts[part].numbers.end()) sum += stated->second;
  }
  return sum;
}

/// Whether a is the moved piece where no base decides: the one with fewer parts; on a tie the
/// lighter; on a tie the one that does not hold the earliest listed of their parts.
bool World::usual_move(Mask a, Mask b) const {
  if (size_of(a) != size_of(b)) return size_of(a) < size_of(b);
  if (!nearly(mass(a), mass(b))) return mass(a) < mass(b);
  return !has(a, members(a | b).front());
}

std::vector<std::string> World::free_directions(Mask moved, Mask kept) const {
  std::vector<std::string> free;
  for (const std::string& direction : directions_) {
    bool is_free = true;
    if (const auto found = blocked_.find(direction); found != blocked_.end()) {
      for (const auto& [part, by] : found->second)
        is_free = is_free && !(has(moved, part) && has(kept, by));
    }
    if (is_free) free.push_back(direction);
  }
  return free;
}

// -------------------------------------------------------------------------------------------------
// steps, all spoken of as removals

bool World::starts() const {
  if (spec_.limits.max_subassemblies && subassemblies(all_) > *spec_.limits.max_subassemblies)
    return false;
  if (spec_.limits.grounded && !grounded(all_)) return false;
  for (const Clause& clause : clauses_) {
    if (clause.made_after_any == only(clause.connection)) return false;
  }
  return true;
}

bool World::precedence_allows(Mask larger, Mask removed) const {
  const Mask smaller = larger & ~removed;
  // What must be removed before may go in the same step, where a step takes several.
  const Mask not_in_time = by_part() ? smaller : larger;
  for (const Clause& clause : clauses_) {
    if (has(removed, clause.connection)) {
      if ((clause.after & not_in_time) != 0) return false;
      if (clause.after_any != 0 && (clause.after_any & ~not_in_time) == 0) return false;
    }
    const Mask others = clause.made_after_any & ~only(clause.connection);
    if (clause.made_after_any != 0 && has(smaller, clause.connection) && (others & smaller) == 0)
      return false;
  }
  return true;
}

/// Judges a move of which connections, a, b, pieces, moved and kept are known, and fills the rest.
bool World::rules_allow(Mask larger, Move& move) const {
  const Mask smaller = larger & ~move.connections;
  const Limits& limits = spec_.limits;
  if (!precedence_allows(larger, move.connections)) return false;
  if (limits.grounded && !(grounded(larger) && grounded(smaller))) return false;
  if (move.separates) {
    if (limits.max_subassemblies && subassemblies(smaller) > *limits.max_subassemblies)
      return false;
  }
  if (move.moved != 0) {
    if (limits.max_moved_parts && size_of(move.moved) > *limits.max_moved_parts) return false;
    if (limits.max_moved_mass && mass(move.moved) > *limits.max_moved_mass &&
        !nearly(mass(move.moved), *limits.max_moved_mass))
      return false;
    move.directions = free_directions(move.moved, move.kept);
    if (spec_.blocking && move.directions.empty()) return false;
  }
  const Mask here = assembles() ? smaller : larger;
  const Mask there = assembles() ? larger : smaller;
  move.before = size_of(here);
  move.after = size_of(there);
  move.completes = assembles() ? there == all_ : there == 0;
  if (spec_.goal && spec_.goal->stop == Goal::Stop::Reached) move.completes = may_end(there);
  move.subassemblies = subassemblies(there);
  move.elapsed = duration(assembles() ? smaller : all_ & ~larger);
  return true;
}

std::optional<Move> World::removal(Mask larger, std::size_t connection) const {
  Move move;
  move.connections = only(connection);
  const Mask smaller = larger & ~only(connection);
  const Mask a = piece_of(ends_[connection].first, smaller);
  const Mask b = piece_of(ends_[connection].second, smaller);
  if (a != b) {
    move.separates = true;
    move.a = a;
    move.b = b;
    move.pieces = {a, b};
    const bool a_fixed = (a & base_) != 0;
    const bool b_fixed = (b & base_) != 0;
    if (a_fixed && b_fixed) {
      move.kept = a | b;
    } else {
      const bool a_moves = a_fixed != b_fixed ? b_fixed : usual_move(a, b);
      move.moved = a_moves ? a : b;
      move.kept = a_moves ? b : a;
    }
  }
  if (!rules_allow(larger, move)) return std::nullopt;
  return move;
}

/// The step that takes the parts `taken` off `piece`, a piece of the state `larger`.
std::optional<Move> World::taking_off(Mask larger, Mask piece, Mask taken) const {
  const Mask rest = piece & ~taken;
  if (rest == 0 || (taken & base_) != 0) return std::nullopt;
  Move move;
  move.connections = between(taken, rest, larger);
  const Mask smaller = larger & ~move.connections;
  if (piece_of(members(taken).front(), smaller) != taken) return std::nullopt;
  move.separates = true;
  move.a = move.moved = taken;
  move.b = move.kept = rest;
  const std::vector<Mask> pieces_of_rest = pieces_within(rest, smaller);
  move.pieces = pieces_of_rest;
  move.pieces.push_back(taken);
  if (pieces_of_rest.size() == 1 && (rest & base_) == 0 && !usual_move(taken, rest))
    return std::nullopt;
  if (spec_.limits.grounded) {
    for (const Mask one : pieces_of_rest) {
      if ((one & base_) == 0) return std::nullopt;
    }
  }
  if (!rules_allow(larger, move)) return std::nullopt;
  return move;
}

std::vector<Move> World::connection_moves(Mask open) const {
  std::vector<Move> found;
  for (const std::size_t c : members(open)) {
    const Mask larger = assembles() ? (all_ & ~open) | only(c) : open;
    if (auto move = removal(larger, c)) found.push_back(std::move(*move));
  }
  return found;
}

std::vector<Move> World::parts_off(Mask open) const {
  std::vector<Move> found;
  for (const Mask piece : pieces(open)) {
    for_each_subset(piece, [&](Mask taken) {
      if (auto move = taking_off(open, piece, taken)) found.push_back(std::move(*move));
    });
  }
  return found;
}

/// M is a piece that is there, and is put on pieces that are there, with all their connections to
/// it: in disassembly the parts of a piece hang together by all the connections among them.
std::vector<Move> World::parts_on(Mask open) const {
  std::vector<Move> found;
  const Mask made = all_ & ~open;
  const std::vector<Mask> there = pieces(made);
  for (const Mask taken : there) {
    Mask others = 0;  // numbers of the pieces that M could be put on
    for (std::size_t i = 0; i < there.size(); ++i) {
      if (there[i] != taken && between(taken, there[i], open) != 0) others |= only(i);
    }
    for_each_subset(others, [&](Mask chosen) {
      Mask piece = taken;
      for (const std::size_t i : members(chosen)) piece |= there[i];
      const Mask larger = made | between(taken, piece & ~taken, open);
      if (between(piece, piece, open & ~larger) != 0) return;
      if (auto move = taking_off(larger, piece, taken)) found.push_back(std::move(*move));
    });
  }
  return found;
}

std::vector<Move> World::moves(Mask open) const {
  std::vector<Move> found = !by_part()    ? connection_moves(open)
                            : assembles() ? parts_on(open)
                                          : parts_off(open);
  std::sort(found.begin(), found.end(),
            [](const Move& x, const Move& y) { return x.connections < y.connections; });
  return found;
}

std::vector<std::string> World::choices(const Move& move) const {
  return move.directions.empty() ? std::vector<std::string>{""} : move.directions;
}

// -------------------------------------------------------------------------------------------------
// rewards

double World::duration(Mask connections) const {
  double seconds = 0;
  for (const std::size_t c : members(connections)) seconds += spec_.connections[c].duration;
  return seconds;
}

std::optional<double> World::distance(Mask piece, const Vector3& depot) const {
  Vector3 centroid{};
  for (const std::size_t part : members(piece)) {
    const auto& position = spec_.parts[part].position;
    if (!position) return std::nullopt;
    for (std::size_t axis = 0; axis < 3; ++axis) centroid[axis] += (*position)[axis];
  }
  for (double& coordinate : centroid) coordinate /= static_cast<double>(size_of(piece));
  return metres(centroid, depot);
}

/// Where the work is done: the mean of the places of the connections.
std::optional<Vector3> World::place(Mask connections) const {
  Vector3 mean{};
  for (const std::size_t c : members(connections)) {
    const auto& first = spec_.parts[ends_[c].first].position;
    const auto& second = spec_.parts[ends_[c].second].position;
    const auto& stated = spec_.connections[c].position;
    if (!stated && !(first && second)) return std::nullopt;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      mean[axis] += (stated ? (*stated)[axis] : ((*first)[axis] + (*second)[axis]) / 2) /
                    static_cast<double>(size_of(connections));
    }
  }
  return mean;
}

std::optional<std::string> World::value(const std::string& attribute, const Move& move,
                                        const std::string& direction) const {
  if (attribute == "direction") {
    return direction.empty() ? std::nullopt : std::optional<std::string>(direction);
  }
  std::set<std::string> stated;
  for (const std::size_t c : members(move.connections)) {
    const auto found = spec_.connections[c].attributes.find(attribute);
    if (found != spec_.connections[c].attributes.end()) stated.insert(found->second);
  }
  if (stated.size() != 1) return std::nullopt;
  return *stated.begin();
}

WideContext World::after(const WideContext& context, const Move& move,
                         const std::string& direction) const {
  WideContext next = context;
  for (const std::string& attribute : looks_.attributes) {
    if (const auto here = value(attribute, move, direction)) next.in_force[attribute] = *here;
  }
  if (looks_.places) next.place = place(move.connections);
  return next;
}

double World::of_sizes(const Move& move, double operation,
                       const std::map<std::size_t, double>& costs, double completion) const {
  if (move.completes) return completion;
  double cost = operation;
  for (const Mask piece : move.pieces) {
    if (const auto found = costs.find(size_of(piece)); found != costs.end()) cost += found->second;
  }
  return -cost;
}

double World::of_zone(const Move& move) const {
  if (move.completes) return 1;
  if (!move.separates) return 0;
  const Mask whole = move.a | move.b;
  const bool far = size_of(whole) >= 4 || whole == piece_of(members(whole).front(), all_);
  double cost = 0;
  for (const Mask piece : move.pieces) {
    if (size_of(piece) == 1) cost += far ? 0.0967 : 0.0823;
    if (size_of(piece) == 2) cost += 0.0722;
    if (size_of(piece) == 3) cost += 0.0782;
  }
  return -cost;
}

double World::of_formula(const Expression& expression, const Move& move) const {
  std::map<std::string, double> names = expression.constants;
  names["before"] = static_cast<double>(move.before);
  names["after"] = static_cast<double>(move.after);
  names["separates"] = move.separates ? 1 : 0;
  names["completes"] = move.completes ? 1 : 0;
  names["moved_parts"] = static_cast<double>(size_of(move.moved));
  names["kept_parts"] = static_cast<double>(size_of(move.kept));
  names["moved_mass"] = mass(move.moved);
  names["kept_mass"] = mass(move.kept);
  names["subassemblies"] = static_cast<double>(move.subassemblies);
  names["duration"] = duration(move.connections);
  names["elapsed"] = move.elapsed;
  names["distance"] = move.moved == 0 ? 0 : distance(move.moved, expression.depot).value_or(0);
  if (!by_part()) names["index"] = static_cast<double>(members(move.connections).front());
  for (const std::string& number : numbers_) {
    double own = 0;
    for (const std::size_t c : members(move.connections)) {
      const auto& stated = spec_.connections[c].numbers;
      if (const auto found = stated.find(number); found != stated.end()) own += found->second;
    }
    names[number] = own;
    names["moved_" + number] = sum(move.moved, number);
    names["kept_" + number] = sum(move.kept, number);
  }
  return formula_value(expression.formula, names);
}

double World::of_change(const Changeover& changeover, const Move& move,
                        const std::string& direction, const WideContext& context) const {
  const std::optional<std::string> here = value(changeover.attribute, move, direction);
  std::optional<std::string> in_force = changeover.start;
  if (const auto last = context.in_force.find(changeover.attribute);
      last != context.in_force.end()) {
    in_force = last->second;
  }
  if (!here || !in_force || *here == *in_force) return 0;
  for (const ChangeCost& change : changeover.costs) {
    if (change.from == *in_force && change.to == *here) return -change.cost;
  }
  return -changeover.cost;
}

double World::reward(const Objective& objective, const Move& move, const std::string& direction,
                     const WideContext& context) const {
  const std::string& type = objective.type;
  if (type == "cubesat") return of_sizes(move, 0, {{1, 0.0967}, {2, 0.1248}, {3, 0.1368}}, 1);
  if (type == "custom") return of_sizes(move, 0.1, {{1, 1.0}, {2, 1.5}, {3, 1.75}}, 1);
  if (type == "piece_cost") {
    const auto& p = std::get<PieceCost>(objective.parameters);
    return of_sizes(move, p.operation, p.pieces, p.completion);
  }
  if (type == "cubesat_zone") return of_zone(move);
  if (type == "indexed" && !by_part()) {
    const auto n = static_cast<double>(move.before);
    const auto i = static_cast<double>(members(move.connections).front());
    return i < n - 1 ? n - i : -1;
  }
  if (type == "time") {
    const auto& p = std::get<TimeObjective>(objective.parameters);
    double seconds = duration(move.connections);
    if (move.moved != 0) {
      const auto far = distance(move.moved, p.depot);
      seconds += far ? 2 * *far / p.speed : p.transfer;
    }
    return -seconds;
  }
  if (type == "travel") {
    if (move.moved == 0) return 0;
    const double far = distance(move.moved, std::get<Travel>(objective.parameters).depot).value();
    return -static_cast<double>(size_of(move.moved)) * far * far;
  }
  if (type == "fuel") {
    if (move.moved == 0) return 0;
    const auto& p = std::get<Fuel>(objective.parameters);
    const double factor = std::exp(p.delta_v / (p.isp * 9.80665)) - 1;
    return -(p.dry_mass * factor + (p.dry_mass + mass(move.moved)) * factor);
  }
  if (type == "completion") {
    const auto& p = std::get<CompletionObjective>(objective.parameters);
    return (move.separates ? p.join : 0) - p.step + (move.completes ? p.bonus : 0);
  }
  if (type == "expression") return of_formula(std::get<Expression>(objective.parameters), move);
  if (type == "changeover")
    return of_change(std::get<Changeover>(objective.parameters), move, direction, context);
  if (type == "route") {
    const auto& p = std::get<Route>(objective.parameters);
    const std::optional<Vector3> from = context.place ? context.place : p.start;
    return from ? -p.per_metre * metres(*from, place(move.connections).value()) : 0;
  }
  if (type == "sum") {
    double total = 0;
    for (const WeightedObjective& term : std::get<WeightedSum>(objective.parameters).terms)
      total += term.weight * reward(term.objective, move, direction, context);
    return total;
  }
  throw std::logic_error("oracle: the objective " + type + " does not apply");
}

// -------------------------------------------------------------------------------------------------
// plans

/// All plans from all states that are asked about, each worked out once.
class Search {
 public:
  explicit Search(const World& world) : world_(world) {}

  double best_to_go(Mask open, const WideContext& context) {
    const std::pair key(open, context);
    if (const auto found = to_go_.find(key); found != to_go_.end()) return found->second;
    double best = world_.may_end(open) ? 0 : kNever;
    if (!world_.must_end(open)) {
      for_each_way(open, [&](const Move& move, const std::string& direction) {
        best = std::max(best, through(open, context, move, direction));
      });
    }
    to_go_[key] = best;
    return best;
  }

  std::uint64_t plans(Mask open) {
    if (const auto found = plans_.find(open); found != plans_.end()) return found->second;
    std::uint64_t number = world_.may_end(open) ? 1 : 0;
    if (!world_.must_end(open)) {
      for (const Move& move : moves(open)) {
        const std::uint64_t more = plans(open & ~move.connections);
        number = number + more < number ? std::numeric_limits<std::uint64_t>::max() : number + more;
      }
    }
    plans_[open] = number;
    return number;
  }

  std::vector<WideStep> best_plan() {
    std::vector<WideStep> plan;
    Mask open = world_.all();
    WideContext context;
    while (best_to_go(open, context) > kNever) {
      const double best = best_to_go(open, context);
      if (world_.must_end(open) || (world_.may_end(open) && best == 0)) break;
      std::optional<std::pair<Move, std::string>> way;
      for_each_way(open, [&](const Move& move, const std::string& direction) {
        if (!way && through(open, context, move, direction) == best) way = {move, direction};
      });
      plan.push_back({members(way->first.connections), way->second});
      context = world_.after(context, way->first, way->second);
      open &= ~way->first.connections;
    }
    return plan;
  }

  [[nodiscard]] const auto& known() const { return to_go_; }

 private:
  const std::vector<Move>& moves(Mask open) {
    if (!moves_.contains(open)) moves_[open] = world_.moves(open);
    return moves_.at(open);
  }
  template <class Visit>
  void for_each_way(Mask open, Visit&& visit) {
    for (const Move& move : moves(open)) {
      for (const std::string& direction : world_.choices(move)) visit(move, direction);
    }
  }
  double through(Mask open, const WideContext& context, const Move& move,
                 const std::string& direction) {
    return world_.reward(move, direction, context) +
           best_to_go(open & ~move.connections, world_.after(context, move, direction));
  }

  const World& world_;
  std::map<Mask, std::vector<Move>> moves_;
  std::map<std::pair<Mask, WideContext>, double> to_go_;
  std::map<Mask, std::uint64_t> plans_;
};

}  // namespace
}  // namespace wide

WideResult wide_brute_force(const ProblemSpec& spec) {
  const wide::World world(spec);
  WideResult result;
  if (!world.starts()) return result;
  wide::Search search(world);
  const double best = search.best_to_go(world.all(), {});
  for (const auto& [key, value] : search.known())
    result.best_to_go.emplace(std::pair(world.state(key.first), key.second), value);
  result.plans = search.plans(world.all());
  if (best == wide::kNever) return result;
  result.best = best;
  result.best_plan = search.best_plan();
  return result;
}

std::vector<WideStep> wide_best_plan(const ProblemSpec& spec) {
  return wide_brute_force(spec).best_plan;
}

std::optional<double> wide_reward_of(const ProblemSpec& spec, const std::vector<WideStep>& plan) {
  const wide::World world(spec);
  if (!world.starts()) return std::nullopt;
  double total = 0;
  wide::Mask open = world.all();
  WideContext context;
  for (const WideStep& step : plan) {
    if (world.must_end(open)) return std::nullopt;
    const std::vector<wide::Move> moves = world.moves(open);
    const auto move = std::find_if(moves.begin(), moves.end(), [&](const wide::Move& one) {
      return wide::members(one.connections) == step.connections;
    });
    if (move == moves.end()) return std::nullopt;
    const std::vector<std::string> ways = world.choices(*move);
    const bool left_out = step.direction.empty() && !world.looks().attributes.contains("direction");
    if (!left_out && std::find(ways.begin(), ways.end(), step.direction) == ways.end())
      return std::nullopt;
    total += world.reward(*move, step.direction, context);
    context = world.after(context, *move, step.direction);
    open &= ~move->connections;
  }
  if (!world.may_end(open)) return std::nullopt;
  return total;
}

std::vector<WideChoice> wide_choices(const ProblemSpec& spec, const State& open) {
  const wide::World world(spec);
  std::vector<WideChoice> choices;
  if (world.must_end(world.mask(open))) return choices;
  for (const wide::Move& move : world.moves(world.mask(open))) {
    const std::vector<std::size_t> moved = wide::members(move.moved);
    choices.push_back({.connections = wide::members(move.connections),
                       .free_directions = move.directions,
                       .separates = move.separates,
                       .completes = move.completes,
                       .moved = Parts(moved.begin(), moved.end())});
  }
  return choices;
}

}  // namespace orasp::oracle
