#include "orasp/model/detail/part_replay.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "orasp/model/detail/look_back.h"
#include "orasp/model/detail/reward_size.h"
#include "orasp/model/detail/wording.h"

namespace orasp::detail {

namespace {

/// Two masses that differ by less, relatively, are the same to a user.
constexpr double kSameMass = 1e-9;

using State = std::vector<bool>;  // by connection: whether it is there
using Piece = std::vector<PartIndex>;

class PartReplayer {
 public:
  PartReplayer(const Problem& problem, const Situation& situation, std::size_t steps_of_plan,
               bool with_steps)
      : problem_(problem),
        situation_(situation),
        assembly_(problem.direction() == Direction::Assembly),
        reward_(problem),
        with_steps_(with_steps),
        num_steps_(steps_of_plan) {
    connections_of_.resize(problem.num_parts());
    for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
      for (const PartIndex end : problem.ends(c)) connections_of_[end].push_back(c);
    }
  }

  PlanReplay run(std::span<const PlanStep> steps);

 private:
  void fault(std::size_t step, Constraint constraint, ConnectionIndex c, PlanFault details = {}) {
    details.step = step;
    details.constraint = constraint;
    details.connection = c;
    replay_.faults.push_back(details);
  }
  [[nodiscard]] bool accessible(ConnectionIndex c) const {
    return situation_.open.contains(c) && !situation_.inaccessible.contains(c);
  }
  [[nodiscard]] Piece grown(PartIndex start, const State& there, std::vector<bool>& seen) const;
  [[nodiscard]] Piece piece_of(PartIndex start, const State& there) const;
  [[nodiscard]] std::vector<Piece> pieces(const State& there) const;
  [[nodiscard]] double mass(const Piece& piece) const;
  [[nodiscard]] bool has_base(const Piece& piece) const {
    return std::ranges::any_of(piece, [this](PartIndex part) { return problem_.in_base(part); });
  }
  [[nodiscard]] bool first_moves(const Piece& a, const Piece& b) const;
  [[nodiscard]] bool goal_holds(const State& there) const {
    return std::ranges::none_of(problem_.goal(), [&](ConnectionIndex c) { return there[c]; });
  }
  void judge_state(std::size_t step, ConnectionIndex c, const State& there);
  void judge_start(const State& there);
  [[nodiscard]] bool replay_step(std::size_t number, const PlanStep& step, State& there);
  void see(std::size_t number, const PlanStep& step, const State& joined, const State& apart,
           const Piece& moved, const std::vector<Piece>& rest);

  const Problem& problem_;
  const Situation& situation_;
  bool assembly_;
  std::vector<std::vector<ConnectionIndex>> connections_of_;  ///< by part
  CheckedReward reward_;
  bool with_steps_;
  std::size_t num_steps_;
  double elapsed_ = 0;
  std::size_t open_ = 0;
  std::vector<KeptStep> kept_;
  PlanReplay replay_;
};

/// The parts that `start` is joined to, directly or not, in rising order; marks them in `seen`, in
/// which none of them may be marked before.
Piece PartReplayer::grown(PartIndex start, const State& there, std::vector<bool>& seen) const {
  Piece piece{start};
  seen[start] = true;
  for (std::size_t i = 0; i < piece.size(); ++i) {
    for (const ConnectionIndex c : connections_of_[piece[i]]) {
      if (!there[c]) continue;
      for (const PartIndex end : problem_.ends(c)) {
        if (seen[end]) continue;
        seen[end] = true;
        piece.push_back(end);
      }
    }
  }
  std::ranges::sort(piece);
  return piece;
}

Piece PartReplayer::piece_of(PartIndex start, const State& there) const {
  std::vector<bool> seen(problem_.num_parts(), false);
  return grown(start, there, seen);
}

std::vector<Piece> PartReplayer::pieces(const State& there) const {
  std::vector<Piece> all;
  std::vector<bool> seen(problem_.num_parts(), false);
  for (PartIndex part = 0; part < problem_.num_parts(); ++part) {
    if (!seen[part]) all.push_back(grown(part, there, seen));
  }
  return all;
}

double PartReplayer::mass(const Piece& piece) const {
  double sum = 0;
  for (const PartIndex part : piece) sum += problem_.parts()[part].mass;
  return sum;
}

// The side with fewer parts moves; else the lighter; else the one without the earliest part.
bool PartReplayer::first_moves(const Piece& a, const Piece& b) const {
  if (a.size() != b.size()) return a.size() < b.size();
  const double difference = mass(a) - mass(b);
  if (std::abs(difference) > kSameMass * std::max(mass(a), mass(b))) return difference < 0;
  return a.front() > b.front();
}

// Precedence, of a state that a step comes to (of an assembly: from which its reverse comes): what
// is gone had nothing left to wait for, and what is there has what it needs.
void PartReplayer::judge_state(std::size_t step, ConnectionIndex c, const State& there) {
  const auto is_there = [&](ConnectionIndex other) { return bool{there[other]}; };
  for (const PrecedenceClause& clause : problem_.precedence()) {
    const ConnectionIndex one = clause.connection;
    PlanFault details;
    details.entry = clause.entry;
    details.other = one;
    if (there[one]) {
      const auto holds = [&](ConnectionIndex other) { return other != one && is_there(other); };
      if (!clause.made_after_any.empty() && std::ranges::none_of(clause.made_after_any, holds))
        fault(step, Constraint::PrecedenceMadeAny, c, details);
      continue;
    }
    // What stays away from an assembly waits for nothing.
    if (assembly_ && situation_.inaccessible.contains(one)) continue;
    const auto stands = [&](ConnectionIndex other) { return other == one || is_there(other); };
    const auto in_the_way = std::ranges::find_if(clause.after, stands);
    if (in_the_way != clause.after.end()) {
      details.other = *in_the_way;
      fault(step, Constraint::Precedence, c, details);
    }
    if (!clause.after_any.empty() && std::ranges::all_of(clause.after_any, stands))
      fault(step, Constraint::PrecedenceAny, c, details);
  }
}

// The product before it is taken apart, or when it is finished; and where the work begins.
void PartReplayer::judge_start(const State& there) {
  const Limits& limits = problem_.limits();
  State whole = there;
  for (ConnectionIndex c = 0; c < whole.size(); ++c) {
    if (assembly_ && accessible(c)) whole[c] = true;
  }
  std::size_t subassemblies = 0;
  for (const Piece& piece : pieces(whole)) subassemblies += piece.size() > 1 ? 1U : 0U;
  PlanFault details;
  details.amount = subassemblies;
  if (limits.max_subassemblies && subassemblies > *limits.max_subassemblies)
    fault(0, Constraint::MaxSubassemblies, 0, details);
  if (!limits.grounded) return;
  for (const Piece& piece : pieces(there)) {
    if (piece.size() == 1 || has_base(piece)) continue;
    details.part = piece.front();
    fault(0, Constraint::Grounded, 0, details);
    return;
  }
}

// Judges one step and makes it; false where no step could take what it takes.
bool PartReplayer::replay_step(std::size_t number, const PlanStep& step, State& there) {
  const std::size_t connections = problem_.num_connections();
  const ConnectionIndex first = step.connections.empty() ? ConnectionIndex{0} : step.connections[0];
  std::set<ConnectionIndex> taken;
  for (const ConnectionIndex c : step.connections) {
    if (c >= connections || there[c] == assembly_ || !taken.insert(c).second ||
        !situation_.open.contains(c)) {
      fault(number, Constraint::NotOpen, c);
      return false;
    }
    if (situation_.inaccessible.contains(c)) {
      fault(number, Constraint::Inaccessible, c);
      return false;
    }
  }
  if (taken.empty()) {
    fault(number, Constraint::NotOneStep, first);
    return false;
  }
  State joined = there;
  State apart = there;
  for (const ConnectionIndex c : taken) {
    joined[c] = true;
    apart[c] = false;
  }
  // The pieces that the one falls into, and which of them takes all of the step's connections.
  const Piece whole = piece_of(problem_.ends(first)[0], joined);
  std::vector<Piece> parted;
  for (const Piece& piece : pieces(apart)) {
    if (std::ranges::binary_search(whole, piece.front())) parted.push_back(piece);
  }
  const auto cuts_off = [&](const Piece& piece) {
    return std::ranges::all_of(taken, [&](ConnectionIndex c) {
      const auto [a, b] = problem_.ends(c);
      return std::ranges::binary_search(whole, a) && std::ranges::binary_search(whole, b) &&
             std::ranges::binary_search(piece, a) != std::ranges::binary_search(piece, b);
    });
  };
  std::optional<std::size_t> moved;
  for (std::size_t i = 0; i < parted.size(); ++i) {
    if (!cuts_off(parted[i]) || has_base(parted[i])) continue;
    const bool by_size = parted.size() == 2 && !has_base(parted[1 - i]);
    if (by_size && !first_moves(parted[i], parted[1 - i])) continue;
    moved = i;
  }
  if (parted.size() < 2 || !moved) {
    fault(number, Constraint::NotOneStep, first);
    return false;
  }
  // In an assembly all that is missing between the two is put on.
  const Piece piece = parted[*moved];
  for (ConnectionIndex c = 0; c < connections && assembly_; ++c) {
    const auto [a, b] = problem_.ends(c);
    const bool between =
        std::ranges::binary_search(whole, a) && std::ranges::binary_search(whole, b) &&
        std::ranges::binary_search(piece, a) != std::ranges::binary_search(piece, b);
    if (between && !taken.contains(c) && !joined[c] && accessible(c)) {
      fault(number, Constraint::NotOneStep, first);
      return false;
    }
  }
  std::vector<Piece> rest;
  for (std::size_t i = 0; i < parted.size(); ++i) {
    if (i != *moved) rest.push_back(parted[i]);
  }
  see(number, step, joined, apart, piece, rest);
  judge_state(number, first, assembly_ ? joined : apart);
  there = assembly_ ? joined : apart;
  for (const ConnectionIndex c : taken) elapsed_ += problem_.connections()[c].duration;
  open_ -= taken.size();
  return true;
}

void PartReplayer::see(std::size_t number, const PlanStep& plan_step, const State& joined,
                       const State& apart, const Piece& moved, const std::vector<Piece>& rest) {
  const Limits& limits = problem_.limits();
  const ConnectionIndex first = *std::ranges::min_element(plan_step.connections);
  std::size_t subassemblies_apart = 0;
  for (const Piece& piece : pieces(apart)) subassemblies_apart += piece.size() > 1 ? 1U : 0U;
  std::size_t subassemblies_joined = 0;
  for (const Piece& piece : pieces(joined)) subassemblies_joined += piece.size() > 1 ? 1U : 0U;
  PlanFault details;
  details.amount = subassemblies_apart;
  if (limits.max_subassemblies && subassemblies_apart > *limits.max_subassemblies)
    fault(number, Constraint::MaxSubassemblies, first, details);
  details.amount = moved.size();
  details.mass = mass(moved);
  if (limits.max_moved_parts && moved.size() > *limits.max_moved_parts)
    fault(number, Constraint::MaxMovedParts, first, details);
  if (limits.max_moved_mass &&
      details.mass - *limits.max_moved_mass > kSameMass * *limits.max_moved_mass)
    fault(number, Constraint::MaxMovedMass, first, details);
  if (limits.grounded) {
    const bool stands = moved.size() == 1 && std::ranges::all_of(rest, [this](const Piece& piece) {
                          return has_base(piece);
                        });
    if (!stands) fault(number, Constraint::Grounded, first);
  }
  Piece kept;
  for (const Piece& piece : rest) kept.insert(kept.end(), piece.begin(), piece.end());
  std::ranges::sort(kept);
  std::vector<DirectionIndex> ways;
  for (const DirectionIndex direction : problem_.directions()) {
    std::optional<PlanDirectionFault> in_the_way;
    for (const PartIndex part : moved) {
      for (const Blocker& blocker : problem_.blockers()[part]) {
        if (std::ranges::binary_search(kept, blocker.by) && problem_.blocks(blocker, direction))
          in_the_way = {number, first, direction, part, blocker.by};
      }
    }
    if (!in_the_way) {
      ways.push_back(direction);
    } else if (plan_step.direction == direction) {
      replay_.direction_faults.push_back(*in_the_way);
    }
  }
  if (!problem_.directions().empty() && ways.empty()) fault(number, Constraint::Blocking, first);

  KeptStep& one = kept_.emplace_back();
  if (plan_step.direction) {
    one.ways = {*plan_step.direction};
  } else {
    one.ways = ways;
  }
  Step& step = one.step;
  step.connection = first;
  step.connections = plan_step.connections;
  std::ranges::sort(step.connections);
  const auto there = [](const State& state) {
    return static_cast<std::size_t>(std::count(state.begin(), state.end(), true));
  };
  step.before = assembly_ ? there(apart) : there(joined);
  step.after = assembly_ ? there(joined) : there(apart);
  step.separates = step.a_moves = true;
  const bool reached = problem_.spec().goal && problem_.spec().goal->stop == Goal::Stop::Reached &&
                       goal_holds(apart);
  step.completes = open_ == step.connections.size() || reached;
  step.a = moved;
  step.b = kept;
  step.free_directions = ways;
  step.moved_mass = mass(moved);
  step.kept_mass = mass(kept);
  step.subassemblies = assembly_ ? subassemblies_joined : subassemblies_apart;
  SeenStep& seen = one.seen;
  seen.connection = first;
  seen.before = step.before;
  seen.after = step.after;
  seen.separates = true;
  seen.completes = step.completes;
  seen.subassemblies = step.subassemblies;
  seen.a_parts = seen.moved_parts = moved.size();
  seen.b_parts = kept.size();
  for (const Piece& piece : rest) seen.rest_parts.push_back(piece.size());
  seen.moved_mass = step.moved_mass;
  seen.kept_mass = step.kept_mass;
  seen.elapsed = elapsed_;
  Vector3 sum{};
  bool known = true;
  for (const PartIndex part : moved) {
    const auto& position = problem_.parts()[part].position;
    known = known && position;
    for (std::size_t axis = 0; axis < 3 && position; ++axis) sum[axis] += (*position)[axis];
    for (const auto& [name, value] : problem_.parts()[part].numbers) {
      seen.moved_numbers[name] += value;
      seen.largest_number_sum += std::abs(value);
    }
  }
  for (double& x : sum) x /= static_cast<double>(moved.size());
  if (known) seen.moved_centroid = sum;
  for (const PartIndex part : kept) {
    for (const auto& [name, value] : problem_.parts()[part].numbers) {
      seen.kept_numbers[name] += value;
      seen.largest_number_sum += std::abs(value);
    }
  }
  Vector3 place{};
  bool placed = true;
  std::set<std::string> differing;
  for (const ConnectionIndex c : step.connections) {
    const Connection& connection = problem_.connections()[c];
    seen.duration += connection.duration;
    for (const auto& [name, value] : connection.numbers) {
      seen.own_numbers[name] += value;
      seen.largest_number_sum += std::abs(value);
    }
    for (const auto& [name, value] : connection.attributes) {
      const auto [entry, is_new] = seen.attributes.emplace(name, value);
      if (!is_new && entry->second != value) differing.insert(name);
    }
    const std::optional<Vector3> at = problem_.place(c);
    placed = placed && at;
    for (std::size_t axis = 0; axis < 3 && at; ++axis) place[axis] += (*at)[axis];
  }
  for (const std::string& name : differing) seen.attributes.erase(name);
  for (double& x : place) x /= static_cast<double>(step.connections.size());
  if (placed) seen.place = place;
}

PlanReplay PartReplayer::run(std::span<const PlanStep> steps) {
  const std::size_t connections = problem_.num_connections();
  State there(connections);
  for (ConnectionIndex c = 0; c < connections; ++c) {
    const bool open = situation_.open.contains(c);
    there[c] = open != assembly_;
    if (!open) elapsed_ += problem_.connections()[c].duration;
    if (accessible(c)) ++open_;
  }
  replay_.late_judged = false;
  const std::size_t to_handle = open_;
  if (to_handle > 0) judge_start(there);
  bool possible = true;
  const bool ends_when_reached =
      problem_.spec().goal && problem_.spec().goal->stop == Goal::Stop::Reached;
  for (std::size_t i = 0; i < steps.size() && possible; ++i) {
    const ConnectionIndex first =
        steps[i].connections.empty() ? ConnectionIndex{0} : steps[i].connections[0];
    if (ends_when_reached && goal_holds(there)) fault(i + 1, Constraint::Goal, first);
    if (i == 0 && std::ranges::any_of(steps[i].connections, [this](ConnectionIndex c) {
          return c < problem_.num_connections() && situation_.not_next.contains(c);
        }))
      fault(i + 1, Constraint::NotNext, first);
    possible = replay_step(i + 1, steps[i], there);
  }
  if (possible) {
    const auto missing = [&](ConnectionIndex c) { return there[c] != assembly_ && accessible(c); };
    for (ConnectionIndex c = 0; c < connections && !problem_.spec().goal; ++c) {
      if (missing(c)) fault(num_steps_ + 1, Constraint::NotOpen, c);
    }
    for (const ConnectionIndex c : problem_.goal()) {
      if (there[c]) fault(num_steps_ + 1, Constraint::NotOpen, c);
    }
  }
  if (kept_.empty()) {
    std::ranges::stable_sort(replay_.faults, {}, &PlanFault::step);
    replay_.tolerance = 1e-9;
    return std::move(replay_);
  }
  if (!reward_.looks_back()) {
    for (KeptStep& one : kept_) one.ways.clear();  // then it does not matter
  }
  double magnitude = 0;
  double rounding = 0;
  const auto values = rewards_looking_back(problem_, reward_, situation_, kept_);
  for (std::size_t i = 0; i < kept_.size(); ++i) {
    if (!values[i].finite)
      throw InputError("objective: the reward of " +
                       std::string(assembly_ ? "making " : "removing ") +
                       in_quotes(problem_.connection_id(kept_[i].step.connection)) + " with " +
                       std::to_string(kept_[i].step.before) + " connections present is " +
                       unfit_reward_text(values[i].unfit));
    replay_.reward += values[i].reward;
    magnitude += values[i].magnitude;
    rounding += values[i].rounding;
    kept_[i].step.reward = values[i].reward;
    if (with_steps_) replay_.steps.push_back(std::move(kept_[i].step));
  }
  std::ranges::stable_sort(replay_.faults, {}, &PlanFault::step);
  replay_.tolerance = 1e-9 * std::max(1.0, magnitude) + rounding;
  return std::move(replay_);
}

}  // namespace

PlanReplay replay_parts(const Problem& problem, const Situation& situation,
                        std::span<const PlanStep> steps, bool with_steps) {
  return PartReplayer(problem, situation, steps.size(), with_steps).run(steps);
}

}  // namespace orasp::detail
