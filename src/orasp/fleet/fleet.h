#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orasp/model/connection_set.h"
#include "orasp/model/problem.h"
#include "orasp/task/fleet_plan.h"

namespace orasp {

/// Several robots take a product apart in synchronous steps (Culbertson, Bandyopadhyay and
/// Schwager, IROS 2019).
///
/// A part without connections is in the depot; every subassembly has a site of its own. In a step
/// each part has one motion: it stays, or it moves along one signed axis. A connection is cut by
/// the motions of its two parts and nothing else: equal motions keep it, other motions must pull it
/// apart along its axis. A part that moves or leaves its site needs a robot of its own; a part that
/// stays cannot change its site, except for the depot. docs/format.md, section "Fleet problems",
/// states every rule.

/// What a plan of several robots is to be good at: the objective of the problem.
enum class FleetObjective {
  /// `makespan`: the fewest steps.
  Makespan,
  /// `fleet_travel`: the least travel, over all parts and steps the squared distance, in m^2.
  Travel,
};

/// The horizon that a method for several robots is given.
struct FleetOptions {
  /// At most so many steps. Empty: for the makespan as many as it takes, for the travel the fewest
  /// possible.
  std::optional<std::size_t> steps = {};
};

/// A fleet problem: a checked view on a Problem, which must outlive it. Immutable. Indices of parts
/// and connections are those of the problem.
///
///     const Problem problem = load_scenario("fleet-lattice");
///     const FleetProblem fleet(problem);            // InputError where something is missing
///     fleet.robots();                               // 4
///     fleet.squared_distance(kDepot, 2);            // 5 m^2
class FleetProblem {
 public:
  /// @throws InputError with one sentence: no `fleet`, no site, a connection without `axis` or of a
  /// part to itself,
  ///         an attempt that may fail, the direction assembly (a plan read backwards assembles).
  explicit FleetProblem(const Problem& problem);
  /// A problem that goes out of scope at once.
  explicit FleetProblem(const Problem&&) = delete;

  [[nodiscard]] const Problem& problem() const { return *problem_; }
  [[nodiscard]] std::size_t num_parts() const { return problem_->num_parts(); }
  [[nodiscard]] std::size_t num_connections() const { return problem_->num_connections(); }
  [[nodiscard]] FleetObjective objective() const { return objective_; }
  /// What `plan` earns: minus its steps, or minus its travel. More is better, as for one robot.
  [[nodiscard]] double reward(const FleetPlan& plan) const;
  [[nodiscard]] std::size_t robots() const { return problem_->spec().fleet->robots; }
  [[nodiscard]] std::size_t num_sites() const { return problem_->spec().fleet->sites.size(); }
  /// Depot and sites: num_sites() + 1.
  [[nodiscard]] std::size_t num_places() const { return num_sites() + 1; }
  /// Coordinates in m.
  [[nodiscard]] const std::array<double, 2>& place(PlaceIndex place) const {
    return place == kDepot ? problem_->spec().fleet->depot
                           : problem_->spec().fleet->sites[place - 1];
  }
  /// "depot", "site 1".
  [[nodiscard]] static std::string place_name(PlaceIndex place);
  /// What moving one part from `a` to `b` counts in the objective travel, in m^2.
  [[nodiscard]] double squared_distance(PlaceIndex a, PlaceIndex b) const;

  /// The direction (of kDirectionNames) in which the first part of connection `c` comes off the
  /// second.
  [[nodiscard]] std::size_t axis(ConnectionIndex c) const { return axis_[c]; }
  /// Spatial axes that are needed: 1 (x), 2 (x, y) or 3.
  [[nodiscard]] std::size_t dimensions() const { return dimensions_; }
  /// Whether these motions of its first and its second part pull connection `c` apart.
  [[nodiscard]] bool pulls_apart(ConnectionIndex c, Motion first, Motion second) const {
    const Motion away = motion_along(axis_[c]);
    const Motion back = motion_along(opposite(axis_[c]));
    return first == away ? second == kStay || second == back : first == kStay && second == back;
  }
  /// Subassemblies that there may be after a step, and at the start: one a site, and the limit of
  /// the problem.
  [[nodiscard]] std::size_t most_subassemblies() const { return most_subassemblies_; }

  /// Why there is no plan, where that shows without search; empty where search must tell.
  [[nodiscard]] std::optional<std::string> infeasibility() const;

 private:
  const Problem* problem_;
  FleetObjective objective_ = FleetObjective::Makespan;
  std::vector<std::size_t> axis_;
  std::size_t dimensions_ = 1;
  std::size_t most_subassemblies_ = 0;
};

/// What stands where.
struct FleetState {
  ConnectionSet open;              ///< connections not yet cut
  std::vector<PlaceIndex> places;  ///< of each part

  friend bool operator==(const FleetState&, const FleetState&) = default;
};

/// The whole product with its pieces at these sites, one for each part (the depot for a part
/// without connections).
[[nodiscard]] FleetState fleet_start(const FleetProblem& fleet, std::span<const PlaceIndex> places);

/// The step that these motions and new places of all parts make, and the state after it in `state`.
/// Follows the rules, does not check them (fleet/fleet_validate.h does): cuts every connection
/// whose parts move differently, and gives robots from 1 to the parts that move or leave.
[[nodiscard]] FleetStep fleet_step(const FleetProblem& fleet, FleetState& state,
                                   std::span<const Motion> motions,
                                   std::span<const PlaceIndex> places);

}  // namespace orasp
