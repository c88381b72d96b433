#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "orasp/bounds/piece_gains.h"
#include "orasp/bounds/piece_tree.h"
#include "orasp/bounds/raised_prices.h"
#include "orasp/containers/growing_array.h"
#include "orasp/containers/state_table.h"
#include "orasp/model/random.h"
#include "orasp/model/tolerance.h"
#include "orasp/model/transition_system.h"
#include "orasp/planners/detail/cut_lister.h"
#include "orasp/planners/detail/part_set.h"
#include "orasp/planners/detail/piece_problem.h"
#include "orasp/planners/detail/spanning_forest.h"
#include "orasp/symmetry/orbit_form.h"
#include "orasp/task/budget.h"
#include "orasp/task/result.h"

namespace orasp::detail {

/// The search of and_or() (planners/and_or.h): the least loss of a piece over all trees of cuts.
/// kWords words hold a set of all parts.
///
/// The loss of a piece is what its best tree of cuts stays below the bound of PieceGains. A search
/// runs several times, each time further; what it has proved stays in its memory for the next run.
///
/// With symmetry only pieces are searched that stand for themselves: each side of a cut is taken to
/// the form of its orbit, and what stands in the memory is the loss of that one. So own_loss is
/// counted against the bounds of the forms, which need not be those of the sides themselves. Plans
/// are made of the sides themselves.
///
/// The members stand in several files: and_or_search.cpp has the search, and_or_cuts.cpp the
/// listing of the cuts of a piece, and_or_peel.cpp the search for a good plan where the whole
/// search takes too long, and_or_recut.cpp how a plan is made better, and_or_first.cpp what changes
/// where the first step completes, and_or_last.cpp where it matters which step is the last,
/// and_or_hubs.cpp what is known of a piece before its cuts are looked at, by hubs and by prices
/// of its own, and_or_cores.cpp the same by its last cuts, and_or_stored.cpp the search where the
/// cuts of a piece are listed once and kept, and_or_sequence.cpp the steps of a plan.
template <std::size_t kWords>
class AndOrSearch {
 public:
  using Set = PartSet<kWords>;

  /// With forest_seed 0 the search looks at all cuts. With another seed it looks only at those
  /// along a random spanning forest: they are few, so the best of them are found even where all
  /// cuts are too many. (In a problem that is a forest these are all cuts.)
  AndOrSearch(const PieceProblem& pieces, std::uint64_t forest_seed, const Budget& budget,
              Result& result);

  /// Searches until it is done, or has expanded `most_expansions` pieces, or looked at `most_looks`
  /// sides of cuts. The bound of the result is proved at any time.
  /// @returns whether the search is done.
  bool run(std::uint64_t most_expansions, std::uint64_t most_looks);

  /// From here on pieces that an exchange of equal parts takes into one another are one. What is
  /// known by then stays true; cuts are no longer kept. Not for a search along a forest that leaves
  /// connections out.
  void use_symmetry(const OrbitForm& form) {
    form_ = form;
    stores_ = false;
  }

  /// Looks for a good plan that takes small sides off each piece, one after the other. Of the
  /// pieces of each size that are then left, the `width` that have lost least are followed. What is
  /// cut off is solved exactly. The next sequence() follows the plan that is found. Only after
  /// run().
  void peel(std::size_t width);

  /// Makes a plan better by windows of its tree of cuts. A window is a piece with some of the
  /// pieces that the plan makes of it later; these stay what they are, and the best way to cut the
  /// one into the others is found over all groups of them. Windows are drawn at random, most of
  /// them around cuts that lose something, until some `most_looks` cuts were looked at. Of ways
  /// that are as good any is taken, so that the next windows see other trees. Where no window
  /// brings anything any more, some are cut in any way at all, and what follows is kept if it is no
  /// worse (iterated local search). Reference: Kossmann and Stocker (2000), Iterative dynamic
  /// programming, ACM Trans. Database Systems 25(1), 43-82, for orders of joins; Lourenco, Martin
  /// and Stuetzle (2003), Iterated local search, in Handbook of Metaheuristics. A window of n
  /// pieces takes 3^n / 2 looks at most. Another `draw` draws other windows. Not under
  /// max_subassemblies, where what a piece may lose depends on what waits beside it.
  /// @returns whether less is lost; the next sequence() then follows what was found, which need not
  /// be legal where the order of the cuts matters.
  bool recut(std::span<const ConnectionIndex> plan, std::uint64_t most_looks, std::uint64_t draw);

  /// A plan that earns so much is known: what loses more need not be looked at.
  void know_plan(double reward) { known_reward_ = std::max(known_reward_, reward); }

  /// Whether the cuts of pieces are kept, so that sequence() may be asked for a dive at any time.
  [[nodiscard]] bool keeps_cuts() const { return stores_; }
  /// Whether recut() looks at a cut in about a tenth of a microsecond.
  [[nodiscard]] bool recuts_quickly() const { return lister_.remembers_moves(); }
  /// Whether the next run() goes on by sweep(), with all threads.
  [[nodiscard]] bool sweeps() const {
    return sweeps_ && stores_ && result_.statistics.expanded >= shared_.sweep_from;
  }
  /// Whether those of the whole pieces are few enough. Only after run().
  [[nodiscard]] bool keeps_all_cuts() const;

  /// Whether what the last cuts of pieces lose is known beforehand. Only after run().
  [[nodiscard]] bool knows_cores() const { return most_core_parts_ > 0; }

  /// Carries the trees of cuts out as legal steps; empty where that is not possible. With `dive`, a
  /// piece that is not solved is cut where the cut promises most. Only after run().
  std::vector<ConnectionIndex> sequence(bool dive);

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  static constexpr std::size_t kMostAllowed = 63;
  /// Stands beside the subassemblies allowed to a piece, as a bit above them: the last step of all
  /// is one of its cuts.
  static constexpr std::size_t kCompletes = kMostAllowed + 1;
  /// peel() takes sides of at most this many parts off a piece.
  static constexpr std::size_t kMostPeeled = 3;

  /// A cut of a piece into `side` and the rest.
  struct Cut {
    Set side;
    /// By how much the cut alone stays below the bound of the piece: g(S) - gain - g(A) - g(B).
    double own_loss;
    /// A lower bound on the loss of the piece with this cut: own_loss and what is known of the
    /// losses of both sides.
    double estimate;
    /// The place among cuts of the same estimate.
    std::uint64_t order;
    /// Whether the rest is finished first, while the side waits; else the other way round. The one
    /// that waits has the last step, where the piece has it.
    bool side_waits;
  };
  /// A cut as it is kept: the numbers of its sides in memo_.
  struct StoredCut {
    std::uint32_t side;
    std::uint32_t rest;
    double own_loss;
  };
  /// The kept cuts of a piece: those whose own loss is at most `limit`. Of the others the least is
  /// `skipped`.
  struct StoredCuts {
    std::uint64_t begin;
    std::uint32_t size;
    bool kept;
    bool too_many;
    bool looked_at;
    double limit;
    double skipped;
  };
  /// How much more the parts of a piece of memo_ cost than the prices that fit all pieces say.
  struct RaiseOnPath {
    std::uint32_t number = kNone;
    RaisedPrices::Raise raise;
  };
  /// How far solve() has come with a piece: the limit on its loss, by how much that grew last, and
  /// after how many expansions a try at it ends, the salt_-th.
  struct Deepening {
    Set piece;
    double limit = 0;
    double step = 0;
    std::uint64_t patience = 0;
    std::uint64_t salt = 0;
    std::uint64_t expanded = 0;  ///< when the limit grew last
  };
  /// What peel() has left of a piece, and how it came to it.
  struct Remainder {
    Set piece;
    double loss;
    /// The number of the remainder that it was cut from; kNone for the piece itself.
    std::uint32_t before;
    /// What was cut off that one.
    Set side;
  };
  /// The steps of a plan so far, and the connections that are still there.
  struct Steps {
    ConnectionSet open;
    std::vector<ConnectionIndex> taken;
  };
  /// One side of a cut, with how many subassemblies it may be at a time, and whether it has the
  /// last step (kCompletes).
  struct Half {
    Set set;
    std::size_t parts;
    std::size_t allowed;
  };

  // and_or_first.cpp
  /// A first step: the piece of pieces_ that it cuts, or none, and the least that a plan with it is
  /// known to lose beside the losses of the pieces.
  struct First {
    ConnectionIndex connection;
    std::size_t piece;
    std::optional<Cut> cut;
    double loss;
  };
  double loss_of_completing(const std::vector<double>& losses, double useful_loss);
  double search_first(const Set& piece, std::size_t parts, std::size_t allowed, double limit);
  double list_first_cuts(const Set& piece, std::size_t parts, std::size_t allowed, double limit);
  [[nodiscard]] std::optional<First> choose_first(bool dive);
  [[nodiscard]] ConnectionIndex choose_without_cut(bool dive);

  // and_or_cores.cpp
  /// A core, with by how much its gain stays below the bound by sizes, and by how much even where
  /// every connection of its least spanning tree is one that a larger piece has no use for.
  struct Core {
    Set set;
    double cost;
    double least;
  };
  static constexpr std::size_t kLeastCoreParts = 3;
  /// Sets of so many parts, or more, are no cores where there are more of them than this, for each
  /// part of the problem and at all.
  static constexpr std::size_t kMostCoresPerPart = 64;
  static constexpr std::size_t kMostCores = 12'000;
  void find_cores();
  [[nodiscard]] std::vector<std::vector<Set>> list_small_sets() const;
  [[nodiscard]] double loss_of_cut_to_core(std::size_t parts, std::size_t most_parts) const;
  void add_core(const Set& set, std::size_t parts, double loss_before, bool completes);
  /// What a cut loses by sizes, `moved` <= `kept`.
  [[nodiscard]] double loss_by_sizes(std::size_t moved, std::size_t kept) const {
    return gains_.by_size(moved + kept) - gains_.gain(moved, kept) - gains_.by_size(moved) -
           gains_.by_size(kept);
  }
  void measure_loss_off_core();
  double loss_by_cores(const Set& piece, std::size_t parts, double bound, bool completes);

  // and_or_last.cpp
  double gain_of_last(const Set& side, const Set& rest);
  std::optional<std::size_t> piece_that_completes();

  // and_or_search.cpp
  void find_pieces();
  template <class Report>
  double solve(const Set& piece, std::size_t allowed, double useful_loss, Report&& report);
  double search(const Set& piece, std::size_t parts, std::size_t allowed, double limit);
  std::pair<double, double> least_listed_loss(const Set& piece, std::size_t parts,
                                              std::size_t allowed, double limit);
  double settled_loss(std::uint32_t number, double limit, double best, double next);
  void sort_cuts(std::size_t begin);
  std::pair<double, double> least_loss(const Set& piece, std::size_t parts, std::size_t allowed,
                                       double limit, std::size_t begin, double skipped);
  std::pair<double, bool> loss_with(const Cut& cut, const std::array<Half, 2>& halves,
                                    double limit);
  void poll();

  // and_or_hubs.cpp
  /// Of all parts of a piece: the most components that the piece falls into without one, and the
  /// fewest parts that the largest of them has.
  struct Hubs {
    std::size_t arms;
    std::size_t reach;
  };
  /// A part on the path of hubs(); of the components that hang on it alone their number, the
  /// largest, and all their parts; and the parts at and below it.
  struct HubFrame {
    PartIndex part;
    PartIndex from;
    std::uint32_t next;
    std::size_t arms;
    std::size_t largest;
    std::size_t cut_off;
    std::size_t below;
  };
  static constexpr std::size_t kMostPartsWithReach = 512;
  double most_with(std::size_t parts, const Hubs& found);
  double first_loss(std::uint32_t number, std::size_t parts, double bound, double enough);
  double loss_by_shape(const Set& piece, std::size_t parts, double bound, bool completes) {
    return std::max(loss_by_hubs(piece, parts, bound),
                    loss_by_cores(piece, parts, bound, completes));
  }
  /// Whether prices of its own say more of a piece of so many parts.
  [[nodiscard]] bool has_own_prices(std::size_t parts) const {
    return raised_ != nullptr && gains_.prices().small_pieces().priced(parts);
  }
  [[nodiscard]] double above_prices(std::span<const PartIndex> piece, double bound,
                                    double tree) const;
  void raise_on_path(std::size_t depth, std::uint32_t number, double enough);
  double loss_by_hubs(const Set& piece, std::size_t parts, double bound);
  double by_reach(std::size_t parts, std::size_t reach);
  Hubs hubs(const Set& piece, std::size_t parts);
  Hubs hubs_of_tree(const Set& piece, std::size_t parts);

  // and_or_sweep.cpp
  struct Swept;
  struct Batch;
  /// What one thread of sweep() works with.
  struct Sweeper {
    explicit Sweeper(const PieceProblem& pieces) : lister(pieces, 0) {}
    CutLister<kWords> lister;
    typename CutLister<kWords>::List listed;
    RaisedPrices::Raise raise;
    std::vector<PartIndex> parts;
  };
  /// A sweep that a run had to leave: its root, kNone where there is none, its limit, and the parts
  /// of the layer that it had come to.
  struct Unfinished {
    std::uint32_t root = kNone;
    double limit = 0;
    std::size_t layer = 0;
  };
  double sweep(std::uint32_t root, double limit);
  std::vector<Swept> reached_pieces(std::size_t parts, bool priced);
  void sweep_layer(std::size_t parts);
  template <class Stop>
  void look_at_batch(std::span<Swept> pieces, bool priced, Sweeper& sweeper, Batch& into,
                     Stop&& stop) const;
  void take_batch(std::size_t parts, std::span<const Swept> pieces, const Batch& batch);
  void settle_swept(std::uint32_t number);

  // and_or_stored.cpp
  std::uint32_t node_of(const Set& set, std::size_t parts);
  std::uint32_t node_of(const Set& set, std::uint64_t hash, double bound);
  /// Writes the hashes of the sides of cuts after `into`, as keep_cuts() takes them.
  void add_hashes(std::span<const typename CutLister<kWords>::Found> cuts,
                  std::vector<std::uint64_t>& into) const {
    for (const auto& cut : cuts) {
      into.push_back(memo_.hash(key(cut.side, 0).data()));
      into.push_back(memo_.hash(key(cut.rest, 0).data()));
    }
  }
  /// What is known of the loss of a piece with a cut that is kept.
  [[nodiscard]] double estimate(const StoredCut& cut) const {
    return cut.own_loss + loss_[cut.side] + loss_[cut.rest];
  }
  [[nodiscard]] bool solved(const StoredCut& cut) const {
    return exact_[cut.side] != 0 && exact_[cut.rest] != 0;
  }
  /// Calls visit(place) for the place in stored_ of each kept cut of a piece.
  template <class Visit>
  void for_each_kept(const StoredCuts& list, Visit&& visit) const {
    // What the sides of a cut lose is far from one another in memory.
    constexpr std::uint64_t kAhead = 8;
    const std::uint64_t end = list.begin + list.size;
    for (std::uint64_t i = list.begin; i < end; ++i) {
      if (i + kAhead < end) {
        __builtin_prefetch(&loss_[stored_[i + kAhead].side]);
        __builtin_prefetch(&loss_[stored_[i + kAhead].rest]);
      }
      visit(i);
    }
  }
  void count_listed(std::uint64_t looks);
  bool keep_cuts(std::uint32_t number, double limit,
                 std::span<const typename CutLister<kWords>::Found> cuts,
                 std::span<const std::uint64_t> hashes, double skipped, bool complete);
  void look_at(std::uint32_t number, double limit);
  double search_stored(std::uint32_t number, double limit);
  bool store_cuts(std::uint32_t number, double limit);
  std::pair<double, double> least_stored_loss(std::uint32_t number, double limit);
  [[nodiscard]] std::optional<Cut> next_stored_cut(std::uint32_t number) const;
  [[nodiscard]] Set set_of(std::uint32_t number) const {
    Set set;
    std::copy_n(memo_.key(number), kWords, set.words.begin());
    return set;
  }

  // and_or_cuts.cpp
  double list_cuts(const Set& piece, std::size_t parts, std::size_t allowed, double limit);
  std::size_t mark_wanted_sizes(std::size_t parts, double here, double limit, double& skipped);
  double build_tree(const Set& piece);
  double uppers(const Set& side, std::size_t side_parts, const Set& rest, std::size_t rest_parts);
  void offer_cut(const Set& piece, std::size_t parts, std::size_t allowed, double limit,
                 double here, const Set& side, std::size_t side_parts, double& skipped);
  void add_cut(const Set& side, const Set& side_form, std::size_t side_parts, const Set& rest_form,
               std::size_t rest_parts, std::size_t allowed, double own_loss, double limit,
               double& skipped);
  template <class Offer>
  void list_sides(const Set& piece, std::size_t parts, std::size_t largest, Offer&& offer);
  template <class Offer>
  void grow(const Set& piece, std::size_t parts, std::size_t largest, const Set& side,
            std::size_t side_parts, Set frontier, Set excluded, std::size_t lowest, bool whole,
            Offer&& offer);
  [[nodiscard]] bool hangs_together_without(const Set& rest, std::size_t part, bool before) const;
  [[nodiscard]] Set flood(const Set& within, std::size_t start) const;

  // and_or_peel.cpp
  bool peel_piece(const Set& root, std::size_t width);
  void peel_once(const Remainder& from, std::uint32_t number, std::size_t width,
                 std::vector<std::vector<Remainder>>& by_size);
  static void keep_best(std::vector<Remainder>& remainders, std::size_t width);

  // and_or_recut.cpp
  struct BoundedSet {
    Set set;
    double bound = 0;  ///< of the piece; asked once, for many cuts of it
  };
  /// A piece of a plan and the two that it is cut into, by their numbers; kNone for a single part.
  struct CutNode {
    BoundedSet piece;
    std::uint32_t first = kNone;
    std::uint32_t second = kNone;
    double loss = 0;  ///< of the cut alone
  };
  /// Inner nodes of a plan's trees and the nodes below them, the atoms. The first inner one is the
  /// uppermost.
  struct Window {
    std::vector<std::uint32_t> atoms;
    std::vector<std::uint32_t> inner;
    double loss;  ///< of all its cuts
  };
  /// Atoms as one piece: the least loss of cutting it down to them, and one side of the first cut.
  struct Group {
    BoundedSet piece;
    double loss = kInfinity;
    std::uint32_t side = 0;
  };
  std::vector<CutNode> trees_of(std::span<const ConnectionIndex> plan);
  [[nodiscard]] BoundedSet bounded(const Set& set) { return {set, upper(set, set.size())}; }
  std::optional<double> loss_of_cut(const BoundedSet& piece, const BoundedSet& side,
                                    const BoundedSet& rest);
  std::vector<std::uint32_t> draw_path(const std::vector<CutNode>& nodes,
                                       const std::vector<std::uint32_t>& roots, SplitMix64& random);
  Window open_window(const std::vector<CutNode>& nodes, const std::vector<std::uint32_t>& path,
                     std::size_t most_atoms, SplitMix64& random);
  std::vector<Group> cut_groups(const std::vector<CutNode>& nodes, const Window& window,
                                bool any_way, SplitMix64& random);
  double recut_window(std::vector<CutNode>& nodes, const Window& window, bool any_way,
                      SplitMix64& random);

  // and_or_sequence.cpp
  bool take(ConnectionIndex connection, Steps& steps);
  void take_loops(Steps& steps, bool completes);
  bool take_all(std::vector<ConnectionIndex>& needed, ConnectionIndex last, Steps& steps);
  [[nodiscard]] std::optional<Cut> next_cut(const Set& piece, std::size_t parts,
                                            std::size_t allowed, bool dive);
  [[nodiscard]] ConnectionIndex last_of_cut(const Cut& cut, const Set& rest, const Steps& steps,
                                            const std::vector<ConnectionIndex>& crossing,
                                            bool completes);
  bool take_cut(const Cut& cut, const Set& rest, Steps& steps, bool completes);

  /// The bound g of a piece, and what it counts for the connections at which the piece is cut.
  [[nodiscard]] double upper(const Set& set, std::size_t parts) {
    return lister_.upper(set, parts);
  }
  [[nodiscard]] double tree(const Set& set) { return lister_.tree(set); }

  /// How many of the subassemblies that are allowed a piece can make use of: n parts never need
  /// more than floor(log2 n) at a time, and one more where the side with the last step has to wait.
  [[nodiscard]] static std::size_t useful(std::size_t allowed, std::size_t parts) {
    const std::size_t completes = allowed & kCompletes;
    const auto needed = static_cast<std::size_t>(std::bit_width(parts)) - (completes != 0 ? 0 : 1);
    return std::min(allowed & kMostAllowed, needed) | completes;
  }
  /// What is allowed to the two sides of a cut, `side` first. Within max_subassemblies, the side
  /// that waits takes one from what is allowed to the other.
  [[nodiscard]] std::array<std::size_t, 2> allowed_to_halves(std::size_t side_parts,
                                                             std::size_t rest_parts,
                                                             std::size_t allowed,
                                                             bool side_waits) const {
    const std::size_t of_first = allowed & kMostAllowed;
    if (side_parts == 1) return {of_first, allowed};
    if (rest_parts == 1) return {allowed, of_first};
    const std::size_t beside_one = limited_ ? of_first - 1 : of_first;
    if (side_waits) return {allowed, beside_one};
    return {beside_one, allowed};
  }
  /// The two sides of a cut of a piece, `side` first.
  [[nodiscard]] std::array<Half, 2> halves(const Set& piece, std::size_t parts, std::size_t allowed,
                                           const Cut& cut) const {
    const std::size_t side_parts = cut.side.size();
    const std::size_t rest_parts = parts - side_parts;
    const auto [of_side, of_rest] =
        allowed_to_halves(side_parts, rest_parts, allowed, cut.side_waits);
    return {Half{cut.side, side_parts, of_side}, Half{piece - cut.side, rest_parts, of_rest}};
  }

  /// The piece that stands for one: without symmetry that one itself.
  [[nodiscard]] Set form_of(const Set& set, std::size_t parts) {
    if (!form_ || parts == 1) return set;
    Set form = set;
    form_->canonical(form.words);
    return form;
  }
  [[nodiscard]] std::array<Half, 2> forms_of(std::array<Half, 2> sides) {
    for (Half& side : sides) side.set = form_of(side.set, side.parts);
    return sides;
  }
  /// By how much the bound of the piece that stands for one is above that of the piece itself.
  [[nodiscard]] double bound_of_form_above(const Set& set, std::size_t parts) {
    if (!form_ || !bounded_ || parts == 1) return 0;
    const double above = upper(form_of(set, parts), parts) - upper(set, parts);
    return std::isfinite(above) ? above : 0;
  }

  [[nodiscard]] std::array<std::uint64_t, kWords + 1> key(const Set& set,
                                                          std::size_t allowed) const {
    std::array<std::uint64_t, kWords + 1> result{};
    std::ranges::copy(set.words, result.begin());
    result[kWords] = limited_ ? useful(allowed, set.size()) : allowed & kCompletes;
    return result;
  }
  [[nodiscard]] double unknown_loss() const { return bounded_ ? 0 : -kInfinity; }
  /// What is known of the loss of a piece that stands for itself: it is at least this much.
  [[nodiscard]] double known_loss(const Set& set, std::size_t parts, std::size_t allowed) const {
    if (parts == 1) return 0;
    const std::uint32_t number = memo_.find(key(set, allowed).data());
    return number == StateTable<kWords + 1>::kAbsent ? unknown_loss() : loss_[number];
  }
  /// Whether known_loss() is the loss itself.
  [[nodiscard]] bool is_exact(const Set& set, std::size_t allowed) const {
    if (set.size() == 1) return true;
    const std::uint32_t number = memo_.find(key(set, allowed).data());
    return number != StateTable<kWords + 1>::kAbsent && exact_[number] != 0;
  }

  /// Losses that differ by less than this are the same number, summed in another order.
  [[nodiscard]] static double slack(double scale) {
    return kRewardTolerance * std::max(1.0, std::abs(scale));
  }

  /// From here on nothing but the budget ends the work.
  void lift_limits() {
    try_is_over_ = run_is_over_ = false;
    try_ends_at_ = run_ends_at_ = looks_end_at_ = std::numeric_limits<std::uint64_t>::max();
  }
  /// Whether the work at hand must be left where it is.
  [[nodiscard]] bool must_stop() const {
    return try_is_over_ || run_is_over_ || result_.stop != Stop::None;
  }
  /// The memory that is held, and what the table of losses takes if it doubles before the next
  /// look.
  [[nodiscard]] std::uint64_t bytes() const {
    constexpr std::size_t kUntilNextLook = 512;
    return memo_.bytes_with(kUntilNextLook) + loss_.bytes() + exact_.bytes() +
           cuts_.capacity() * sizeof(Cut) + upper_.bytes() + lists_.bytes() + stored_.bytes() +
           left_.capacity() * (sizeof(double) + sizeof(std::uint32_t)) +
           (cores_[0].capacity() + cores_[1].capacity()) * sizeof(Core);
  }

  const PieceProblem& shared_;
  const Problem& problem_;
  const PieceGains& gains_;
  CutLister<kWords> lister_;
  const PartLinks<kWords>& links_;
  /// Null where the last step completes.
  const FirstSteps* first_;
  /// Null where it makes no difference which step is the last.
  const LastSteps* last_;
  const AssemblyGraph& graph_;
  const Budget& budget_;
  std::uint64_t allowed_bytes_;
  Result& result_;
  /// Whether some bound on what a piece gains is known. Where none is, losses are counted from 0
  /// and may be negative.
  bool bounded_;
  /// Whether max_subassemblies is stated.
  bool limited_;

  /// Whether the cuts of a piece are listed once and kept: where sizes tell little of what a cut
  /// gains, all cuts are looked at anyway.
  bool stores_;

  /// Null where the bound of pieces is not by prices.
  const RaisedPrices* raised_;

  /// The memory of the search: a set of parts with the subassemblies allowed to it; its loss, or a
  /// lower bound on it; and which of the two.
  StateTable<kWords + 1> memo_;
  GrowingArray<double> loss_;
  GrowingArray<unsigned char> exact_;
  /// Where cuts are kept: the bound of each piece of memo_, and its cuts.
  GrowingArray<double> upper_;
  GrowingArray<StoredCuts> lists_;
  GrowingArray<StoredCut> stored_;
  /// The cuts of the piece that is being listed, and the hashes of their sides.
  typename CutLister<kWords>::List listed_;
  std::vector<std::uint64_t> hashes_;
  /// The kept cuts of the pieces that are being searched by their estimates, those of the innermost
  /// piece last.
  std::vector<std::pair<double, std::uint64_t>> promising_;
  /// What the best known plan earns, and what a piece may lose at most where a plan is to be no
  /// worse.
  double known_reward_ = -kInfinity;
  double most_loss_ = kInfinity;
  /// With symmetry: what takes a piece to the one that stands for it.
  std::optional<OrbitForm> form_;
  /// The cuts of the pieces that are being searched, those of the innermost piece last.
  std::vector<Cut> cuts_;

  /// The pieces of memo_ that are being searched where cuts are kept, each cut from the one before
  /// it; and as far as it was asked for, what the parts of each cost more, and of a piece that is
  /// looked at next.
  std::vector<std::uint32_t> path_of_pieces_;
  std::vector<RaiseOnPath> raises_;

  /// Whether sweep() may be used from here on: no piece had too many cuts to keep.
  bool sweeps_;
  /// For sweep(): what each piece of memo_ may lose at most, and the pieces that are reached, by
  /// their parts.
  std::vector<double> left_;
  std::vector<std::vector<std::uint32_t>> layers_;
  Unfinished unfinished_;
  std::vector<std::unique_ptr<Sweeper>> sweepers_;  ///< of each thread

  /// Scratch memory: whether sides of each size are wanted, whether each connection is gone, and
  /// what hubs() has met.
  std::vector<unsigned char> wanted_;
  std::vector<unsigned char> gone_;
  std::vector<std::uint32_t> met_;
  std::vector<std::uint32_t> low_;
  std::vector<HubFrame> path_;
  std::vector<PartIndex> parts_;
  /// by_reach(), by reach and parts, as far as it was asked for.
  std::vector<std::vector<double>> by_reach_;

  /// Cores, and cores that the last step of all is a cut of; the most parts of one, 0 where none
  /// are known.
  bool cores_known_ = false;
  std::array<std::vector<Core>, 2> cores_;
  const std::size_t listed_core_parts_;
  std::size_t most_core_parts_ = 0;
  std::vector<double> loss_off_core_;
  PieceTree piece_tree_;  ///< of the piece at hand
  std::vector<PartIndex> core_parts_;

  Deepening deepening_;
  /// The bound of the piece that solve() is at: rounding errors are measured by its size.
  double scale_ = 0;
  /// How many sides of cuts were looked at, and how often pieces whose cuts are kept.
  std::uint64_t looks_ = 0;
  std::uint64_t visits_ = 0;
  /// Cuts of the same estimate are taken as they are listed where this is 0, and else in an order
  /// that depends on it.
  std::uint64_t salt_ = 0;
  /// The present try at a piece ends when the search has expanded so many pieces.
  std::uint64_t try_ends_at_ = 0;
  /// The present run ends when the search has expanded so many pieces, or looked at so many sides.
  std::uint64_t run_ends_at_ = 0;
  std::uint64_t looks_end_at_ = 0;
  bool try_is_over_ = false;
  bool run_is_over_ = false;

  /// The pieces of the problem, and the subassemblies allowed; with kCompletes where the last step
  /// can be of no other piece.
  std::vector<Set> pieces_;
  std::size_t allowed_ = 0;
  /// Whether list_cuts() may leave out cuts that peel() has no use for.
  bool peeling_ = false;
  /// What the last peel() or recut() found: pieces, each with the side to cut off it.
  std::vector<std::pair<Set, Set>> peeled_;
};

}  // namespace orasp::detail
