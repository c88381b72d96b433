#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "orasp/model/problem.h"

/// The fleet problem worked out once more, straight from the rules of docs/format.md and from the
/// ids and numbers of the problem alone: states with a place for every part, and every motion of
/// every part.
namespace orasp::fleet_oracle {

inline constexpr double kNever = std::numeric_limits<double>::infinity();

struct State {
  std::vector<bool> open;  ///< of each connection
  std::vector<int> place;  ///< of each part: 0 the depot, else the site
  friend auto operator<=>(const State&, const State&) = default;
};

class World {
 public:
  explicit World(const ProblemSpec& spec);

  [[nodiscard]] std::size_t parts() const { return spec_.parts.size(); }
  [[nodiscard]] std::vector<State> starts() const;
  /// The state after a step with these motions (0 stays, 1 to 6 along +x -x +y -y +z -z) and
  /// places; empty if a rule forbids it.
  [[nodiscard]] std::optional<State> after(const State& before, const std::vector<int>& motion,
                                           const std::vector<int>& place) const;
  /// Every state after one step, with the travel of the step; the least where several steps lead
  /// there.
  [[nodiscard]] std::map<State, double> successors(const State& before) const;
  [[nodiscard]] static bool done(const State& state);

 private:
  [[nodiscard]] std::vector<int> groups(const State& state) const;
  [[nodiscard]] bool well_placed(const State& state) const;
  [[nodiscard]] bool cuttable(std::size_t connection, const std::vector<int>& motion) const;
  [[nodiscard]] bool precedence_met(std::size_t connection, const std::vector<bool>& open) const;
  [[nodiscard]] bool blocked(int part, int other, int direction) const;
  [[nodiscard]] double distance(int from, int to) const;
  [[nodiscard]] int motions() const;

  ProblemSpec spec_;
  std::vector<std::pair<int, int>> ends_;
  std::vector<int> axis_;
};

/// What is true of a problem.
struct Truth {
  std::optional<std::size_t> makespan;  ///< empty: no plan exists
  std::vector<double> travel;  ///< [n]: the least in at most n steps; kNever: no plan of so few
};

/// Looks at `steps` steps for travel, and at as many as it takes for the makespan.
[[nodiscard]] Truth brute_force(const ProblemSpec& spec, std::size_t steps);

/// A small random fleet problem: 1 to 6 parts, on a raster or with random axes, in one piece or
/// several, with every constraint now and then.
[[nodiscard]] ProblemSpec random_fleet(std::uint64_t seed);

/// The same problem, whose robots are to travel as little as they can.
[[nodiscard]] inline Problem for_travel(const Problem& problem) {
  return problem.with_objective(Objective::named("fleet_travel"));
}

}  // namespace orasp::fleet_oracle
