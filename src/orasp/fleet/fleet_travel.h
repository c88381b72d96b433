#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "orasp/containers/growing_array.h"
#include "orasp/containers/state_table.h"
#include "orasp/fleet/fleet_expander.h"
#include "orasp/fleet/fleet_makespan.h"
#include "orasp/model/tolerance.h"
#include "orasp/task/budget.h"

namespace orasp {

/// The most steps in which the least travel is looked for. There may be more than parts: a
/// subassembly that goes by way of nearer sites travels less, since distances are squared.
inline constexpr std::size_t kFleetMaxTravelSteps = 500;

/// The least travel in which a fleet takes the product apart within so many steps.
///
/// Problem.    Now it matters where the subassemblies stand: travel is the sum, over all parts and
///             steps, of the squared distance moved. Sites at the same point are alike, so a state
///             names points, each with room for as many subassemblies as it has sites. Waiting is
///             of use at the end alone, so it is no step.
/// Idea.       Depth-first branch and bound with limits that rise (the thresholds of IDA*, Korf
///             1985), over a table of states with their steps left, each with a proved lower bound
///             or its exact value (as in Reinefeld and Marsland 1994). A state of several
///             subassemblies is first bounded by the sum of each alone, which is what most prunes.
///             States that cannot be finished in time are cut by FleetMakespanSearch.
/// Bounds.     Hops: each part along the cheapest chain of places to the depot within the steps
///             left; admissible, for that is what a part pays at least, and consistent. Each
///             subassembly alone: admissible, for a plan of the whole, looked at on one
///             subassembly, is a plan for that, and travel adds up over parts.
/// Guarantee.  Exact up to kTravelTolerance; a bound, if stopped, is proved.
/// Cost.       Exponential; the states of FleetMakespanSearch times the ways to place them.
template <class Parts>
class FleetTravelSearch {
 public:
  using StateNumber = typename FleetMakespanSearch<Parts>::StateNumber;
  using Shape = typename FleetShapes<Parts>::Shape;

  /// One subassembly, and where it stands.
  struct Placed {
    Parts parts = 0;
    std::uint8_t point = 0;
    friend bool operator==(const Placed&, const Placed&) = default;
  };
  using Places = std::vector<Placed>;

  /// Refers to all three. @throws InputError above 255 sites.
  FleetTravelSearch(FleetExpander<Parts>& expander, FleetMakespanSearch<Parts>& makespan,
                    const Budget& budget);

  /// Runs to the least travel within `steps`, or to a limit. `makespan` has shown that the product
  /// can be finished in them.
  void run(StateNumber start, std::size_t steps);
  /// A good way to place the plan that `makespan` holds for the start: upper() becomes its travel
  /// or less.
  void place_known_plan(StateNumber start);

  /// Proved: no plan within the steps travels less, m^2.
  [[nodiscard]] double lower() const { return lower_; }
  /// Travel of the best plan found, m^2; infinity: none.
  [[nodiscard]] double upper() const { return upper_; }
  [[nodiscard]] Stop stop() const { return stop_ != Stop::None ? stop_ : makespan_.stop(); }
  [[nodiscard]] const Statistics& statistics() const { return statistics_; }
  [[nodiscard]] std::uint64_t bytes() const;
  /// Distinct states met by both searches.
  [[nodiscard]] std::uint64_t num_states() const { return table_.size() + makespan_.num_states(); }

  /// The best plan found, as a step by step plan of the model.
  [[nodiscard]] FleetPlan plan();

 private:
  struct Node {
    double lower = 0;
    std::uint32_t next = 0;
    bool exact = false;
  };
  struct Successor {
    std::uint32_t node;
    double cost;
    double total;  ///< cost and lower bound, when listed
    std::uint64_t rank;
  };
  [[nodiscard]] std::uint32_t number_of(std::span<const Placed> placed, std::size_t steps);
  [[nodiscard]] Places placed(std::uint32_t node) const;
  [[nodiscard]] StateNumber state(std::uint32_t node) const {
    return static_cast<StateNumber>(table_.key(node)[0]);
  }
  [[nodiscard]] std::size_t steps_left(std::uint32_t node) const {
    return static_cast<std::size_t>(table_.key(node)[0] >> 32);
  }
  [[nodiscard]] double hops(std::span<const Placed> placed, std::size_t steps) const;
  [[nodiscard]] double hop(std::size_t point, std::size_t steps) const {
    return hops_[std::min(steps, hops_.size() - 1)][point];
  }
  /// Lists the steps from `node` whose cost and hops afterwards stay within `limit`.
  /// @returns a lower bound on those that do not.
  double list_successors(std::uint32_t node, double limit, std::vector<Successor>& successors);
  /// The least travel from `node` if that is at most `limit` (then the node is exact), else a bound
  /// above it.
  double solve(std::uint32_t node, double limit);
  /// Looks for a better plan than the best: beam search over placed states, by travel so far and
  /// bound, or first by how near the end they seem.
  enum class Prefer { LittleTravel, NearTheEnd };
  void find_plan(const std::vector<std::uint32_t>& starts, Prefer prefer);
  /// Calls `visit(places)` for every way to place the blocks after those of `placed` that stand.
  template <class Visit>
  void for_each_placing(std::span<const Parts> blocks, Places& placed, Visit&& visit) const;
  bool expired();
  /// The same, but it looks only now and then.
  bool expired_by_now() { return stop_ != Stop::None || (polls_++ % 64 == 0 && expired()); }

  FleetExpander<Parts>& expander_;
  FleetMakespanSearch<Parts>& makespan_;
  const Budget& budget_;
  const std::size_t robots_;
  std::vector<PlaceIndex> first_site_;         ///< of each point; point 0 is the depot
  std::vector<std::size_t> room_;              ///< sites at each point
  std::vector<std::vector<double>> distance_;  ///< squared, between points
  std::vector<std::vector<double>> hops_;      ///< by steps left, of each point
  detail::StateTable<0> table_;
  detail::GrowingArray<Node> nodes_;
  std::vector<std::vector<Successor>> levels_;
  double lower_ = 0;
  double upper_ = kInfinity;
  std::vector<Places> best_;  ///< the states of the best plan, the start first
  Statistics statistics_;
  std::uint64_t polls_ = 0;
  Stop stop_ = Stop::None;
};

}  // namespace orasp
