#include "orasp/certificate/detail/removals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "orasp/certificate/detail/attempts.h"
#include "orasp/certificate/detail/outward.h"

namespace orasp::detail {

namespace {

/// Two masses that differ by less, relatively, count as equal (docs/format.md, Tolerance).
constexpr double kSameMass = 1e-9;
/// No connection.
constexpr auto kNone = std::numeric_limits<ConnectionIndex>::max();

void add_numbers(std::map<std::string, double>& sums, const Part& part) {
  for (const auto& [name, number] : part.numbers) sums[name] += number;
}

}  // namespace

Removals::Removals(const Problem& problem)
    : problem_(problem),
      assembly_(problem.direction() == Direction::Assembly),
      rewards_(problem),
      around_(problem.num_parts()),
      clauses_(problem.num_connections()),
      reached_(problem.num_parts(), false) {
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    for (const PartIndex part : problem.ends(c)) around_[part].push_back(c);
  }
  for (const PrecedenceClause& clause : problem.precedence())
    clauses_[clause.connection].push_back(&clause);
  for (const Part& part : problem.parts()) {
    if (part.mass != problem.parts().front().mass) equal_masses_ = false;
    if (!part.numbers.empty()) has_numbers_ = true;
  }
}

bool Removals::start_allowed() const {
  if (problem_.num_connections() == 0) return true;
  Removals whole(problem_);
  whole.look_at(ConnectionSet::all(problem_.num_connections()));
  const Limits& limits = problem_.limits();
  if (limits.max_subassemblies && whole.subassemblies_ > *limits.max_subassemblies) return false;
  if (!limits.grounded) return true;
  for (PartIndex part = 0; part < problem_.num_parts(); ++part) {
    whole.walk(part, kNone);
    const Piece piece = whole.piece_of(whole.walked_);
    if (piece.parts.size() > 1 && piece.base_parts == 0) return false;
  }
  return true;
}

void Removals::look_at(const ConnectionSet& present) {
  present_ = present;
  missing_seconds_ = 0;
  for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
    if (!present_.contains(c)) missing_seconds_ += problem_.connections()[c].duration;
  }
  subassemblies_ = 0;
  std::vector<bool> seen(problem_.num_parts(), false);
  for (PartIndex part = 0; part < problem_.num_parts(); ++part) {
    if (seen[part]) continue;
    walk(part, kNone);
    for (const PartIndex member : walked_) seen[member] = true;
    if (walked_.size() > 1) ++subassemblies_;
  }
}

// The parts that hang together with `from` by what is present, `without` one connection; they are
// in walked_.
void Removals::walk(PartIndex from, ConnectionIndex without) {
  walked_.assign(1, from);
  reached_[from] = true;
  for (std::size_t i = 0; i < walked_.size(); ++i) {
    for (const ConnectionIndex c : around_[walked_[i]]) {
      if (c == without || !present_.contains(c)) continue;
      for (const PartIndex end : problem_.ends(c)) {
        if (reached_[end]) continue;
        reached_[end] = true;
        walked_.push_back(end);
      }
    }
  }
  for (const PartIndex part : walked_) reached_[part] = false;
}

Removals::Piece Removals::piece_of(const std::vector<PartIndex>& parts) const {
  Piece piece;
  piece.parts = parts;
  std::ranges::sort(piece.parts);
  for (const PartIndex part : piece.parts) {
    piece.mass += problem_.parts()[part].mass;
    if (problem_.in_base(part)) ++piece.base_parts;
  }
  if (equal_masses_ && !parts.empty())
    piece.mass = static_cast<double>(parts.size()) * problem_.parts().front().mass;
  return piece;
}

// A and B, and which of them moves.
void Removals::part_at(ConnectionIndex connection) {
  connection_ = connection;
  const auto [first, second] = problem_.ends(connection);
  walk(first, connection);
  separates_ = std::ranges::find(walked_, second) == walked_.end();
  moves_ = a_moves_ = false;
  if (!separates_) return;
  a_ = piece_of(walked_);
  walk(second, connection);
  b_ = piece_of(walked_);
  moves_ = a_.base_parts == 0 || b_.base_parts == 0;
  a_moves_ = moves_ && first_moves();
}

bool Removals::first_moves() const {
  if ((a_.base_parts > 0) != (b_.base_parts > 0)) return b_.base_parts > 0;
  if (a_.parts.size() != b_.parts.size()) return a_.parts.size() < b_.parts.size();
  const double difference = a_.mass - b_.mass;
  if (std::abs(difference) > kSameMass * std::max(a_.mass, b_.mass)) return difference < 0;
  return a_.parts.front() > b_.parts.front();
}

bool Removals::cut_allowed(const std::vector<PartIndex>& a, const std::vector<PartIndex>& b) {
  separates_ = true;
  a_ = piece_of(a);
  b_ = piece_of(b);
  moves_ = a_.base_parts == 0 || b_.base_parts == 0;
  a_moves_ = moves_ && first_moves();
  return limits_allow_pieces() && some_way_out();
}

bool Removals::allowed(ConnectionIndex connection) {
  if (!precedence_allows(connection)) return false;
  part_at(connection);
  return limits_allow() && some_way_out();
}

// What must be gone before the connection is, and what must be there while it is.
bool Removals::precedence_allows(ConnectionIndex connection) const {
  const auto there = [&](ConnectionIndex other) { return present_.contains(other); };
  const auto there_beside = [&](ConnectionIndex other) {
    return other != connection && present_.contains(other);
  };
  return std::ranges::all_of(clauses_[connection], [&](const PrecedenceClause* clause) {
    return std::ranges::none_of(clause->after, there) &&
           (clause->after_any.empty() || !std::ranges::all_of(clause->after_any, there)) &&
           (clause->made_after_any.empty() ||
            std::ranges::any_of(clause->made_after_any, there_beside));
  });
}

bool Removals::limits_allow() const {
  if (!separates_) return true;
  const Limits& limits = problem_.limits();
  const std::size_t a = a_.parts.size();
  const std::size_t b = b_.parts.size();
  const std::size_t left = subassemblies_ - 1 + (a > 1 ? 1U : 0U) + (b > 1 ? 1U : 0U);
  if (limits.max_subassemblies && left > *limits.max_subassemblies) return false;
  return limits_allow_pieces();
}

bool Removals::limits_allow_pieces() const {
  const Limits& limits = problem_.limits();
  const std::size_t a = a_.parts.size();
  const std::size_t b = b_.parts.size();
  if (limits.grounded && ((a > 1 && a_.base_parts == 0) || (b > 1 && b_.base_parts == 0)))
    return false;
  if (!moves_) return true;
  const Piece& moved = a_moves_ ? a_ : b_;
  if (limits.max_moved_parts && moved.parts.size() > *limits.max_moved_parts) return false;
  return !limits.max_moved_mass ||
         moved.mass - *limits.max_moved_mass <= kSameMass * *limits.max_moved_mass;
}

// Whether there is a direction in which no part of the moved piece is blocked by one of the other.
bool Removals::some_way_out() const {
  const auto& directions = problem_.directions();
  if (!separates_ || !moves_ || directions.empty()) return true;
  const Piece& moved = a_moves_ ? a_ : b_;
  const Piece& kept = a_moves_ ? b_ : a_;
  return std::ranges::any_of(directions, [&](DirectionIndex direction) {
    return std::ranges::none_of(moved.parts, [&](PartIndex part) {
      return std::ranges::any_of(problem_.blockers()[part], [&](const Blocker& blocker) {
        return problem_.blocks(blocker, direction.value()) &&
               std::ranges::binary_search(kept.parts, blocker.by);
      });
    });
  });
}

Removals::Reward Removals::reward() const {
  const std::size_t all = problem_.num_connections();
  const std::size_t present = present_.size();
  const Connection& connection = problem_.connections()[connection_];
  SeenStep step;
  step.connection = connection_;
  step.before = assembly_ ? present - 1 : present;
  step.after = assembly_ ? present : present - 1;
  step.separates = separates_;
  step.completes = assembly_ ? present == all : present == 1;
  step.duration = connection.duration;
  step.elapsed = missing_seconds_;
  if (assembly_) {
    step.elapsed = 0;
    for_each_connection(present_.view(), [&](ConnectionIndex c) {
      if (c != connection_) step.elapsed += problem_.connections()[c].duration;
    });
  }
  step.own_numbers = connection.numbers;
  step.subassemblies = subassemblies_;
  if (separates_) {
    step.a_parts = a_.parts.size();
    step.b_parts = b_.parts.size();
    if (!assembly_)
      step.subassemblies =
          subassemblies_ - 1 + (step.a_parts > 1 ? 1U : 0U) + (step.b_parts > 1 ? 1U : 0U);
    const Piece& moved = a_moves_ ? a_ : b_;
    const Piece& kept = a_moves_ ? b_ : a_;
    step.kept_mass = moves_ ? kept.mass : a_.mass + b_.mass;
    if (moves_) {
      step.moved_parts = moved.parts.size();
      step.moved_mass = moved.mass;
      Vector3 sum{};
      bool placed = true;
      for (const PartIndex part : moved.parts) {
        const auto& position = problem_.parts()[part].position;
        placed = placed && position.has_value();
        for (std::size_t axis = 0; placed && axis < 3; ++axis) sum[axis] += (*position)[axis];
      }
      const auto count = static_cast<double>(moved.parts.size());
      if (placed) step.moved_centroid = Vector3{sum[0] / count, sum[1] / count, sum[2] / count};
    }
    if (has_numbers_) {
      for (const PartIndex part : moved.parts)
        add_numbers(moves_ ? step.moved_numbers : step.kept_numbers, problem_.parts()[part]);
      for (const PartIndex part : kept.parts)
        add_numbers(step.kept_numbers, problem_.parts()[part]);
      for (const Piece* piece : {&a_, &b_}) {
        for (const PartIndex part : piece->parts) {
          for (const auto& [name, number] : problem_.parts()[part].numbers)
            step.largest_number_sum += std::abs(number);
        }
      }
    }
  }
  const CheckedReward::Value value = rewards_.of(step);
  // Sums over parts and over terms lose less than a unit in the last place for each addend.
  const double lost = static_cast<double>(problem_.num_parts() + 64) *
                      std::numeric_limits<double>::epsilon() * value.magnitude;
  const double most = add_up(value.reward, add_up(value.rounding, lost));
  return {all_together(most, attempts_at(problem_, connection_)), value.finite};
}

}  // namespace orasp::detail
