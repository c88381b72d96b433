#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "orasp/containers/growing_array.h"
#include "orasp/containers/state_table.h"
#include "orasp/fleet/fleet_expander.h"
#include "orasp/fleet/fleet_shapes.h"
#include "orasp/task/budget.h"

namespace orasp {

/// The fewest steps in which a fleet takes the product apart, from any set of subassemblies.
///
/// Problem.    For the number of steps only the set of subassemblies matters: blocks that stay keep
///             their sites, which differ, and blocks that move may take any free one. So a state is
///             a set of disjoint blocks of parts.
/// Idea.       Depth first with a limit on the steps, one more at a time (iterative deepening, Korf
///             1985), over a table of every state met: the steps that it is proved to take at
///             least, and at most where a plan is known. With k steps left for n parts a step must
///             free at least n - robots * (k - 1) of them, so only so many robots may hold blocks
///             that move. Each subassembly is first asked for alone, with all robots and sites to
///             itself; what is proved of it holds in every state that it is part of.
/// Bounds.     parts / robots, rounded up: admissible, for each part is freed once by a robot of
///             its own, and consistent. Each subassembly alone: admissible, for a plan of the
///             whole, looked at on one subassembly, keeps all rules with no more robots and sites.
/// Guarantee.  Exact. Every answer but a stop is proved.
/// Cost.       Exponential. Memory: 8 bytes for each subassembly that may be there, and about 30
///             more, a state.
template <class Parts>
class FleetMakespanSearch {
 public:
  using StateNumber = std::uint32_t;
  using Shape = typename FleetShapes<Parts>::Shape;
  static constexpr std::uint16_t kNoPlan = std::numeric_limits<std::uint16_t>::max();

  /// Parts of a cluster for a first plan: few enough that every way to take it apart is listed at
  /// once.
  static constexpr std::size_t kFirstClusters = 4;

  /// Refers to both, which must outlive it.
  FleetMakespanSearch(FleetExpander<Parts>& expander, const Budget& budget);
  ~FleetMakespanSearch() { expander_.set_interrupt({}); }
  FleetMakespanSearch(const FleetMakespanSearch&) = delete;
  FleetMakespanSearch& operator=(const FleetMakespanSearch&) = delete;

  /// Number of the state with subassemblies of these shapes. Their order does not matter.
  StateNumber number_of(std::span<const Parts> subassemblies);
  /// The same, from the shapes, which it sorts.
  StateNumber number_of_shapes(std::span<Shape> shapes);
  /// The shapes of a state, each by the subassembly that stands for it, in the order of the table.
  [[nodiscard]] std::vector<Parts> pieces(StateNumber state) const;
  [[nodiscard]] FleetShapes<Parts>& shapes() { return shapes_; }
  /// The most subassemblies that a state may have.
  [[nodiscard]] std::size_t most_pieces() const { return most_; }
  /// Steps that the state is proved to take at least; kNoPlan: it has no plan.
  [[nodiscard]] std::size_t lower(StateNumber state) const { return nodes_[state].lower; }
  /// Steps of the best plan known from the state; kNoPlan: none is known.
  [[nodiscard]] std::size_t upper(StateNumber state) const { return nodes_[state].upper; }

  /// Orders states by how near they seem to the end: less is nearer. First by lower(); then by the
  /// steps that peeling takes, outermost parts first, with the robots there are (the level
  /// algorithm of Hu 1961): a guess, no bound.
  [[nodiscard]] std::uint64_t rank(StateNumber state) const;

  /// Whether the state can be finished within `steps`; raises lower() above `steps` if not. False
  /// too when stopped.
  bool finishes(StateNumber state, std::size_t steps);
  /// Looks for a plan as good as it finds quickly: beam search of growing width, up to `width`
  /// states a layer, over the steps whose clusters have at most `cluster` parts.
  void find_plan(StateNumber start, std::size_t width, std::size_t cluster);

  [[nodiscard]] Stop stop() const { return stop_; }
  [[nodiscard]] const Statistics& statistics() const { return statistics_; }
  [[nodiscard]] std::uint64_t bytes() const;
  [[nodiscard]] std::uint64_t num_states() const { return table_.size(); }

  /// The subassemblies of the product in the plan behind upper(), the whole first, none last.
  [[nodiscard]] std::vector<std::vector<Parts>> plan_from(StateNumber start);

 private:
  struct Node {
    StateNumber next = 0;      ///< on the way to a plan of `upper` steps
    std::uint32_t listed = 0;  ///< the last listing of successors that met it
    std::uint16_t lower = 0;
    std::uint16_t upper = kNoPlan;
  };
  struct Successor {
    StateNumber state;
    std::uint64_t rank;
  };

  /// The shapes of a state, ascending.
  [[nodiscard]] std::span<const std::uint64_t> shapes_of(StateNumber state) const;
  /// The state of the shape at position `i` of another.
  StateNumber alone(StateNumber state, std::size_t i);
  std::size_t raised_by_pieces(StateNumber state);
  /// What a step must do, for its successor to be listed.
  struct Demand {
    std::size_t held;                         ///< at most so many robots on moved blocks
    std::size_t freed = 0;                    ///< at least so many parts freed
    std::size_t blocks;                       ///< at most so many subassemblies left
    std::size_t cluster = kMostParts<Parts>;  ///< at most so many parts in a cluster
    std::size_t most = std::numeric_limits<std::size_t>::max();  ///< successors that are enough
  };
  [[nodiscard]] Demand demand_of(StateNumber state, std::size_t steps) const;
  /// Calls `visit(after, from)`, which says whether to go on, for every step that meets the demand:
  /// the subassemblies after it, and the position in pieces(state) of the one each comes from.
  template <class Visit>
  void for_each_successor(StateNumber state, const Demand& demand, Visit&& visit);
  void list_successors(StateNumber state, const Demand& demand, std::vector<Successor>& successors);
  void improve(StateNumber state, StateNumber next);
  bool expired();
  /// The same, but it looks only now and then.
  bool expired_by_now() { return stop_ != Stop::None || (polls_++ % 64 == 0 && expired()); }

  FleetExpander<Parts>& expander_;
  const Budget& budget_;
  const std::size_t robots_;
  const std::size_t most_;  ///< subassemblies of a state
  FleetShapes<Parts> shapes_;
  detail::StateTable<0> table_;
  detail::GrowingArray<Node> nodes_;
  std::vector<std::uint64_t> key_;  ///< of the state that is being numbered
  std::vector<Shape> numbered_;     ///< its shapes
  std::vector<std::vector<Successor>> levels_;
  std::uint32_t listings_ = 0;
  std::uint64_t polls_ = 0;
  bool is_replaying_ = false;  ///< the steps of a plan, whatever the time is
  Statistics statistics_;
  Stop stop_ = Stop::None;
};

}  // namespace orasp
