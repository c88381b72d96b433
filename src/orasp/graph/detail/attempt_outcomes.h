#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "orasp/graph/uncertain_graph.h"
#include "orasp/model/tolerance.h"

/// What solving an UncertainGraph once and sweeping over it have in common.
namespace orasp::detail {

/// The parts of Bellman's equation for attempts that may fail. `self` is the state in which the
/// attempt is made.
class AttemptOutcomes {
 public:
  explicit AttemptOutcomes(const UncertainGraph& graph)
      : AttemptOutcomes(graph.system().problem()) {}
  explicit AttemptOutcomes(const Problem& problem) : problem_(problem) {}

  [[nodiscard]] double success(const UncertainGraph::Attempt& attempt) const {
    return problem_.connections()[attempt.connection].success;
  }
  /// Whether each outcome leads to a state whose value is not -infinity, or ends the job.
  template <class Values>
  [[nodiscard]] static bool safe(const UncertainGraph::Attempt& attempt, UncertainGraph::State self,
                                 const Values& values) {
    const UncertainGraph::State failed = attempt.failed;
    return values[attempt.done] != -kInfinity &&
           (failed == UncertainGraph::kJobEnded || failed == self || values[failed] != -kInfinity);
  }
  /// What a failure is worth, given what it is worth to be in a state.
  template <class Values>
  [[nodiscard]] double failure(const UncertainGraph::Attempt& attempt, const Values& values) const {
    if (attempt.failed == UncertainGraph::kJobEnded)
      return *problem_.connections()[attempt.connection].on_failure.abort;
    return attempt.reward + values[attempt.failed];
  }
  /// The plain Bellman operator.
  template <class Values>
  [[nodiscard]] double plain(const UncertainGraph::Attempt& attempt, const Values& values) const {
    const double p = success(attempt);
    const double done = p * (attempt.reward + values[attempt.done]);
    return p == 1 ? done : done + (1 - p) * failure(attempt, values);
  }
  /// The same solved for the state's own value, where a failure leads back to it.
  template <class Values>
  [[nodiscard]] double solved(const UncertainGraph::Attempt& attempt, UncertainGraph::State self,
                              const Values& values) const {
    if (attempt.failed == self) return attempt.reward / success(attempt) + values[attempt.done];
    return plain(attempt, values);
  }
  /// Expected attempts from `self` on, given those of the states after it.
  [[nodiscard]] double attempts(const UncertainGraph::Attempt& attempt, UncertainGraph::State self,
                                const std::vector<double>& after) const {
    const double p = success(attempt);
    if (attempt.failed == self) return 1 / p + after[attempt.done];
    const double rest = attempt.failed == UncertainGraph::kJobEnded ? 0 : after[attempt.failed];
    return 1 + p * after[attempt.done] + (1 - p) * rest;
  }

 private:
  const Problem& problem_;
};

/// The greatest of `worth(attempt)` over the safe attempts of a state, and where it stands.
template <class Worth>
std::pair<double, std::uint32_t> best_of(const UncertainGraph& graph, UncertainGraph::State s,
                                         const std::vector<double>& values, Worth&& worth) {
  double best = -kInfinity;
  std::uint32_t place = UncertainSolution::kNone;
  const std::span<const UncertainGraph::Attempt> attempts = graph.attempts(s);
  for (std::uint32_t i = 0; i < attempts.size(); ++i) {
    if (!AttemptOutcomes::safe(attempts[i], s, values)) continue;
    const double here = worth(attempts[i]);
    if (place != UncertainSolution::kNone && here <= best) continue;
    best = here;
    place = i;
  }
  return {best, place};
}

/// Writes to `next` what is open after an attempt at `connection` in the state `open` has failed
/// and broken what it breaks. @returns whether that changes the state.
inline bool breaks_to(const Problem& problem, ConnectionIndex connection, SetView open,
                      std::vector<std::uint64_t>& next) {
  if (problem.connections()[connection].success >= 1) return false;
  next.assign(open.begin(), open.end());
  bool changes = false;
  for (const ConnectionIndex broken : problem.breaks(connection)) {
    changes = changes || contains(open, broken);
    next[broken / 64] &= ~(std::uint64_t{1} << (broken % 64));
  }
  return changes;
}

inline bool is_goal(const UncertainGraph& graph, UncertainGraph::State s) {
  return count(graph.state(s)) == 0;
}

}  // namespace orasp::detail
