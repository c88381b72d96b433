#include "orasp/io/formats/tables.h"

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "orasp/io/formats/detail/csv_text.h"
#include "orasp/io/formats/detail/left_out.h"
#include "orasp/io/formats/detail/plan_tasks.h"
#include "orasp/io/formats/detail/text_checks.h"
#include "orasp/model/detail/wording.h"

namespace orasp {
namespace {

using detail::csv_line;
using detail::number_text;

void put_point(const std::optional<Vector3>& point, std::vector<std::string>& cells) {
  for (std::size_t i = 0; i < 3; ++i)
    cells.push_back(point ? number_text((*point)[i] + 0.0) : std::string());
}

/// The names of the user's own that any of the things states, in order.
template <class Things, class Own>
std::vector<std::string> names_of(const Things& things, Own&& own) {
  std::set<std::string> names;
  for (const auto& thing : things)
    for (const auto& [name, value] : own(thing)) names.insert(name);
  return {names.begin(), names.end()};
}

void put_numbers(const std::map<std::string, double>& numbers,
                 const std::vector<std::string>& names, std::vector<std::string>& cells) {
  for (const std::string& name : names) {
    const auto found = numbers.find(name);
    cells.push_back(found == numbers.end() ? std::string() : number_text(found->second + 0.0));
  }
}

Written with_note(std::string text, const ProblemSpec& spec, const detail::LeftOut& left_out) {
  Written written{.text = std::move(text)};
  if (std::string note = detail::left_out_sentence(spec, left_out); !note.empty())
    written.notes.push_back(std::move(note));
  return written;
}

}  // namespace

Written write_parts_csv(const WriteRequest& request) {
  const Problem& problem = request.problem;
  const std::vector<std::string> names =
      names_of(problem.parts(), [](const Part& part) { return part.numbers; });
  std::vector<std::string> titles = {"id", "name", "mass", "x", "y", "z", "base"};
  for (const std::string& name : names) titles.push_back("number:" + name);
  std::string text = csv_line(titles);
  for (std::size_t i = 0; i < problem.num_parts(); ++i) {
    const Part& part = problem.parts()[i];
    std::vector<std::string> cells = {part.id, part.name, number_text(part.mass + 0.0)};
    put_point(part.position, cells);
    cells.emplace_back(problem.in_base(static_cast<PartIndex>(i)) ? "1" : "0");
    put_numbers(part.numbers, names, cells);
    text += csv_line(cells);
  }
  Written written = with_note(std::move(text), problem.spec(), {.base = false});
  if (problem.num_connections() > 0)
    written.notes.emplace_back("the connections stand in a table of their own, connections-csv");
  return written;
}

Written write_connections_csv(const WriteRequest& request) {
  const Problem& problem = request.problem;
  const std::vector<Connection>& connections = problem.connections();
  const std::vector<std::string> numbers =
      names_of(connections, [](const Connection& connection) { return connection.numbers; });
  const std::vector<std::string> attributes =
      names_of(connections, [](const Connection& connection) { return connection.attributes; });
  std::vector<std::string> titles = {"id",   "part_a", "part_b", "duration", "success",
                                     "axis", "x",      "y",      "z"};
  for (const std::string& name : numbers) titles.push_back("number:" + name);
  for (const std::string& name : attributes) titles.push_back("attribute:" + name);
  std::string text = csv_line(titles);
  for (const Connection& connection : connections) {
    std::vector<std::string> cells = {connection.id,
                                      connection.parts[0],
                                      connection.parts[1],
                                      number_text(connection.duration + 0.0),
                                      number_text(connection.success),
                                      connection.axis};
    put_point(connection.position, cells);
    put_numbers(connection.numbers, numbers, cells);
    for (const std::string& name : attributes) {
      const auto found = connection.attributes.find(name);
      cells.push_back(found == connection.attributes.end() ? std::string() : found->second);
    }
    text += csv_line(cells);
  }
  Written written = with_note(std::move(text), problem.spec(), {});
  written.notes.emplace_back("the parts stand in a table of their own, parts-csv");
  return written;
}

Written write_steps_csv(const WriteRequest& request) {
  const Problem& problem = request.problem;
  const std::vector<Step>& steps = request.plan->steps;
  const detail::PlanTasks tasks = detail::plan_tasks(request);
  Written written{.text = csv_line({"step", "operation", "act", "connections", "moved", "direction",
                                    "duration", "reward", "total"}),
                  .notes = tasks.notes};
  double total = 0;
  for (std::size_t t = 0; t < tasks.tasks.size(); ++t) {
    for (std::size_t i = tasks.tasks[t].steps.first; i < tasks.tasks[t].steps.end; ++i) {
      const Step& step = steps[i];
      total += step.reward;
      written.text +=
          csv_line({std::to_string(i + 1), std::to_string(t + 1),
                    std::string(detail::act_name(detail::act_of(step, problem.direction()))),
                    detail::joined_ids(detail::connection_ids(problem, step), "steps-csv"),
                    detail::joined_ids(detail::moved_ids(problem, step), "steps-csv"),
                    step.direction ? problem.direction_name(*step.direction) : std::string(),
                    number_text(detail::step_duration(problem, step)),
                    number_text(step.reward + 0.0), number_text(total + 0.0)});
    }
  }
  return written;
}

}  // namespace orasp
