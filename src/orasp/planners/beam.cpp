#include "orasp/planners/beam.h"

#include <optional>

#include "orasp/planners/detail/beam_search.h"
#include "orasp/planners/detail/wide_search.h"
#include "orasp/planners/planner_support.h"

namespace orasp {

namespace {

Result searched(const TransitionSystem& system, const BeamOptions& options, const Budget& budget) {
  static_assert(kMaxConnections <= std::size_t{1} << 16);
  if (auto result = detail::infeasible_at_once(system, "beam")) return *result;
  Result result;
  if (options.incumbent != nullptr && options.incumbent->has_plan()) result = *options.incumbent;
  result.method = "beam";
  result.stop = Stop::None;
  result.statistics = {};
  detail::BeamSearch search(system, options, budget, result);
  if (!search.bounded() && options.bound != BoundKind::Best)
    throw Refusal("beam", detail::unknown_bound(system, options.bound));
  if (const auto reason = symmetry_obstacle(system, options.symmetry))
    throw Refusal("beam", *reason);
  search.run();
  if (search.done()) {
    if (result.has_plan()) {
      result.status = Status::Optimal;
      result.bound = result.reward;
    } else {
      result = detail::exhausted("beam", result.statistics);
    }
  } else if (!result.has_plan()) {
    const std::optional<double> most = result.bound;
    result = detail::stopped_with_quick_plan(system, "beam", result.stop, result.statistics);
    result.bound = most;
  }
  if (search.symmetry()) result.notes.push_back(search.symmetry()->text());
  return result;
}

}  // namespace

Result beam(const TransitionSystem& system, const BeamOptions& options, const Budget& budget) {
  if (system.wide()) {
    if (const auto reason = symmetry_obstacle(system, options.symmetry))
      throw Refusal("beam", *reason);
    return detail::wide_beam(system, options.incumbent, budget);
  }
  return detail::from_the_end(system, options,
                              [&](const TransitionSystem& from, const BeamOptions& turned) {
                                return searched(from, turned, budget);
                              });
}

}  // namespace orasp
