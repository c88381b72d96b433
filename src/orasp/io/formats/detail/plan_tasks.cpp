#include "orasp/io/formats/detail/plan_tasks.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace orasp::detail {
namespace {

/// The order of the steps that keeps what each of them cuts. plan_order keeps that where a limit
/// looks at it; one that every step obeys changes nothing else.
std::vector<OrderedPair> order_with_cuts(const WriteRequest& request,
                                         std::vector<std::string>& notes) {
  Limits limits = request.problem.limits();
  if (!limits.max_moved_parts) limits.max_moved_parts = request.problem.num_parts();
  const Problem limited = request.problem.with_limits(limits);
  return step_order({.problem = limited, .plan = request.plan}, notes);
}

/// Of the pairs, which lead from earlier to later tasks, those that follow from no others.
void set_reduced(const std::vector<OrderedPair>& pairs, std::vector<PlanTask>& tasks) {
  std::vector<std::vector<std::size_t>> before(tasks.size());
  for (const auto& [early, late] : pairs) before[late].push_back(early);
  const std::size_t words = (tasks.size() + 63) / 64;
  std::vector<std::vector<std::uint64_t>> ancestors(tasks.size());
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    std::ranges::sort(before[t], std::greater<>());
    std::vector<std::uint64_t>& mine = ancestors[t];
    mine.assign(words, 0);
    for (const std::size_t early : before[t]) {
      if ((mine[early / 64] >> early % 64 & 1U) != 0) continue;
      tasks[t].after.push_back(early);
      for (std::size_t w = 0; w < words; ++w) mine[w] |= ancestors[early][w];
      mine[early / 64] |= std::uint64_t{1} << early % 64;
    }
    std::ranges::reverse(tasks[t].after);
  }
}

}  // namespace

std::vector<OrderedPair> step_order(const WriteRequest& request, std::vector<std::string>& notes) {
  const std::vector<Step>& steps = request.plan->steps;
  if (!TransitionSystem(request.problem).wide()) {
    std::vector<ConnectionIndex> sequence;
    for (const Step& step : steps) sequence.push_back(step.connection);
    return plan_order(request.problem, sequence);
  }
  notes.emplace_back(
      "which steps could change places is not known for goals, steps that take parts off and "
      "costs between steps: each waits for the one before it");
  std::vector<OrderedPair> chain;
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) chain.emplace_back(i, i + 1);
  return chain;
}

std::vector<std::string> PlanTasks::all_notes() const {
  std::vector<std::string> all = order_notes;
  all.insert(all.end(), notes.begin(), notes.end());
  return all;
}

PlanTasks plan_tasks(const WriteRequest& request) {
  const Problem& problem = request.problem;
  const std::vector<Step>& steps = request.plan->steps;
  PlanTasks result;
  const std::vector<OrderedPair> order = order_with_cuts(request, result.order_notes);
  std::vector<std::size_t> task_of(steps.size());
  for (const Operation& operation : operations(steps, problem.direction())) {
    PlanTask task{.steps = operation};
    for (std::size_t i = operation.first; i < operation.end; ++i) {
      task_of[i] = result.tasks.size();
      task.duration += step_duration(problem, steps[i]);
    }
    result.tasks.push_back(std::move(task));
  }
  std::vector<OrderedPair> pairs;
  for (const auto& [early, late] : order) {
    if (task_of[early] != task_of[late]) pairs.emplace_back(task_of[early], task_of[late]);
  }
  set_reduced(pairs, result.tasks);
  if (problem.first_uncertain()) {
    result.notes.emplace_back(
        "attempts may fail, and what to do then is left out: the plan is the one in which none "
        "does");
  }
  return result;
}

StepAct act_of(const Step& step, Direction direction) {
  if (direction == Direction::Disassembly) return step.moves() ? StepAct::TakeOff : StepAct::Loosen;
  return step.moves() ? StepAct::Bring : StepAct::Fasten;
}

std::string_view act_name(StepAct act) {
  switch (act) {
    case StepAct::TakeOff: return "take off";
    case StepAct::Loosen: return "loosen";
    case StepAct::Bring: return "bring";
    case StepAct::Fasten: break;
  }
  return "fasten";
}

std::vector<std::string> connection_ids(const Problem& problem, const Step& step) {
  std::vector<std::string> ids;
  for (const ConnectionIndex c : step.connections) ids.push_back(problem.connection_id(c));
  return ids;
}

std::vector<std::string> moved_ids(const Problem& problem, const Step& step) {
  std::vector<std::string> ids;
  if (!step.moves()) return ids;
  for (const PartIndex part : step.moved()) ids.push_back(problem.part_id(part));
  return ids;
}

double step_duration(const Problem& problem, const Step& step) {
  double duration = 0;
  for (const ConnectionIndex c : step.connections) duration += problem.connections()[c].duration;
  return duration;
}

std::optional<Vector3> motion_of(const Problem& problem, const Step& step) {
  if (!step.direction) return std::nullopt;
  Vector3 motion = problem.direction_vector(*step.direction);
  const double sign = problem.direction() == Direction::Assembly ? -1 : 1;
  for (double& number : motion) number = sign * number + 0.0;
  return motion;
}

}  // namespace orasp::detail
