#include "orasp/io/formats/dot.h"

#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "orasp/io/detail/dot_text.h"
#include "orasp/io/formats/detail/left_out.h"
#include "orasp/io/formats/detail/plan_tasks.h"
#include "orasp/model/detail/wording.h"

namespace orasp {
namespace {

using detail::dot_string;
using detail::number_text;

std::string head(const char* kind, const Problem& problem) {
  return problem.name().empty() ? fmt::format("{} {{\n", kind)
                                : fmt::format("{} {} {{\n", kind, dot_string(problem.name()));
}

std::string joined(const std::vector<std::string>& ids) {
  return fmt::format("{}", fmt::join(ids, ", "));
}

}  // namespace

Written write_dot(const WriteRequest& request) {
  const Problem& problem = request.problem;
  std::string text = head("graph", problem) + "  node [shape=box];\n";
  for (const Part& part : problem.parts()) {
    text += fmt::format("  {} [label={}, mass={}];\n", dot_string(part.id),
                        dot_string(part.name.empty() ? part.id : part.name),
                        dot_string(number_text(part.mass + 0.0)));
  }
  for (const Connection& connection : problem.connections()) {
    text += fmt::format("  {} -- {} [label={}, duration={}];\n", dot_string(connection.parts[0]),
                        dot_string(connection.parts[1]), dot_string(connection.id),
                        dot_string(number_text(connection.duration + 0.0)));
  }
  Written written{.text = text + "}\n"};
  if (std::string note = detail::left_out_sentence(problem.spec(), {.values = true}); !note.empty())
    written.notes.push_back(std::move(note));
  return written;
}

Written write_order_dot(const WriteRequest& request) {
  const Problem& problem = request.problem;
  const std::vector<Step>& steps = request.plan->steps;
  Written written;
  const std::vector<OrderedPair> order = detail::step_order(request, written.notes);
  written.text = head("digraph", problem) + "  node [shape=box];\n";
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const std::string label =
        fmt::format("{}. {}", i + 1, joined(detail::connection_ids(problem, steps[i])));
    written.text += fmt::format("  \"{}\" [label={}];\n", i + 1, dot_string(label));
  }
  for (const auto& [early, late] : order)
    written.text += fmt::format("  \"{}\" -> \"{}\";\n", early + 1, late + 1);
  written.text += "}\n";
  return written;
}

}  // namespace orasp
