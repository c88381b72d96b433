#include "orasp/io/formats/task_graph.h"

#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "orasp/io/detail/json_text.h"
#include "orasp/io/formats/detail/plan_tasks.h"
#include "orasp/io/problem_json.h"

namespace orasp {
namespace {

using nlohmann::ordered_json;

/// JSON has names with '_' elsewhere in our formats.
std::string act_word(detail::StepAct act) {
  return act == detail::StepAct::TakeOff ? "take_off" : std::string(detail::act_name(act));
}

ordered_json step_json(const Problem& problem, const Step& step, std::size_t index) {
  return {{"step", index + 1},
          {"act", act_word(detail::act_of(step, problem.direction()))},
          {"connections", detail::connection_ids(problem, step)},
          {"duration", detail::step_duration(problem, step) + 0.0}};
}

ordered_json task_json(const WriteRequest& request, const detail::PlanTask& task,
                       std::size_t index) {
  const Problem& problem = request.problem;
  const std::vector<Step>& steps = request.plan->steps;
  ordered_json json = {{"task", index + 1}};
  json["moved"] = ordered_json::array();
  if (task.steps.moving) {
    const Step& moving = steps[*task.steps.moving];
    json["moved"] = detail::moved_ids(problem, moving);
    if (moving.direction) json["direction"] = problem.direction_name(*moving.direction);
    if (const auto motion = detail::motion_of(problem, moving)) json["motion"] = *motion;
  }
  json["duration"] = task.duration + 0.0;
  ordered_json after = ordered_json::array();
  for (const std::size_t early : task.after) after.push_back(early + 1);
  json["after"] = std::move(after);
  ordered_json list = ordered_json::array();
  for (std::size_t i = task.steps.first; i < task.steps.end; ++i)
    list.push_back(step_json(problem, steps[i], i));
  json["steps"] = std::move(list);
  return json;
}

}  // namespace

Written write_task_graph(const WriteRequest& request) {
  const Problem& problem = request.problem;
  const detail::PlanTasks plan = detail::plan_tasks(request);
  std::string text =
      "{\n  \"format\": \"orasp-task-graph/1\",\n  \"problem\": " +
      detail::inline_text(problem.name()) + ",\n  \"problem_digest\": \"" +
      problem_digest(problem) + "\",\n  \"direction\": \"" +
      (problem.direction() == Direction::Assembly ? "assembly" : "disassembly") +
      "\",\n  \"reward\": " + detail::inline_text(detail::number_or_null(request.plan->reward)) +
      ",\n  \"tasks\": [";
  for (std::size_t t = 0; t < plan.tasks.size(); ++t) {
    text += t == 0 ? "\n    " : ",\n    ";
    text += detail::inline_text(task_json(request, plan.tasks[t], t));
  }
  text += plan.tasks.empty() ? "]\n}\n" : "\n  ]\n}\n";
  return {.text = std::move(text), .notes = plan.all_notes()};
}

}  // namespace orasp
