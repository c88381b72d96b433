#include "orasp/model/detail/plan_replay.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "orasp/model/detail/checked_reward.h"
#include "orasp/model/detail/look_back.h"
#include "orasp/model/detail/part_replay.h"
#include "orasp/model/detail/reward_size.h"
#include "orasp/model/detail/wording.h"

namespace orasp::detail {

namespace {

/// Two masses that differ by less, relatively, are the same to a user (0.1 + 0.2 and 0.3).
constexpr double kSameMass = 1e-9;

/// Positions in the sequence, from 1, and the two times outside it.
constexpr std::size_t kBeforeAll = 0;
constexpr std::size_t kNever = std::numeric_limits<std::size_t>::max();

/// Parts that hang together, and what is added up over them.
struct Piece {
  std::size_t parts = 1;
  double mass = 0;
  Vector3 positions{};
  std::size_t without_position = 0;
  PartIndex earliest = 0;
  std::size_t base_parts = 0;
  std::map<std::string, double> numbers{};       ///< the user's own, added up
  std::map<std::string, double> number_sizes{};  ///< their absolute values, added up

  void take_in(const Piece& other) {
    parts += other.parts;
    mass += other.mass;
    for (std::size_t axis = 0; axis < 3; ++axis) positions[axis] += other.positions[axis];
    without_position += other.without_position;
    earliest = std::min(earliest, other.earliest);
    base_parts += other.base_parts;
    for (const auto& [name, sum] : other.numbers) numbers[name] += sum;
    for (const auto& [name, sum] : other.number_sizes) number_sizes[name] += sum;
  }
};

/// A piece to add parts to, the first of which is `first`.
Piece nothing_yet(PartIndex first) {
  Piece piece;
  piece.parts = 0;
  piece.earliest = first;
  return piece;
}

class Replayer {
 public:
  Replayer(const Problem& problem, const Situation& situation,
           std::span<const ConnectionIndex> sequence, bool with_steps,
           std::span<const std::optional<DirectionIndex>> directions)
      : problem_(problem),
        situation_(situation),
        sequence_(sequence),
        directions_(directions),
        assembly_(problem.direction() == Direction::Assembly),
        reward_(problem),
        with_steps_(with_steps),
        whole_steps_(with_steps || reward_.needs_step()),
        looks_back_(reward_.looks_back()),
        ends_when_reached_(problem.spec().goal &&
                           problem.spec().goal->stop == Goal::Stop::Reached) {}

  PlanReplay run();
  /// Steps are to list nothing but what moves.
  void list_moved_only() {
    moved_only_ = !reward_.needs_step() && !looks_back_;
    if (moved_only_) whole_steps_ = false;
  }

 private:
  /// A step that can be made: its position in the sequence, and how many of them come before it.
  struct Made {
    std::size_t time;
    std::size_t place;
    ConnectionIndex connection;
  };

  [[nodiscard]] bool to_be_handled(ConnectionIndex c) const {
    return situation_.open.contains(c) && !situation_.inaccessible.contains(c);
  }
  void find_times();
  void judge_goal();
  void judge_precedence();
  void blame_start();
  [[nodiscard]] std::vector<PlanFault> precedence_faults(ConnectionIndex c, std::size_t time) const;
  [[nodiscard]] std::vector<const PrecedenceClause*> shut_out(ConnectionIndex c,
                                                              std::size_t time) const;
  [[nodiscard]] bool still_to_make(ConnectionIndex c, std::size_t time) const {
    return handled_at_[c] >= time && handled_at_[c] != kBeforeAll &&
           !situation_.inaccessible.contains(c);
  }
  [[nodiscard]] bool there(ConnectionIndex c, std::size_t time) const {
    return assembly_ ? handled_at_[c] < time : handled_at_[c] >= time;
  }
  /// The connection that stands in the way, by one clause, of handling `c` at `time`.
  [[nodiscard]] std::optional<ConnectionIndex> held_back(const PrecedenceClause& clause,
                                                         std::size_t time) const;
  [[nodiscard]] bool all_there(const PrecedenceClause& clause, std::size_t time) const;
  [[nodiscard]] bool unsupported(const PrecedenceClause& clause, std::size_t time) const;

  void start_pieces();
  void merge(ConnectionIndex c);
  [[nodiscard]] Piece lone_piece(PartIndex part) const;
  [[nodiscard]] double mass(const Piece& piece) const;
  [[nodiscard]] bool first_moves(const Piece& a, const Piece& b) const;
  template <class InOther>
  [[nodiscard]] bool blocked(std::span<const PartIndex> few, InOther&& in_other);
  [[nodiscard]] std::span<const PartIndex> members(PartIndex piece);
  [[nodiscard]] bool each_blocks_the_other(PartIndex a, PartIndex b);
  [[nodiscard]] std::vector<DirectionIndex> ways_out(PartIndex moved, PartIndex kept);
  void judge_direction(const Made& made, const Step& step, PartIndex a, PartIndex b);
  void judge_cut(const Made& step, PartIndex a, PartIndex b);
  void judge_ground(const Made& step, const Piece& a, const Piece& b);
  [[nodiscard]] bool stands(const Piece& a, const Piece& b) const;
  void judge_ground_now();
  [[nodiscard]] bool cut_allowed(const Piece& a, const Piece& b, std::size_t apart) const;
  void make(const Made& step);
  static void see_numbers(SeenStep& seen, const Piece& moved, const Piece& kept, bool moves);
  void add_up_durations();
  void keep_for_later(const Made& made, const SeenStep& seen, Step step, PartIndex a, PartIndex b);
  void look_back();
  void list_sides(Step& step, PartIndex a, PartIndex b, Piece& piece_a, Piece& piece_b) const;
  void judge_order(const Made& step);
  [[nodiscard]] bool may_shut_out() const;
  [[nodiscard]] bool can_be_handled(ConnectionIndex c, std::size_t time);
  [[nodiscard]] bool cut_allowed_apart(ConnectionIndex c, std::size_t time);
  void judge_start();
  void fault(const Made& step, Constraint constraint, PlanFault details = {});

  const Problem& problem_;
  const Situation& situation_;
  std::span<const ConnectionIndex> sequence_;
  std::span<const std::optional<DirectionIndex>> directions_;
  bool assembly_;
  CheckedReward reward_;
  bool with_steps_;
  bool whole_steps_;
  bool moved_only_ = false;
  bool looks_back_;
  bool ends_when_reached_;
  PlanReplay replay_;

  std::vector<Made> made_;
  std::vector<std::size_t> handled_at_;  ///< by connection: a time
  std::size_t to_handle_ = 0;
  std::size_t reached_at_ = kNever;  ///< the time at which the plan ends by its goal
  std::size_t kept_ = 0;             ///< open and inaccessible

  // The pieces as they are now. A piece is called after one of its parts.
  std::vector<PartIndex> piece_of_;
  std::vector<PartIndex> next_;  ///< by part: the next one of the same piece, round and round
  std::vector<Piece> pieces_;
  std::size_t subassemblies_ = 0;
  bool equal_masses_ = true;
  std::vector<PartIndex> listed_;
  std::vector<std::uint64_t> free_;  ///< directions, as bits

  // For late connections.
  std::vector<ConnectionIndex> ordinary_;             ///< to be handled and not late
  std::size_t last_ordinary_ = 0;                     ///< the time after which none of them is open
  std::vector<std::vector<ConnectionIndex>> around_;  ///< by part
  std::vector<unsigned char> reached_;                ///< by part; all 0 between uses

  /// Where the objective looks back: the steps, until all are known.
  std::vector<KeptStep> kept_steps_;
  std::vector<double> elapsed_;  ///< s before each step, in the order of the plan
  std::vector<double> rewards_;  ///< in the order of the plan
  double magnitude_ = 0;
  double rounding_ = 0;
  std::optional<std::pair<Made, CheckedReward::Value>> unfit_;  ///< the first in the plan
};

void Replayer::fault(const Made& step, Constraint constraint, PlanFault details) {
  details.step = step.time;
  details.constraint = constraint;
  details.connection = step.connection;
  replay_.faults.push_back(details);
}

void Replayer::find_times() {
  const std::size_t connections = problem_.num_connections();
  handled_at_.assign(connections, kBeforeAll);
  for (ConnectionIndex c = 0; c < connections; ++c) {
    if (!situation_.open.contains(c)) continue;
    handled_at_[c] = kNever;
    ++(situation_.inaccessible.contains(c) ? kept_ : to_handle_);
  }
  made_.reserve(sequence_.size());
  for (std::size_t i = 0; i < sequence_.size(); ++i) {
    const Made step{i + 1, made_.size(), sequence_[i]};
    if (step.connection >= connections || handled_at_[step.connection] != kNever) {
      fault(step, Constraint::NotOpen);
    } else if (situation_.inaccessible.contains(step.connection)) {
      fault(step, Constraint::Inaccessible);
    } else {
      handled_at_[step.connection] = step.time;
      made_.push_back(step);
    }
  }
  if (problem_.spec().goal) {
    judge_goal();
    return;
  }
  if (made_.size() == to_handle_) return;
  for (ConnectionIndex c = 0; c < connections; ++c) {
    if (to_be_handled(c) && handled_at_[c] == kNever)
      fault({sequence_.size() + 1, made_.size(), c}, Constraint::NotOpen);
  }
}

// What the goal asks for must be gone at the end, and, where the plan ends as soon as it is, not
// before.
void Replayer::judge_goal() {
  std::size_t reached = kBeforeAll;  // the time of the step after which the goal holds
  for (const ConnectionIndex c : problem_.goal()) {
    reached = std::max(reached, handled_at_[c]);
    if (handled_at_[c] != kNever) continue;
    fault({sequence_.size() + 1, made_.size(), c},
          situation_.inaccessible.contains(c) ? Constraint::Inaccessible : Constraint::NotOpen);
  }
  if (!ends_when_reached_) return;
  reached_at_ = reached;
  for (const Made& step : made_) {
    if (step.time > reached) {
      fault(step, Constraint::Goal);
      return;
    }
  }
}

// Precedence speaks of removals: what `after` names must not be there while the connection is. A
// connection is itself there while it is handled, in both directions.
std::optional<ConnectionIndex> Replayer::held_back(const PrecedenceClause& clause,
                                                   std::size_t time) const {
  for (const ConnectionIndex other : clause.after) {
    if (other == clause.connection || there(other, time)) return other;
  }
  return std::nullopt;
}

bool Replayer::all_there(const PrecedenceClause& clause, std::size_t time) const {
  return !clause.after_any.empty() &&
         std::ranges::all_of(clause.after_any, [&](ConnectionIndex other) {
           return other == clause.connection || there(other, time);
         });
}

// Whether no member of made_after_any is there beside the connection that is handled at `time`.
bool Replayer::unsupported(const PrecedenceClause& clause, std::size_t time) const {
  return !clause.made_after_any.empty() &&
         std::ranges::none_of(clause.made_after_any, [&](ConnectionIndex other) {
           return other != clause.connection && there(other, time) && handled_at_[other] != time;
         });
}

void Replayer::judge_precedence() {
  if (to_handle_ == 0) return;
  bool broken = made_.size() != to_handle_;
  for (const PrecedenceClause& clause : problem_.precedence()) {
    const std::size_t time = handled_at_[clause.connection];
    // What is inaccessible stays, and under a goal what is not taken off.
    const bool stays = !assembly_ && (situation_.inaccessible.contains(clause.connection) ||
                                      problem_.spec().goal.has_value());
    if (time == kNever && stays) broken = broken || unsupported(clause, sequence_.size() + 1);
    if (time == kBeforeAll || time == kNever) continue;
    broken =
        broken || held_back(clause, time) || all_there(clause, time) || unsupported(clause, time);
  }
  if (!broken) return;
  blame_start();
  for (const Made& step : made_) {
    for (const PlanFault& details : precedence_faults(step.connection, step.time))
      fault(step, details.constraint, details);
  }
}

// Rules that are broken where the plan begins.
void Replayer::blame_start() {
  for (const PrecedenceClause& clause : problem_.precedence()) {
    if (handled_at_[clause.connection] == kBeforeAll) continue;
    PlanFault details;
    details.entry = clause.entry;
    details.connection = clause.connection;
    const auto add = [&](Constraint constraint) {
      details.constraint = constraint;
      replay_.faults.push_back(details);
    };
    if (!assembly_) {
      if (unsupported(clause, kBeforeAll)) add(Constraint::PrecedenceMadeAny);
      continue;
    }
    if (situation_.inaccessible.contains(clause.connection)) continue;
    const auto made = [&](ConnectionIndex other) { return handled_at_[other] == kBeforeAll; };
    if (const auto other = std::ranges::find_if(clause.after, made); other != clause.after.end()) {
      details.other = *other;
      add(Constraint::Precedence);
    }
    if (!clause.after_any.empty() &&
        std::ranges::all_of(clause.after_any, [&](ConnectionIndex other) {
          return made(other) || other == clause.connection;
        }))
      add(Constraint::PrecedenceAny);
  }
}

// The rules of precedence that handling `c` at `time` breaks, in the state that the steps before
// that leave: by what must come before it, and by what could never be handled after it.
std::vector<PlanFault> Replayer::precedence_faults(ConnectionIndex c, std::size_t time) const {
  std::vector<PlanFault> faults;
  const auto add = [&](Constraint constraint, const PrecedenceClause& clause,
                       ConnectionIndex other) {
    PlanFault details;
    details.constraint = constraint;
    details.entry = clause.entry;
    details.other = other;
    faults.push_back(details);
  };
  for (const PrecedenceClause& clause : problem_.precedence()) {
    if (assembly_) {
      if (still_to_make(clause.connection, time) &&
          std::ranges::find(clause.after, c) != clause.after.end())
        add(Constraint::Precedence, clause, clause.connection);
      if (clause.connection == c && unsupported(clause, time))
        add(Constraint::PrecedenceMadeAny, clause, c);
    } else if (clause.connection == c) {
      if (const auto other = held_back(clause, time)) add(Constraint::Precedence, clause, *other);
      if (all_there(clause, time)) add(Constraint::PrecedenceAny, clause, c);
    }
  }
  for (const PrecedenceClause* clause : shut_out(c, time)) {
    add(assembly_ ? Constraint::PrecedenceAny : Constraint::PrecedenceMadeAny, *clause,
        clause->connection);
  }
  return faults;
}

// The clauses that name `c` in a list of which one must be there (disassembly) or gone (assembly),
// and that cannot be kept once `c` is handled at `time`. In disassembly: what is then there is put
// on, as far as that goes, starting from nothing; in assembly what is then missing is taken off,
// starting from the product.
std::vector<const PrecedenceClause*> Replayer::shut_out(ConnectionIndex c, std::size_t time) const {
  const auto list_of = [this](const PrecedenceClause& clause) -> const auto& {
    return assembly_ ? clause.after_any : clause.made_after_any;
  };
  std::vector<const PrecedenceClause*> naming;
  for (const PrecedenceClause& clause : problem_.precedence()) {
    if (std::ranges::find(list_of(clause), c) != list_of(clause).end()) naming.push_back(&clause);
  }
  if (naming.empty()) return {};
  const std::size_t connections = problem_.num_connections();
  std::vector<bool> left(connections);  // still to be put on, or taken off
  std::vector<bool> done(connections);  // put on; of assembly: taken off, or never there
  for (ConnectionIndex other = 0; other < connections; ++other) {
    // What is inaccessible stays in disassembly, and is never there in assembly.
    const bool never = situation_.inaccessible.contains(other);
    left[other] =
        other != c && handled_at_[other] >= time && handled_at_[other] != kBeforeAll && !never;
    done[other] = never && handled_at_[other] != kBeforeAll;
  }
  const std::vector<bool> stays = done;
  const auto is_done = [&](ConnectionIndex other) { return bool{done[other]}; };
  const auto list_waits = [&](const PrecedenceClause& clause) {
    return !list_of(clause).empty() && std::ranges::none_of(list_of(clause), is_done);
  };
  for (bool moving = true; moving;) {
    moving = false;
    std::vector<bool> free = left;
    for (const PrecedenceClause& clause : problem_.precedence()) {
      if (list_waits(clause)) free[clause.connection] = false;
      if (assembly_ && !std::ranges::all_of(clause.after, is_done)) free[clause.connection] = false;
      if (assembly_ || !left[clause.connection]) continue;
      for (const ConnectionIndex later : clause.after) free[later] = false;
    }
    for (ConnectionIndex other = 0; other < connections; ++other) {
      if (!free[other]) continue;
      left[other] = false;
      done[other] = true;
      moving = true;
    }
  }
  std::erase_if(naming, [&](const PrecedenceClause* clause) {
    if (!assembly_ && stays[clause->connection])
      return std::ranges::any_of(list_of(*clause), [&](ConnectionIndex other) {
        return other != clause->connection && (left[other] || done[other]);
      });
    return !left[clause->connection] || !list_waits(*clause);
  });
  return naming;
}

Piece Replayer::lone_piece(PartIndex part) const {
  const Part& data = problem_.parts()[part];
  Piece piece;
  piece.mass = data.mass;
  piece.earliest = part;
  piece.base_parts = problem_.in_base(part) ? 1 : 0;
  piece.numbers = data.numbers;
  for (const auto& [name, number] : data.numbers) piece.number_sizes[name] = std::abs(number);
  if (data.position) {
    piece.positions = *data.position;
  } else {
    piece.without_position = 1;
  }
  return piece;
}

void Replayer::start_pieces() {
  const std::size_t parts = problem_.num_parts();
  piece_of_.resize(parts);
  std::iota(piece_of_.begin(), piece_of_.end(), PartIndex{0});
  next_ = piece_of_;
  pieces_.reserve(parts);
  for (PartIndex part = 0; part < parts; ++part) {
    pieces_.push_back(lone_piece(part));
    if (problem_.parts()[part].mass != problem_.parts().front().mass) equal_masses_ = false;
  }
}

void Replayer::merge(ConnectionIndex c) {
  PartIndex large = piece_of_[problem_.ends(c)[0]];
  PartIndex small = piece_of_[problem_.ends(c)[1]];
  if (large == small) return;
  if (pieces_[large].parts < pieces_[small].parts) std::swap(large, small);
  if (pieces_[large].parts == 1) ++subassemblies_;
  if (pieces_[small].parts > 1) --subassemblies_;
  for (const PartIndex part : members(small)) piece_of_[part] = large;
  std::swap(next_[large], next_[small]);
  pieces_[large].take_in(pieces_[small]);
}

// The parts of a piece; valid until the next call.
std::span<const PartIndex> Replayer::members(PartIndex piece) {
  listed_.clear();
  PartIndex part = piece;
  do {
    listed_.push_back(part);
    part = next_[part];
  } while (part != piece);
  return listed_;
}

// Equal masses are multiplied, so that many of them add up without loss.
double Replayer::mass(const Piece& piece) const {
  return equal_masses_ ? static_cast<double>(piece.parts) * problem_.parts().front().mass
                       : piece.mass;
}

// What holds a base part stays. Else the side with fewer parts moves; else the lighter; else the
// one without the earliest part.
bool Replayer::first_moves(const Piece& a, const Piece& b) const {
  if ((a.base_parts > 0) != (b.base_parts > 0)) return b.base_parts > 0;
  if (a.parts != b.parts) return a.parts < b.parts;
  const double difference = mass(a) - mass(b);
  if (std::abs(difference) > kSameMass * std::max(mass(a), mass(b))) return difference < 0;
  return a.earliest > b.earliest;
}

// What one part blocks for another, the other blocks for the one along the opposite direction, so
// it is enough to look at the blockers of the smaller side.
template <class InOther>
bool Replayer::blocked(std::span<const PartIndex> few, InOther&& in_other) {
  const auto all = problem_.direction_bits();
  free_.assign(all.begin(), all.end());
  for (const PartIndex part : few) {
    for (const Blocker& blocker : problem_.blockers()[part]) {
      if (in_other(blocker.by) && !problem_.take_out(blocker, free_)) return true;
    }
  }
  return false;
}

// Whether two pieces, as they are now, leave no direction in which they come apart.
bool Replayer::each_blocks_the_other(PartIndex a, PartIndex b) {
  if (problem_.directions().empty()) return false;
  const auto [few, many] = pieces_[a].parts <= pieces_[b].parts ? std::pair{a, b} : std::pair{b, a};
  return blocked(members(few), [&](PartIndex part) { return piece_of_[part] == many; });
}

// The directions in which one piece can leave another, in the order of the file.
std::vector<DirectionIndex> Replayer::ways_out(PartIndex moved, PartIndex kept) {
  if (problem_.directions().empty() || each_blocks_the_other(moved, kept)) return {};
  // What is free is so for the piece of fewer parts.
  const bool forth = pieces_[moved].parts <= pieces_[kept].parts;
  std::vector<DirectionIndex> ways;
  for (const DirectionIndex d : problem_.directions()) {
    const DirectionIndex way = forth ? d : opposite(d);
    if ((free_[way / 64U] >> way % 64U & 1U) != 0) ways.push_back(d);
  }
  return ways;
}

// Whether the moved piece can leave in the direction that the plan states: looked up for this
// direction alone, part by part of the piece that moves.
void Replayer::judge_direction(const Made& made, const Step& step, PartIndex a, PartIndex b) {
  if (directions_.empty() || problem_.directions().empty() || !step.separates) return;
  const std::optional<DirectionIndex> direction = directions_[made.time - 1];
  if (!direction) return;
  const auto [moved, kept] = step.a_moves ? std::pair{a, b} : std::pair{b, a};
  for (const PartIndex part : members(moved)) {
    for (const Blocker& blocker : problem_.blockers()[part]) {
      if (piece_of_[blocker.by] != kept || !problem_.blocks(blocker, *direction)) continue;
      replay_.direction_faults.push_back(
          {made.time, made.connection, *direction, part, blocker.by});
      return;
    }
  }
}

// The constraints of a step between two pieces; `subassemblies_` counts the state in which they are
// apart.
void Replayer::judge_cut(const Made& step, PartIndex a, PartIndex b) {
  const Limits& limits = problem_.limits();
  PlanFault details;
  if (limits.max_subassemblies && subassemblies_ > *limits.max_subassemblies) {
    details.amount = subassemblies_;
    fault(step, Constraint::MaxSubassemblies, details);
  }
  if (limits.grounded) judge_ground(step, pieces_[a], pieces_[b]);
  if (pieces_[a].base_parts > 0 && pieces_[b].base_parts > 0) return;  // nothing moves
  const Piece& moved = first_moves(pieces_[a], pieces_[b]) ? pieces_[a] : pieces_[b];
  details.amount = moved.parts;
  details.mass = mass(moved);
  if (limits.max_moved_parts && moved.parts > *limits.max_moved_parts)
    fault(step, Constraint::MaxMovedParts, details);
  if (limits.max_moved_mass &&
      details.mass - *limits.max_moved_mass > kSameMass * *limits.max_moved_mass)
    fault(step, Constraint::MaxMovedMass, details);
  if (each_blocks_the_other(a, b)) fault(step, Constraint::Blocking);
}

// Each subassembly that the step leaves holds a base part: the two pieces that a disassembly comes
// to, or the one that an assembly makes of them.
bool Replayer::stands(const Piece& a, const Piece& b) const {
  if (assembly_) return a.base_parts + b.base_parts > 0;
  return (a.parts == 1 || a.base_parts > 0) && (b.parts == 1 || b.base_parts > 0);
}

void Replayer::judge_ground(const Made& step, const Piece& a, const Piece& b) {
  if (!stands(a, b)) fault(step, Constraint::Grounded);
}

// The parts of both sides, ascending, and their sums in that order, as one would add them up.
void Replayer::list_sides(Step& step, PartIndex a, PartIndex b, Piece& piece_a,
                          Piece& piece_b) const {
  for (PartIndex part = 0; part < problem_.num_parts(); ++part) {
    if (piece_of_[part] == a) step.a.push_back(part);
    if (piece_of_[part] == b) step.b.push_back(part);
  }
  for (const auto& [parts, piece] : {std::pair{&step.a, &piece_a}, std::pair{&step.b, &piece_b}}) {
    *piece = nothing_yet(parts->front());
    for (const PartIndex part : *parts) piece->take_in(lone_piece(part));
  }
}

void Replayer::see_numbers(SeenStep& seen, const Piece& moved, const Piece& kept, bool moves) {
  if (moves) {
    seen.moved_numbers = moved.numbers;
    seen.kept_numbers = kept.numbers;
  } else {
    Piece both = kept;
    both.take_in(moved);
    seen.kept_numbers = both.numbers;
  }
  for (const Piece* piece : {&moved, &kept}) {
    for (const auto& [name, sum] : piece->number_sizes) seen.largest_number_sum += sum;
  }
}

void Replayer::make(const Made& made) {
  const auto [first, second] = problem_.ends(made.connection);
  const PartIndex a = piece_of_[first];
  const PartIndex b = piece_of_[second];
  const std::size_t open = to_handle_ - made.place;
  Step step;
  step.connection = made.connection;
  step.connections = {made.connection};
  step.separates = a != b;
  step.completes = open == 1 || made.time == reached_at_;
  step.before = assembly_ ? problem_.num_connections() - open - kept_ : open + kept_;
  step.after = assembly_ ? step.before + 1 : step.before - 1;
  step.subassemblies = subassemblies_;
  SeenStep seen;
  if (step.separates) {
    judge_cut(made, a, b);
    Piece piece_a = pieces_[a];
    Piece piece_b = pieces_[b];
    if (whole_steps_) list_sides(step, a, b, piece_a, piece_b);
    step.both_stay = piece_a.base_parts > 0 && piece_b.base_parts > 0;
    step.a_moves = step.moves() && first_moves(piece_a, piece_b);
    const Piece& moved = step.a_moves ? piece_a : piece_b;
    const Piece& kept = step.a_moves ? piece_b : piece_a;
    if (moved_only_ && step.moves()) {
      const std::span<const PartIndex> parts = members(step.a_moves ? a : b);
      std::vector<PartIndex>& listed = step.a_moves ? step.a : step.b;
      listed.assign(parts.begin(), parts.end());
      std::ranges::sort(listed);
    }
    step.moved_mass = step.moves() ? mass(moved) : 0.0;
    step.kept_mass = step.moves() ? mass(kept) : mass(piece_a) + mass(piece_b);
    if (assembly_) {
      step.subassemblies += 1;
      if (piece_a.parts > 1) --step.subassemblies;
      if (piece_b.parts > 1) --step.subassemblies;
    }
    seen.a_parts = piece_a.parts;
    seen.b_parts = piece_b.parts;
    see_numbers(seen, moved, kept, step.moves());
    seen.moved_parts = step.moves() ? moved.parts : 0;
    if (step.moves() && moved.without_position == 0) {
      const auto parts = static_cast<double>(moved.parts);
      const Vector3& sum = moved.positions;
      seen.moved_centroid = Vector3{sum[0] / parts, sum[1] / parts, sum[2] / parts};
    }
  }
  seen.duration = problem_.connections()[step.connection].duration;
  seen.own_numbers = problem_.connections()[step.connection].numbers;
  seen.elapsed = elapsed_[made.place];
  seen.connection = step.connection;
  seen.before = step.before;
  seen.after = step.after;
  seen.separates = step.separates;
  seen.completes = step.completes;
  seen.subassemblies = step.subassemblies;
  seen.moved_mass = step.moved_mass;
  seen.kept_mass = step.kept_mass;
  seen.step = &step;
  judge_direction(made, step, a, b);
  if (looks_back_) {
    keep_for_later(made, seen, std::move(step), a, b);
    return;
  }
  const CheckedReward::Value earned = reward_.of(seen);
  if (!earned.finite && (!unfit_ || made.time < unfit_->first.time)) unfit_ = {made, earned};
  magnitude_ += earned.magnitude;
  rounding_ += earned.rounding;
  step.reward = earned.reward;
  rewards_[made.place] = earned.reward;
  if (!with_steps_) return;
  if (step.moves()) step.free_directions = step.a_moves ? ways_out(a, b) : ways_out(b, a);
  replay_.steps.push_back(std::move(step));
}

// What the steps before left behind is known only once all steps are: what they earn is worked out
// then.
void Replayer::keep_for_later(const Made& made, const SeenStep& seen, Step step, PartIndex a,
                              PartIndex b) {
  KeptStep& kept = kept_steps_.at(made.place);
  if (step.moves() && !problem_.directions().empty()) {
    step.free_directions = step.a_moves ? ways_out(a, b) : ways_out(b, a);
    const auto stated = directions_.empty() ? std::nullopt : directions_[made.time - 1];
    kept.ways = stated ? std::vector{*stated} : step.free_directions;
  }
  kept.seen = seen;
  kept.step = std::move(step);
  kept.seen.step = nullptr;
  for (const auto& [name, value] : problem_.connections()[made.connection].attributes)
    kept.seen.attributes[name] = value;
  kept.seen.place = problem_.place(made.connection);
}

// The rewards of all steps, where the objective looks back.
void Replayer::look_back() {
  const auto values = rewards_looking_back(problem_, reward_, situation_, kept_steps_);
  for (std::size_t i = 0; i < kept_steps_.size(); ++i) {
    const CheckedReward::Value& value = values[i];
    if (!value.finite && !unfit_) unfit_ = {made_[i], value};
    magnitude_ += value.magnitude;
    rounding_ += value.rounding;
    rewards_[i] = value.reward;
    kept_steps_[i].step.reward = value.reward;
    if (with_steps_) replay_.steps.push_back(std::move(kept_steps_[i].step));
  }
}

void Replayer::add_up_durations() {
  double seconds = 0;
  for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
    if (!situation_.open.contains(c)) seconds += problem_.connections()[c].duration;
  }
  for (const Made& step : made_) {
    elapsed_.push_back(seconds);
    seconds += problem_.connections()[step.connection].duration;
  }
}

bool Replayer::cut_allowed(const Piece& a, const Piece& b, std::size_t apart) const {
  const Limits& limits = problem_.limits();
  if (limits.grounded && !stands(a, b)) return false;
  if (a.base_parts > 0 && b.base_parts > 0)
    return !limits.max_subassemblies || apart <= *limits.max_subassemblies;
  const Piece& moved = first_moves(a, b) ? a : b;
  return (!limits.max_subassemblies || apart <= *limits.max_subassemblies) &&
         (!limits.max_moved_parts || moved.parts <= *limits.max_moved_parts) &&
         (!limits.max_moved_mass ||
          mass(moved) - *limits.max_moved_mass <= kSameMass * *limits.max_moved_mass);
}

// Whether the problem's own constraints let `c`, which is open, be handled now, at `time`. The
// pieces are those of the state at hand.
bool Replayer::can_be_handled(ConnectionIndex c, std::size_t time) {
  if (!precedence_faults(c, time).empty()) return false;
  // In assembly it may be too late, by the fault of an earlier step.
  for (const PrecedenceClause& clause : problem_.precedence()) {
    if (clause.connection == c && (held_back(clause, time) || all_there(clause, time)))
      return false;
  }
  if (!assembly_) return cut_allowed_apart(c, time);
  const PartIndex a = piece_of_[problem_.ends(c)[0]];
  const PartIndex b = piece_of_[problem_.ends(c)[1]];
  if (a == b) return true;
  const bool moves = pieces_[a].base_parts == 0 || pieces_[b].base_parts == 0;
  return cut_allowed(pieces_[a], pieces_[b], subassemblies_) &&
         !(moves && each_blocks_the_other(a, b));
}

// In disassembly `c` is part of a piece; what hangs together without it is found by walking there.
bool Replayer::cut_allowed_apart(ConnectionIndex c, std::size_t time) {
  const auto [first, second] = problem_.ends(c);
  std::vector<PartIndex> side{first};
  reached_[first] = 1;
  for (std::size_t i = 0; i < side.size() && reached_[second] == 0; ++i) {
    for (const ConnectionIndex link : around_[side[i]]) {
      if (link == c || !there(link, time)) continue;
      for (const PartIndex end : problem_.ends(link)) {
        if (reached_[end] == 0) {
          reached_[end] = 1;
          side.push_back(end);
        }
      }
    }
  }
  bool allowed = reached_[second] != 0;
  if (!allowed) {
    Piece a = nothing_yet(first);
    for (const PartIndex part : side) a.take_in(lone_piece(part));
    Piece b = nothing_yet(second);
    const PartIndex whole = piece_of_[first];
    for (const PartIndex part : members(whole)) {
      if (reached_[part] == 0) b.take_in(lone_piece(part));
    }
    const std::size_t apart =
        subassemblies_ - 1 + (a.parts > 1 ? 1U : 0U) + (b.parts > 1 ? 1U : 0U);
    const bool moves = a.base_parts == 0 || b.base_parts == 0;
    allowed =
        cut_allowed(a, b, apart) && !(moves && blocked(side, [&](PartIndex part) {
                                        return piece_of_[part] == whole && reached_[part] == 0;
                                      }));
  }
  for (const PartIndex part : side) reached_[part] = 0;
  return allowed;
}

// What Situation says about the order. The pieces are those of the state in which the step begins.
void Replayer::judge_order(const Made& step) {
  if (step.place == 0 && situation_.not_next.contains(step.connection))
    fault(step, Constraint::NotNext);
  if (!replay_.late_judged || !situation_.late.contains(step.connection) ||
      last_ordinary_ < step.time)
    return;
  for (const ConnectionIndex other : ordinary_) {
    if (handled_at_[other] < step.time) continue;
    if (step.place == 0 && situation_.not_next.contains(other)) continue;
    if (!can_be_handled(other, step.time)) continue;
    PlanFault details;
    details.other = other;
    fault(step, Constraint::Late, details);
    return;
  }
}

// The pieces as they are now each hold a base part, or are single parts.
void Replayer::judge_ground_now() {
  if (!problem_.limits().grounded || to_handle_ == 0) return;
  for (PartIndex part = 0; part < problem_.num_parts(); ++part) {
    const Piece& piece = pieces_[piece_of_[part]];
    if (piece.parts == 1 || piece.base_parts > 0) continue;
    PlanFault details;
    details.constraint = Constraint::Grounded;
    details.part = part;
    replay_.faults.push_back(details);
    return;
  }
}

// Too many subassemblies in the product before it is taken apart, or when it is finished.
void Replayer::judge_start() {
  const auto limit = problem_.limits().max_subassemblies;
  if ((!limit && !problem_.limits().grounded) || to_handle_ == 0) return;
  for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
    if (to_be_handled(c)) merge(c);
  }
  if (!assembly_) judge_ground_now();
  if (!limit || subassemblies_ <= *limit) return;
  PlanFault details;
  details.constraint = Constraint::MaxSubassemblies;
  details.amount = subassemblies_;
  replay_.faults.push_back(details);
}

// Whether a step that breaks no rule may leave no way to the end.
bool Replayer::may_shut_out() const {
  const Limits& limits = problem_.limits();
  const auto any = [this](auto&& list) {
    return std::ranges::any_of(problem_.precedence(), [&](const PrecedenceClause& clause) {
      return !list(clause).empty();
    });
  };
  return limits.any() ||
         std::ranges::any_of(problem_.blockers(), [](const auto& list) { return !list.empty(); }) ||
         (any([](const auto& clause) -> const auto& { return clause.after_any; }) &&
          any([](const auto& clause) -> const auto& { return clause.made_after_any; }));
}

PlanReplay Replayer::run() {
  replay_.late_judged = !may_shut_out();
  find_times();
  judge_precedence();
  start_pieces();
  if (!situation_.late.empty()) {
    for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
      if (!to_be_handled(c) || situation_.late.contains(c)) continue;
      ordinary_.push_back(c);
      last_ordinary_ = std::max(last_ordinary_, handled_at_[c]);
    }
    around_.resize(problem_.num_parts());
    for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
      for (const PartIndex end : problem_.ends(c)) around_[end].push_back(c);
    }
    reached_.assign(problem_.num_parts(), 0);
  }
  rewards_.resize(made_.size());
  if (looks_back_) kept_steps_.resize(made_.size());
  // What is there in every state of the plan.
  for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
    if (handled_at_[c] == (assembly_ ? kBeforeAll : kNever)) merge(c);
  }
  add_up_durations();
  if (assembly_) {
    judge_ground_now();
    for (const Made& step : made_) {
      judge_order(step);
      make(step);
      merge(step.connection);
    }
  } else {
    for (auto step = made_.rbegin(); step != made_.rend(); ++step) {
      make(*step);
      merge(step->connection);
      judge_order(*step);
    }
    std::ranges::reverse(replay_.steps);  // empty as yet where the objective looks back
  }
  judge_start();
  if (looks_back_) look_back();
  if (unfit_) {
    const auto& [step, value] = *unfit_;
    const std::size_t open = to_handle_ - step.place + kept_;
    const std::size_t before = assembly_ ? problem_.num_connections() - open : open;
    throw InputError(
        "objective: the reward of " + std::string(assembly_ ? "making " : "removing ") +
        in_quotes(problem_.connection_id(step.connection)) + " with " + std::to_string(before) +
        " connections present is " + unfit_reward_text(value.unfit));
  }
  replay_.reward = std::accumulate(rewards_.begin(), rewards_.end(), 0.0);
  replay_.rewards = std::move(rewards_);
  std::ranges::stable_sort(replay_.faults, {}, &PlanFault::step);
  std::ranges::stable_sort(replay_.direction_faults, {}, &PlanDirectionFault::step);
  replay_.tolerance = 1e-9 * std::max(1.0, magnitude_) + rounding_;
  return std::move(replay_);
}

}  // namespace

PlanReplay replay(const Problem& problem, const Situation& situation,
                  std::span<const ConnectionIndex> sequence, bool with_steps,
                  std::span<const std::optional<DirectionIndex>> directions) {
  situation.require_over(problem.num_connections());
  if (!directions.empty() && directions.size() != sequence.size())
    throw InputError("the plan has " + std::to_string(sequence.size()) + " steps and states " +
                     std::to_string(directions.size()) + " directions");
  if (problem.spec().action == StepKind::Connection)
    return Replayer(problem, situation, sequence, with_steps, directions).run();
  std::vector<PlanStep> steps;
  for (std::size_t i = 0; i < sequence.size(); ++i)
    steps.push_back({{sequence[i]}, directions.empty() ? std::nullopt : directions[i]});
  return replay_parts(problem, situation, steps, with_steps);
}

PlanReplay replay_moves(const Problem& problem, const Situation& situation,
                        std::span<const ConnectionIndex> sequence) {
  if (problem.spec().action != StepKind::Connection)
    return replay(problem, situation, sequence, true);
  situation.require_over(problem.num_connections());
  Replayer replayer(problem, situation, sequence, true, {});
  replayer.list_moved_only();
  return replayer.run();
}

PlanReplay replay(const Problem& problem, const Situation& situation,
                  std::span<const PlanStep> steps, bool with_steps) {
  situation.require_over(problem.num_connections());
  if (problem.spec().action == StepKind::Part)
    return replay_parts(problem, situation, steps, with_steps);
  std::vector<ConnectionIndex> sequence;
  std::vector<std::optional<DirectionIndex>> directions;
  for (const PlanStep& step : steps) {
    if (step.connections.size() != 1)
      throw InputError("a step of the plan takes " + std::to_string(step.connections.size()) +
                       " connections; one is allowed");
    sequence.push_back(step.connections.front());
    directions.push_back(step.direction);
  }
  return Replayer(problem, situation, sequence, with_steps, directions).run();
}

}  // namespace orasp::detail
