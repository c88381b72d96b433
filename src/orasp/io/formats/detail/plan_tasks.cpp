#include "orasp/io/formats/detail/plan_tasks.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace orasp::detail {
namespace {

/// The order of the steps that keeps the plan legal and what each step moves. In disassembly order
/// (assembly: backwards), for each step t that cuts a piece, with M the side that it moves: (a)
/// every other connection that leaves M comes before t, (b) the steps that cut M further come after
/// it.
/// Proof. The steps that cut are a spanning tree of what hangs together at the start. In any order
/// that keeps the pairs, at the time of t all of the tree inside of M is there by (b), and nothing
/// but t leads out of M by (a): so t takes off M, whole. A connection c that cuts nothing in the
/// plan closes a cycle with a path of the tree. Every step s of the path comes after c: the side
/// that s moves ends, along the path, at an end of c, which leaves it, or at a step of the path
/// that the plan makes before s, which leaves it too and comes after c by induction; by (a) either
/// comes before s. So the path is there when c is taken, and c takes nothing off.
std::vector<OrderedPair> order_with_moves(const WriteRequest& request,
                                          std::vector<std::string>& notes) {
  const Problem& problem = request.problem;
  const std::vector<Step>& steps = request.plan->steps;
  std::vector<OrderedPair> pairs = step_order(request, notes);
  if (TransitionSystem(problem).wide()) return pairs;
  const bool backwards = problem.direction() == Direction::Assembly;
  const auto add = [&](std::size_t early, std::size_t late) {
    pairs.emplace_back(backwards ? late : early, backwards ? early : late);
  };
  std::vector<std::size_t> step_of(problem.num_connections());
  for (std::size_t i = 0; i < steps.size(); ++i) step_of[steps[i].connection] = i;
  std::vector<std::vector<ConnectionIndex>> at_part(problem.num_parts());
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const auto& [first, second] = problem.ends(c);
    if (first == second) continue;
    at_part[first].push_back(c);
    at_part[second].push_back(c);
  }
  std::vector<bool> inside(problem.num_parts(), false);
  for (std::size_t t = 0; t < steps.size(); ++t) {
    if (!steps[t].separates) continue;
    const std::vector<PartIndex>& side = steps[t].both_stay ? steps[t].a : steps[t].moved();
    for (const PartIndex part : side) inside[part] = true;
    for (const PartIndex part : side) {
      for (const ConnectionIndex c : at_part[part]) {
        if (step_of[c] == t) continue;
        const auto& [first, second] = problem.ends(c);
        if (!inside[first] || !inside[second]) {
          add(step_of[c], t);
        } else if (first == part && steps[step_of[c]].separates) {
          add(t, step_of[c]);
        }
      }
    }
    for (const PartIndex part : side) inside[part] = false;
  }
  return pairs;
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
  const std::vector<OrderedPair> order = order_with_moves(request, result.order_notes);
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
