#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/explain/plan_order.h"
#include "orasp/io/formats/conversion.h"
#include "orasp/model/operations.h"

namespace orasp::detail {

/// An operation of a plan (model/operations.h) as something to be done.
struct PlanTask {
  Operation steps{};
  double duration = 0;               ///< s, of all its connections
  std::vector<std::size_t> after{};  ///< the tasks that must be done before, ascending; reduced
};

/// A plan for those who carry it out.
struct PlanTasks {
  std::vector<PlanTask> tasks{};
  std::vector<std::string> notes{};        ///< what the steps do not say
  std::vector<std::string> order_notes{};  ///< what their order does not say

  [[nodiscard]] std::vector<std::string> all_notes() const;
};

/// What of the order of the steps keeps the plan legal (explain/plan_order.h). Where only the
/// plan's own order is known to do so, each step waits for the one before it, and `notes` says so.
[[nodiscard]] std::vector<OrderedPair> step_order(const WriteRequest& request,
                                                  std::vector<std::string>& notes);

/// Every order of the tasks in which each comes after those that it waits for is a legal plan, and
/// each step moves there what it moves in the plan. O(tasks^2 / 64 * pairs kept) for the reduction.
[[nodiscard]] PlanTasks plan_tasks(const WriteRequest& request);

/// "take off" and "loosen" in disassembly, "bring" and "fasten" in assembly.
enum class StepAct { TakeOff, Loosen, Bring, Fasten };
[[nodiscard]] StepAct act_of(const Step& step, Direction direction);
[[nodiscard]] std::string_view act_name(StepAct act);

[[nodiscard]] std::vector<std::string> connection_ids(const Problem& problem, const Step& step);
[[nodiscard]] std::vector<std::string> moved_ids(const Problem& problem, const Step& step);
[[nodiscard]] double step_duration(const Problem& problem, const Step& step);

/// The way in which the moved piece goes, of length 1: that in which it leaves, or, where it is
/// brought, the opposite. Nothing where no direction is known.
[[nodiscard]] std::optional<Vector3> motion_of(const Problem& problem, const Step& step);

}  // namespace orasp::detail
