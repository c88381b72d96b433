#include "orasp/certificate/detail/piece_bound.h"

#include <algorithm>

#include "orasp/certificate/detail/outward.h"
#include "orasp/certificate/detail/removals.h"
#include "orasp/model/tolerance.h"

namespace orasp::detail {

namespace {

/// The most by which the last removal earns more than its connection and its cut are counted for.
/// One connection is left, so if it separates, then two single parts: what they are worth together
/// stays with them.
double surplus_of_last(const Problem& problem, const SizeRewards& rewards,
                       const PieceValues& values) {
  double best = -kInfinity;
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    PieceCuts::Side pair{problem.ends(c)[0], problem.ends(c)[1]};
    const bool separates = pair[0] != pair[1];
    double more = add_up(rewards.last(c, separates, 1, 1), -rewards.own(c));
    if (separates) {
      std::ranges::sort(pair);
      const double worth = values.of(pair, 1);
      if (worth == -kInfinity) continue;
      more = add_up(more, -worth);
    }
    best = std::max(best, more);
  }
  return best;
}

}  // namespace

std::vector<PieceGroup> piece_groups(const Problem& problem, const SizeRewards& rewards,
                                     const PieceValues& values, const PieceCuts& cuts) {
  const std::size_t connections = problem.num_connections();
  if (connections == 0) return {{{}, 0}};
  Removals removals(problem);
  if (!removals.start_allowed()) return {};
  double owns = 0;
  for (ConnectionIndex c = 0; c < connections; ++c) owns = add_up(owns, rewards.own(c));
  ConnectionSet all = ConnectionSet::all(connections);
  std::vector<PieceGroup> groups;
  const auto add = [&](PieceGroup group, double beside) {
    group.bound = beside == -kInfinity ? beside : add_up(owns, beside);
    for (const auto& [parts, allowed] : group.pieces) {
      const double worth = values.of(parts, allowed);
      group.bound = worth == -kInfinity ? worth : add_up(group.bound, worth);
      if (worth == -kInfinity) break;
    }
    groups.push_back(std::move(group));
  };
  const auto pieces = [&] {
    PieceGroup group;
    for (PieceCuts::Side& piece : cuts.pieces_of(all))
      group.pieces.emplace_back(std::move(piece), values.allowed());
    return group;
  };
  if (problem.direction() == Direction::Disassembly) {
    add(pieces(), surplus_of_last(problem, rewards, values));
    return groups;
  }
  // Looked at backwards the first removal is the step that completes.
  removals.look_at(all);
  for (ConnectionIndex c = 0; c < connections; ++c) {
    if (!removals.allowed(c)) continue;
    all.erase(c);
    const double more =
        add_up(rewards.last(c, removals.separates(), removals.a_parts(), removals.b_parts()),
               -rewards.own(c));
    PieceGroup group = pieces();
    if (values.limited() && removals.a_parts() > 1 && removals.b_parts() > 1) {
      const auto holds = [&](PartIndex part) {
        return std::ranges::find_if(group.pieces, [&](const auto& piece) {
          return std::ranges::binary_search(piece.first, part);
        });
      };
      const auto a = holds(problem.ends(c)[0]);
      const auto b = holds(problem.ends(c)[1]);
      for (const auto& half :
           values.halves(removals.a_parts(), removals.b_parts(), values.allowed())) {
        a->second = half.a;
        b->second = half.b;
        add(group, more);
      }
    } else {
      add(std::move(group), more);
    }
    all.insert(c);
  }
  return groups;
}

}  // namespace orasp::detail
