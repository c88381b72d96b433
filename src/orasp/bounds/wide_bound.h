#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "orasp/bounds/bound.h"
#include "orasp/model/objectives/objective_term.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// A bound where steps and states are wide (TransitionSystem::wide).
///
/// Idea.       The objective is a sum, and each kind of term is bounded on its own:
///             * Terms that look at one step alone: by BoundKind::Best of the same problem without
///               those that look back, where plans handle everything one by one; else each
///               connection that must still be handled earns at most its greatest reward, each
///               other one that or nothing.
///             * Formulas: what they yield over all values of their variables (RangedFormula).
///               Where steps handle one connection and a formula falls along a line in `elapsed`,
///               what must still be handled comes at best in the order of Smith's rule, from the
///               time on that has passed; whatever else is handled only makes it later.
///             * Where each step takes a single part, what moving it costs is counted by part. If
///               all but the base has to come off a base, each other part moves once. Else one end
///               of each connection does: connections share what their ends cost, so that none is
///               charged more than a move (cover_prices).
///             * `changeover`: each value of an attribute that must still come is entered at least
///               once. The cheapest way to enter all of them, from the one in force, is worked out
///               for every set of up to kMostValues values (Held and Karp 1962); beyond, each is
///               entered by its cheapest change.
///             * `route`: the way to the places that must still be visited is at least as long as
///               the shortest tree that joins them and the place of the last step, under prices of
///               places that make the tree of the start look like a way (Held and Karp 1970).
///             What must still come under a goal is what it asks for, and what has to go before
///             that by `after`.
/// Guarantee.  Admissible and consistent: each part is the exact answer to a question with fewer
///             rules, and a step answers a part of it. The bound by values is exact where nothing
///             rules the order of the steps.
/// Reference.  Smith (1956), Naval Research Logistics Quarterly 3, 59-66; Held and Karp (1962),
///             SIAM J. 10(1), 196-210, and (1970), Operations Research 18(6), 1138-1162; Prim
///             (1957), Bell System Technical Journal 36(6), 1389-1401.
/// Cost.       O(connections + values * words + places^2) a state.
/// Limit.      Not known where a step may earn any amount (functions, formulas without a range).
class WideBound {
 public:
  static constexpr std::size_t kMostValues = 12;

  explicit WideBound(const TransitionSystem& system);
  ~WideBound();
  WideBound(const WideBound&) = delete;
  WideBound& operator=(const WideBound&) = delete;

  [[nodiscard]] bool known() const { return known_; }
  /// The most that a plan can still earn from a state on.
  [[nodiscard]] double operator()(SetView state);
  /// What moves of single parts cost of that, for the state that was asked last. Prices are set at
  /// the start; an order of states without them sees other plans.
  [[nodiscard]] double priced_moves() const { return priced_moves_; }

 private:
  struct Changes;
  struct Way;
  void set_steps(const TransitionSystem& system);
  void set_terms(const TransitionSystem& system);
  [[nodiscard]] bool add_line_of_seconds(const WeightedTerm& addend);
  [[nodiscard]] RewardRange range_of(const WeightedTerm& addend,
                                     const RangeQuestion& question) const;
  void set_single_moves();
  [[nodiscard]] double most_of_moving(PartIndex part) const;
  [[nodiscard]] double greatest_of(const WeightedTerm& addend, const RangeQuestion& question) const;
  [[nodiscard]] double most_inside(const WeightedTerm& addend) const;
  [[nodiscard]] double least_of_moves(SetView open);
  [[nodiscard]] double of_steps(SetView open);
  [[nodiscard]] double of_changes(const Changes& changes, SetView state) const;
  [[nodiscard]] double of_way(const Way& way, SetView state);
  [[nodiscard]] bool collect_places(SetView open);
  [[nodiscard]] double tree(const Way& way, std::uint32_t from);
  [[nodiscard]] double length_of_way(const Way& way, std::uint32_t from);
  void set_prices(Way& way);
  [[nodiscard]] std::uint32_t place_in_force(const Way& way, SetView state) const;

  const TransitionSystem& system_;
  bool known_ = true;
  /// The problem without what looks back, and its bound, where that is not wide.
  std::unique_ptr<const Problem> plain_problem_;
  std::unique_ptr<const TransitionSystem> plain_system_;
  std::unique_ptr<Bound> plain_bound_;
  /// Else: by connection, the most that a step earns for it; of part steps, see of_steps().
  std::vector<double> greatest_;
  double last_surplus_ = 0;
  double most_of_step_ = 0;
  /// Where each step takes a single part: what its move costs at least, by part; or what each
  /// connection is charged of it. Both empty where steps take more, or may earn by moving.
  std::vector<double> cost_of_move_;
  std::vector<double> price_;
  bool by_part_ = false;
  bool may_stop_ = false;
  /// What terms earn that go along lines in seconds: by connection, at the start of time and for
  /// each second. Empty where there are none.
  std::vector<double> at_;
  std::vector<double> by_second_;
  /// The connections whose line falls, by Smith's rule.
  std::vector<ConnectionIndex> falling_;
  double seconds_of_start_ = 0;      ///< what had passed at the start
  double all_seconds_ = 0;           ///< what all open connections last
  std::vector<std::uint64_t> must_;  ///< the connections that every plan handles
  std::vector<Changes> changes_;
  std::vector<Way> ways_;
  // Scratch.
  double priced_moves_ = 0;
  std::vector<unsigned char> moves_;  ///< by part: whether it is still to move
  std::vector<std::uint32_t> places_;
  std::vector<double> distance_;
  std::vector<std::uint32_t> nearest_;
  std::vector<std::uint32_t> degree_;
  std::uint32_t end_ = 0;
  std::vector<unsigned char> wanted_;
};

}  // namespace orasp
