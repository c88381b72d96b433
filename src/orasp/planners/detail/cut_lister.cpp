#include "orasp/planners/detail/cut_lister.h"

#include "orasp/model/detail/connectivity.h"

namespace orasp::detail {

template <std::size_t kWords>
PartLinks<kWords>::PartLinks(const PieceProblem& pieces, std::uint64_t forest_seed)
    : along_forest(forest_seed != 0 || pieces.graph.is_forest()) {
  const Problem& problem = pieces.system.problem();
  const std::size_t parts = problem.num_parts();
  neighbours.resize(parts);
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const auto [u, v] = problem.ends(c);
    if (u == v) continue;
    neighbours[u].insert(v);
    neighbours[v].insert(u);
  }
  if (along_forest) {
    SpanningForest forest = random_spanning_forest(pieces.graph, forest_seed);
    parent = std::move(forest.parent);
    below.resize(parts);
    for (std::size_t p = 0; p < parts; ++p) below[p].insert(p);
    for (std::size_t i = parts; i-- > 0;) {
      const PartIndex part = forest.order[i];
      if (parent[part] != SpanningForest::kNoPart)
        below[parent[part]] = below[parent[part]] | below[part];
    }
  }
  if (!along_forest) sides.emplace(problem, neighbours);
  close_precedence(problem);
}

/// Fills `precedence`: what must be gone before each connection, directly or through others.
template <std::size_t kWords>
void PartLinks<kWords>::close_precedence(const Problem& problem) {
  if (problem.precedence().empty()) return;
  const std::size_t connections = problem.num_connections();
  std::vector<std::vector<ConnectionIndex>> direct(connections);
  for (const PrecedenceClause& clause : problem.precedence()) {
    direct[clause.connection].insert(direct[clause.connection].end(), clause.after.begin(),
                                     clause.after.end());
  }
  precedence.resize(connections);
  std::vector<unsigned char> seen(connections);
  for (ConnectionIndex c = 0; c < connections; ++c) {
    std::ranges::fill(seen, 0);
    std::vector<ConnectionIndex>& all = precedence[c];
    all = direct[c];
    for (const ConnectionIndex other : all) seen[other] = 1;
    for (std::size_t i = 0; i < all.size(); ++i) {
      for (const ConnectionIndex other : direct[all[i]]) {
        if (seen[other] == 0) all.push_back(other);
        seen[other] = 1;
      }
    }
  }
}

template <std::size_t kWords>
CutLister<kWords>::CutLister(const PieceProblem& pieces, std::uint64_t forest_seed)
    : pieces_(pieces),
      problem_(pieces.system.problem()),
      links_(pieces, forest_seed),
      expander_(pieces.system),
      trees_(pieces.gains.trees()),
      bounded_(pieces.gains.sizes_known() || pieces.gains.parts_known()),
      by_sizes_(pieces.system.gain_by_sizes() && pieces.gains.sizes_known() &&
                !problem_.limits().max_moved_mass && !problem_.limits().grounded &&
                problem_.directions().empty()),
      by_connection_(pieces.system.gain_by_connection()),
      by_moved_(pieces.system.gain_by_moved() && problem_.base().empty() &&
                problem_.precedence().empty()) {}

template <std::size_t kWords>
double CutLister<kWords>::upper_without_tree(const Set& set, std::size_t parts) {
  if (!bounded_) return 0;
  const PieceGains& gains = pieces_.gains;
  double bound = gains.sizes_known() ? gains.by_size(parts) : kInfinity;
  if (gains.parts_known()) {
    list_parts(set, upper_list_);
    bound = std::min(bound, gains.by_parts(upper_list_));
  }
  return bound;
}

template <std::size_t kWords>
double CutLister<kWords>::tree(const Set& set) {
  if (!sees_trees()) return 0;
  list_parts(set, upper_list_);
  return trees_.of_parts(upper_list_);
}

/// What is known of a side of a cut, upper() among it: many cuts have the same.
template <std::size_t kWords>
auto CutLister<kWords>::known(const Set& set, std::size_t parts) -> KnownBound& {
  if (known_.empty()) known_.resize(kKnownBounds);
  KnownBound& known = known_[hash_value(set.words) % kKnownBounds];
  if (known.set != set) known = {.set = set, .bound = upper(set, parts)};
  return known;
}

/// What `connection` gains as the last between `side` and the rest. The parts of the two must stand
/// in side_list_ and rest_list_.
template <std::size_t kWords>
std::optional<double> CutLister<kWords>::listed_gain(const Set& side, ConnectionIndex connection,
                                                     bool free) {
  return side.contains(problem_.ends(connection)[0])
             ? expander_.cut_gain(side_list_, rest_list_, connection, free)
             : expander_.cut_gain(rest_list_, side_list_, connection, free);
}

template <std::size_t kWords>
std::optional<double> CutLister<kWords>::gain(const Set& piece, const Set& side, const Set& rest,
                                              std::size_t side_parts, std::size_t rest_parts,
                                              bool free) {
  if (!links_.precedence.empty() && !may_precede(side, rest)) return std::nullopt;
  if (by_sizes_)
    return pieces_.gains.gain(std::min(side_parts, rest_parts), std::max(side_parts, rest_parts));
  list_parts(side, side_list_);
  list_parts(rest, rest_list_);
  std::optional<double> best;
  const bool by_side = side_parts <= rest_parts;
  for (const PartIndex part : by_side ? side_list_ : rest_list_) {
    if ((links_.neighbours[part] & (by_side ? rest : side)).empty()) continue;
    for (const auto& half : pieces_.graph.around(part)) {
      if (!piece.contains(half.other) || side.contains(half.other) == side.contains(part)) continue;
      const auto gain = listed_gain(side, half.connection, free);
      if (!gain) return std::nullopt;
      if (!best || *gain > *best) best = *gain;
      if (!by_connection_) return best;
    }
  }
  return best;
}

/// Whether precedence allows the cut. Before the last connection between the two sides goes, all
/// that must precede it is gone, and each side must still hang together without that.
template <std::size_t kWords>
bool CutLister<kWords>::may_precede(const Set& side, const Set& rest) {
  gone_.assign(problem_.num_connections(), 0);
  bool any = false;
  side.for_each([&](std::size_t part) {
    for (const auto& half : pieces_.graph.around(static_cast<PartIndex>(part))) {
      if (!rest.contains(half.other)) continue;
      for (const ConnectionIndex c : links_.precedence[half.connection]) {
        gone_[c] = 1;
        any = true;
      }
    }
  });
  if (!any) return true;
  const auto hangs_together = [&](const Set& set) {
    Set reached;
    reached.insert(set.first());
    std::vector<PartIndex>& queue = queue_;
    queue.assign(1, static_cast<PartIndex>(set.first()));
    for (std::size_t i = 0; i < queue.size(); ++i) {
      for (const auto& half : pieces_.graph.around(queue[i])) {
        if (gone_[half.connection] != 0 || !set.contains(half.other) ||
            reached.contains(half.other))
          continue;
        reached.insert(half.other);
        queue.push_back(half.other);
      }
    }
    return queue.size() == set.size();
  };
  return hangs_together(side) && hangs_together(rest);
}

/// gain(), by what is remembered of sets that move.
template <std::size_t kWords>
std::optional<double> CutLister<kWords>::remembered_gain(const Set& piece, const Set& side,
                                                         const Set& rest, std::size_t side_parts,
                                                         std::size_t rest_parts, bool free) {
  const bool one_moves =
      by_moved_ && side_parts != rest_parts && (free || problem_.directions().empty());
  if (!one_moves) return gain(piece, side, rest, side_parts, rest_parts, free);
  const bool side_moves = side_parts < rest_parts;
  KnownBound& moved = side_moves ? known(side, side_parts) : known(rest, rest_parts);
  if (!moved.gain) moved.gain = gain(piece, side, rest, side_parts, rest_parts, free);
  return moved.gain;
}

template <std::size_t kWords>
std::optional<double> CutLister<kWords>::gain_of_any(const Set& piece, const Set& side,
                                                     const Set& rest) {
  const std::size_t side_parts = side.size();
  const std::size_t rest_parts = rest.size();
  const bool seen = links_.sides && links_.sides->sees_blocking(piece);
  const bool side_is_smaller = side_parts < rest_parts;
  if (seen &&
      !links_.sides->parts_along_some(side_is_smaller ? side : rest, side_is_smaller ? rest : side))
    return std::nullopt;
  return remembered_gain(piece, side, rest, side_parts, rest_parts, seen);
}

/// Adds the cut into `side` and `rest` if it is legal and loses at most `limit` itself.
template <std::size_t kWords>
void CutLister<kWords>::add(const Set& piece, double here, const Set& side, const Set& rest,
                            double limit, bool free, List& into) {
  const std::size_t side_parts = side.size();
  const std::size_t rest_parts = rest.size();
  if (std::min(side_parts, rest_parts) > pieces_.gains.most_moved()) return;
  const std::optional<double> gained =
      remembered_gain(piece, side, rest, side_parts, rest_parts, free);
  if (!gained) return;
  const double side_bound = known(side, side_parts).bound;
  const double rest_bound = known(rest, rest_parts).bound;
  const double own = here - *gained - side_bound - rest_bound;
  if (own > limit) {
    into.skipped = std::min(into.skipped, own);
    return;
  }
  into.cuts.push_back({side, rest, side_bound, rest_bound, own});
}

template struct PartLinks<1>;
template struct PartLinks<2>;
template struct PartLinks<4>;
template struct PartLinks<8>;
template struct PartLinks<16>;
template class CutLister<1>;
template class CutLister<2>;
template class CutLister<4>;
template class CutLister<8>;
template class CutLister<16>;

}  // namespace orasp::detail
