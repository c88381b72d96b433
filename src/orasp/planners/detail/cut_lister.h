#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "orasp/bounds/cut_trees.h"
#include "orasp/bounds/piece_gains.h"
#include "orasp/model/transition_system.h"
#include "orasp/planners/detail/part_set.h"
#include "orasp/planners/detail/piece_problem.h"
#include "orasp/planners/detail/side_lister.h"
#include "orasp/planners/detail/spanning_forest.h"

namespace orasp::detail {

/// How the parts of a problem hang together, as sets. Immutable.
template <std::size_t kWords>
struct PartLinks {
  using Set = PartSet<kWords>;

  /// With forest_seed 0 all ways to cut, with another one those along a random spanning forest.
  PartLinks(const PieceProblem& pieces, std::uint64_t forest_seed);
  // `sides` looks at `neighbours`.
  PartLinks(const PartLinks&) = delete;
  PartLinks& operator=(const PartLinks&) = delete;
  ~PartLinks() = default;

  bool along_forest;
  /// The parts that each part is connected to.
  std::vector<Set> neighbours;
  /// Along a forest: the part above each part, and the set of parts at and below it.
  std::vector<std::uint32_t> parent;
  std::vector<Set> below;
  /// All connections that must be gone before each connection; empty where no precedence is stated.
  std::vector<std::vector<ConnectionIndex>> precedence;
  /// The ways to part a piece; nothing where only the cuts along a forest are looked at.
  std::optional<SideLister<kWords>> sides;

  /// Along a forest: calls visit(side) for each part of `piece` that hangs on another one of it,
  /// with what is at and below that part.
  template <class Visit>
  void for_each_branch(const Set& piece, Visit&& visit) const {
    piece.for_each([&](std::size_t part) {
      if (parent[part] != SpanningForest::kNoPart && piece.contains(parent[part]))
        visit(below[part] & piece);
    });
  }

 private:
  void close_precedence(const Problem& problem);
};

/// The cuts of pieces: which of them are legal, what each gains, and the bounds of pieces. All of
/// it depends on the piece alone. Holds scratch memory: for one thread.
///
/// Cost.       list(): a cut takes what SideLister does for it and O(parts of the piece), some
///             tenths of a microsecond for twenty parts. Bounds of sides are remembered, the last
///             ones asked for.
template <std::size_t kWords>
class CutLister {
 public:
  using Set = PartSet<kWords>;
  using Links = PartLinks<kWords>;

  CutLister(const PieceProblem& pieces, std::uint64_t forest_seed);

  [[nodiscard]] const Links& links() const { return links_; }
  [[nodiscard]] Expander& expander() { return expander_; }
  /// Whether some bound on what a piece gains is known.
  [[nodiscard]] bool bounded() const { return bounded_; }
  /// Whether what a cut gains depends on which of the connections between its sides goes last.
  [[nodiscard]] bool by_connection() const { return by_connection_; }

  /// Whether what moving a set gains is worked out once for all cuts that move it, so that most
  /// cuts take a tenth of a microsecond to look at.
  [[nodiscard]] bool remembers_moves() const { return by_moved_; }

  /// The bound g of a piece; 0 where none is known.
  [[nodiscard]] double upper(const Set& set, std::size_t parts) {
    return upper_without_tree(set, parts) - tree(set);
  }
  /// The same but for what it counts for connections.
  [[nodiscard]] double upper_without_tree(const Set& set, std::size_t parts);
  /// What the bound of a piece counts for the connections at which it is cut.
  [[nodiscard]] double tree(const Set& set);
  /// Whether it counts anything.
  [[nodiscard]] bool sees_trees() const { return bounded_ && trees_.any(); }
  [[nodiscard]] CutTrees& trees() { return trees_; }

  /// What the cut of a piece into `side` and `rest` gains at best; empty where it cannot be legal.
  /// `free`: whether one side is known to leave the other along some direction.
  std::optional<double> gain(const Set& piece, const Set& side, const Set& rest,
                             std::size_t side_parts, std::size_t rest_parts, bool free = false);
  /// The same of any two sides that hang together.
  std::optional<double> gain_of_any(const Set& piece, const Set& side, const Set& rest);
  /// What each of `connections` gains as the last between `side` and `rest`.
  template <class Visit>
  void gains_as_last(const Set& side, const Set& rest, std::span<const ConnectionIndex> connections,
                     Visit&& visit) {
    list_parts(side, side_list_);
    list_parts(rest, rest_list_);
    for (const ConnectionIndex c : connections) visit(c, listed_gain(side, c, false));
  }

  /// A cut of a piece, and by how much it alone stays below the bound of the piece:
  /// g(piece) - gain - g(side) - g(rest).
  struct Found {
    Set side;
    Set rest;
    double side_bound;
    double rest_bound;
    double own_loss;
  };
  /// The legal cuts of a piece whose own loss is within some limit.
  struct List {
    std::vector<Found> cuts;
    double skipped = kInfinity;  ///< the least own loss of the others
    std::uint64_t looks = 0;     ///< ways to part the piece that were looked at
    bool complete = false;       ///< else there are more, or the listing was stopped
  };
  /// More ways to part one piece than this are not looked at.
  static constexpr std::uint64_t kMostLooks = 20'000;
  /// Lists the legal cuts of `piece`, whose bound is `here`, that lose at most `limit` themselves;
  /// stop() is asked now and then whether to give up.
  template <class Stop>
  void list(const Set& piece, double here, double limit, List& into, Stop&& stop);

 private:
  /// The bound of a set of parts; and what moving it gains, where that is known.
  struct KnownBound {
    Set set;
    double bound = 0;
    std::optional<double> gain{};
  };
  static constexpr std::size_t kKnownBounds = std::max<std::size_t>(1024, 16'384 / kWords);

  bool may_precede(const Set& side, const Set& rest);
  [[nodiscard]] std::optional<double> listed_gain(const Set& side, ConnectionIndex connection,
                                                  bool free);
  void add(const Set& piece, double here, const Set& side, const Set& rest, double limit, bool free,
           List& into);
  KnownBound& known(const Set& set, std::size_t parts);
  std::optional<double> remembered_gain(const Set& piece, const Set& side, const Set& rest,
                                        std::size_t side_parts, std::size_t rest_parts, bool free);

  const PieceProblem& pieces_;
  const Problem& problem_;
  const Links links_;
  Expander expander_;
  CutTrees trees_;
  bool bounded_;
  /// Whether what a cut gains depends on the sizes of its sides alone.
  bool by_sizes_;
  bool by_connection_;
  /// Whether a cut is legal where its smaller side can leave, and gains what moving that gains.
  bool by_moved_;
  /// Bounds of pieces that were listed as sides, by the hash of the set; each place holds one.
  std::vector<KnownBound> known_;
  // Scratch memory.
  std::vector<unsigned char> gone_;
  std::vector<PartIndex> queue_;
  std::vector<PartIndex> upper_list_;
  std::vector<PartIndex> side_list_;
  std::vector<PartIndex> rest_list_;
};

template <std::size_t kWords>
template <class Stop>
void CutLister<kWords>::list(const Set& piece, double here, double limit, List& into, Stop&& stop) {
  constexpr std::uint64_t kLooksUntilAsked = 256;
  into.cuts.clear();
  into.skipped = kInfinity;
  into.looks = 0;
  bool stopped = false;
  if (links_.along_forest) {
    links_.for_each_branch(
        piece, [&](const Set& side) { add(piece, here, side, piece - side, limit, false, into); });
  } else {
    const bool free = links_.sides->sees_blocking(piece);
    links_.sides->list(
        piece,
        [&](const Set& side, const Set& rest) { add(piece, here, side, rest, limit, free, into); },
        [&] {
          ++into.looks;
          stopped =
              stopped || into.looks > kMostLooks || (into.looks % kLooksUntilAsked == 0 && stop());
          return stopped;
        });
  }
  into.complete = !stopped;
}

}  // namespace orasp::detail
