#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>

#include "orasp/model/problem.h"
#include "orasp/model/situation.h"

namespace orasp {

/// What methods say, after their name, that know states as open connections and steps as one of
/// them (TransitionSystem::wide).
inline constexpr std::string_view kPlainSteps =
    "plans steps that take one connection each until none is left, and earn what they earn "
    "whatever "
    "came before; here a goal, part steps or costs between steps say otherwise";

/// What is asked: a problem, where the work on it stands, and within how many steps. Every method
/// of the catalogue takes a task, whether the objective is that of one robot or of several.
///
///     const Problem problem = load_scenario("hubble");
///     solve(problem, "a-star");                           // the whole job
///     Situation now = Situation::whole(problem.num_connections());
///     now.inaccessible.insert(3);
///     solve(Task(problem, now), "a-star");                // what is left of it
///
/// Refers to the problem, which must outlive the task; cheap to copy but for the situation.
struct Task {
  /// The whole problem. Implicit, so that a problem can be handed to solve() as it is.
  Task(const Problem& whole)  // NOLINT(google-explicit-constructor)
      : problem(whole), situation(Situation::whole(whole.num_connections())) {}
  /// What is left of the problem in the middle of the work.
  Task(const Problem& whole, Situation now) : problem(whole), situation(std::move(now)) {}
  // A problem that goes out of scope at once.
  Task(const Problem&&) = delete;             // NOLINT(google-explicit-constructor)
  Task(const Problem&&, Situation) = delete;  // NOLINT(performance-move-const-arg)

  const Problem& problem;
  Situation situation;
  /// For an objective of several robots: at most so many steps. Empty: as many as it takes for the
  /// makespan, the fewest possible for the travel.
  std::optional<std::size_t> steps = {};

  /// Whether the whole job is asked for, with nothing done and nothing in the way.
  [[nodiscard]] bool whole() const {
    return situation == Situation::whole(problem.num_connections());
  }
};

}  // namespace orasp
