#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "orasp/model/detail/problem_totals.h"
#include "orasp/model/detail/step_pieces.h"
#include "orasp/model/formula_range.h"
#include "orasp/model/tolerance.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// What the rewards of a term depend on. Planners choose their method by it, so each flag must be
/// true to the formula; false is always safe, but for the last two.
struct TermSight {
  /// On nothing but the sizes of A and B, whether the step completes, and whether A and B together
  /// are a whole starting piece: ObjectiveTerm::size_reward gives them.
  bool sizes_only = false;
  /// On numbers alone (StepFacts), not on which parts are on which side: `reward` then looks at
  /// nothing else.
  bool counting = false;
  /// What a step earns is the connection's own (what a step for it earns that separates nothing)
  /// and, where it separates, a gain that depends on nothing but A, B, the connection and whether
  /// the step completes.
  bool piece_only = false;
  /// piece_only, and that gain depends on the sizes of A and B alone.
  bool gain_by_sizes = false;
  /// piece_only, and that gain depends on nothing but which parts move.
  bool gain_by_moved = false;
  /// On nothing but the connection and how many are present.
  bool order_only = false;
  /// piece_only, and a piece gains less the more parts move.
  bool moving_more_costs_more = false;
  /// piece_only, and the gain depends on the connection too.
  bool gain_by_connection = false;
  /// On whether A and B together are a whole starting piece.
  bool starting_pieces = false;
  /// On how long the steps before took.
  bool elapsed = false;
  /// On how many connections are present.
  bool by_place = false;
  /// On what the steps before left behind (detail::StepMemory), which is then part of a state.
  bool looks_back = false;
  /// `range` depends on which connection it is, beyond its duration and its place.
  bool range_by_connection = false;
  /// Foreign code is called, which may fail or yield a number that is not finite.
  bool calls_out = false;
};

/// Rewards that are sums of costs by size, the quickest to work out: `last` for a step that
/// completes (by whether it separates), `alone` for another that separates nothing, else the
/// negative of `base` and the costs of A and of B.
struct SizeCosts {
  std::array<double, 2> last{};
  double alone = 0;
  double base = 0;
  std::vector<double> costs;  ///< by number of parts

  [[nodiscard]] double reward(std::size_t a, std::size_t b, bool separates, bool completes) const {
    if (completes) return last[separates ? 1 : 0];
    if (!separates) return alone;
    return 0.0 - (base + costs[a] + costs[b]);
  }
};

/// A question for the range of a step's reward.
struct RangeQuestion {
  ConnectionIndex connection = 0;
  double duration = 0;     ///< s, of the connection
  double most_before = 0;  ///< the most connections that may be present before the step
  bool completes = false;
};

/// A question for what a step may earn of which it is known when it comes: time is how many steps
/// came before, or how long they took.
struct PlaceQuestion {
  ConnectionIndex connection = 0;
  Interval duration;       ///< s, of all that the step handles
  bool several = false;    ///< it may handle more than `connection`
  FormulaLine before;      ///< connections present before the step
  FormulaLine after;       ///< and after it
  FormulaLine elapsed;     ///< s, of all that was handled before
  Interval time;           ///< all times at which the step may come
  bool separates = false;  ///< whether it separates
  bool completes = false;
};

/// A question for the most that a cut gains which moves certain parts and others.
struct LargerPiece {
  std::size_t least = 1;  ///< the fewest parts that move, and the most
  std::size_t most = 1;
  /// Once it is known that no more than this is gained, nothing lower needs to be found.
  double low_enough = -kInfinity;
};

/// What a term that looks back costs: the changes of an attribute, or a way. For bounds.
struct LookBackCosts {
  std::size_t attribute = 0;  ///< of ProblemTotals::attributes; where `change` is set
  /// What coming from one value to another costs, by their numbers (detail::StepMemory).
  std::function<double(std::size_t from, std::size_t to)> change{};
  double per_metre = 0;
  std::optional<Vector3> start{};
};

/// One addend of an objective, resolved for one problem. Immutable and shared by threads, but for
/// terms with `for_one_thread`.
class ObjectiveTerm {
 public:
  ObjectiveTerm() = default;
  ObjectiveTerm(const ObjectiveTerm&) = delete;
  ObjectiveTerm& operator=(const ObjectiveTerm&) = delete;
  virtual ~ObjectiveTerm() = default;

  TermSight sees;

  /// A copy for one thread alone; null where all threads may share this one.
  [[nodiscard]] virtual std::unique_ptr<const ObjectiveTerm> for_one_thread() const {
    return nullptr;
  }

  /// What the step earns. `movement` and the sides of `pieces` are set unless every term of the
  /// objective is `counting`.
  [[nodiscard]] virtual double reward(const detail::StepFacts& facts,
                                      const detail::Movement& movement,
                                      const detail::StepPieces& pieces) const = 0;

  /// Whether rewards are better asked for many at once (Callable::rewards): a copy for one thread,
  /// while it takes notes, keeps each step that `reward` is asked for and gives its place among
  /// those kept, from 0; noted_rewards() then gives what they earn, in that order.
  [[nodiscard]] virtual bool can_take_notes() const { return false; }
  /// Begins anew, or ends.
  virtual void take_notes(bool begin) const { static_cast<void>(begin); }
  /// Ends taking notes. @throws InputError as `reward`.
  [[nodiscard]] virtual std::span<const double> noted_rewards() const { return {}; }

  /// The same as costs by size, if it can be said so.
  [[nodiscard]] virtual const SizeCosts* size_costs() const { return nullptr; }
  /// If sees.looks_back: its costs.
  [[nodiscard]] virtual std::optional<LookBackCosts> look_back_costs() const {
    return std::nullopt;
  }
  /// If sees.sizes_only: what a step earns that cuts a piece into a and b parts (0 and 0: it
  /// separates nothing).
  [[nodiscard]] virtual double size_reward(std::size_t a, std::size_t b, bool completes,
                                           bool whole_start) const {
    static_cast<void>(whole_start);
    const SizeCosts* const costs = size_costs();
    assert(costs != nullptr);
    return costs->reward(a, b, a != 0, completes);
  }

  /// Least and greatest reward of a step in every reachable state; planners prove with it.
  [[nodiscard]] virtual RewardRange range(const RangeQuestion& question) const {
    static_cast<void>(question);
    return {-kInfinity, kInfinity};
  }

  /// A line in time that the reward of every such step lies on, whatever else holds; where it lies
  /// on none, the slope is 0 and `at` the range for all times. By default nothing but `range` is
  /// known.
  [[nodiscard]] virtual FormulaLine reward_over(const PlaceQuestion& question) const {
    const FormulaLine& before = question.before;
    const double most =
        before.at.greatest + std::max(before.slope.greatest * question.time.least,
                                      before.slope.greatest * question.time.greatest);
    const RewardRange known = range({.connection = question.connection,
                                     .duration = question.duration.greatest,
                                     .most_before = most,
                                     .completes = question.completes});
    return {{known.least, known.greatest}, {0, 0}};
  }

  /// What each second that a step lasts earns it, beyond what `range` says of a connection without
  /// duration. For steps that take several connections.
  [[nodiscard]] virtual double by_second() const { return 0; }

  /// If sees.piece_only: the most that a cut gains, times `weight`, whose moved piece has `moved`
  /// parts and whose other has `kept`; infinite where that is not known, exact where
  /// sees.gain_by_sizes.
  [[nodiscard]] virtual double greatest_gain(double weight, std::size_t moved,
                                             std::size_t kept) const {
    static_cast<void>(weight);
    static_cast<void>(moved);
    static_cast<void>(kept);
    return kInfinity;
  }
  /// The same for a cut between two fixed sides, of so many parts, which moves nothing.
  [[nodiscard]] virtual double greatest_gain_unmoved(double weight, std::size_t first,
                                                     std::size_t second) const {
    static_cast<void>(weight);
    static_cast<void>(first);
    static_cast<void>(second);
    return kInfinity;
  }
  /// If sees.piece_only: the most that a cut gains, times `weight`, which moves the side A of
  /// `moved`, whatever from; infinite where that is not known.
  [[nodiscard]] virtual double greatest_gain_of_moving(double weight,
                                                       const detail::StepPieces& moved) const {
    static_cast<void>(weight);
    static_cast<void>(moved);
    return kInfinity;
  }
  /// The same of a cut that moves a piece of so many parts, those of the side A of `some` among
  /// them; -infinity where no piece is so large.
  [[nodiscard]] virtual double greatest_gain_of_moving_with(double weight,
                                                            const detail::StepPieces& some,
                                                            const LargerPiece& piece) const {
    static_cast<void>(piece);
    const bool more_is_less = sees.moving_more_costs_more && weight >= 0;
    return more_is_less ? greatest_gain_of_moving(weight, some) : kInfinity;
  }
  /// What each kilogram that moves costs, times `weight`, of a term whose steps earn nothing else
  /// but a fixed amount of 0 or less wherever something moves. 0 where that is not so.
  [[nodiscard]] virtual double cost_of_mass(double weight) const {
    static_cast<void>(weight);
    return 0;
  }
  /// If sees.gain_by_connection: adds to `costs`, for each connection, by how much less a cut at it
  /// gains at least, times `weight`, than the three above say.
  virtual void add_extra_costs(double weight, std::span<double> costs) const {
    static_cast<void>(weight);
    static_cast<void>(costs);
  }
};

struct WeightedTerm {
  double weight = 1;
  std::unique_ptr<const ObjectiveTerm> term;
};

/// A term that is nothing but costs by size.
class SizeCostTerm : public ObjectiveTerm {
 public:
  explicit SizeCostTerm(SizeCosts costs) : costs_(std::move(costs)) {
    sees.sizes_only = sees.counting = sees.piece_only = sees.gain_by_sizes = true;
  }
  [[nodiscard]] const SizeCosts* size_costs() const final { return &costs_; }
  [[nodiscard]] double reward(const detail::StepFacts& facts, const detail::Movement& movement,
                              const detail::StepPieces& pieces) const final {
    static_cast<void>(movement);
    if (!pieces.rest_sizes.empty() && !facts.completes) {
      double spent = costs_.base + costs_.costs[facts.a_parts];
      for (const std::uint32_t parts : pieces.rest_sizes) spent += costs_.costs[parts];
      return 0.0 - spent;
    }
    return costs_.reward(facts.a_parts, facts.b_parts, facts.separates, facts.completes);
  }
  [[nodiscard]] double greatest_gain(double weight, std::size_t moved,
                                     std::size_t kept) const final {
    return weight * (costs_.reward(moved, kept, moved != 0, false) - costs_.alone);
  }
  [[nodiscard]] double greatest_gain_unmoved(double weight, std::size_t first,
                                             std::size_t second) const final {
    return greatest_gain(weight, first, second);
  }

 protected:
  [[nodiscard]] const SizeCosts& costs() const { return costs_; }

 private:
  SizeCosts costs_;
};

}  // namespace orasp
