#include "orasp/io/formats.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "orasp/io/detail/json_document.h"
#include "orasp/io/detail/json_members.h"
#include "orasp/io/detail/problem_spec_text.h"
#include "orasp/io/formats/behavior_tree.h"
#include "orasp/io/formats/dot.h"
#include "orasp/io/formats/graphml.h"
#include "orasp/io/formats/in2.h"
#include "orasp/io/formats/matrices.h"
#include "orasp/io/formats/mjcf.h"
#include "orasp/io/formats/node_link.h"
#include "orasp/io/formats/pddl.h"
#include "orasp/io/formats/pycaalp.h"
#include "orasp/io/formats/tables.h"
#include "orasp/io/formats/task_graph.h"
#include "orasp/io/problem_json.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"

namespace orasp {
namespace {

using detail::in_quotes;

/// How many comments there are below `value`: notes, sources, keys of other programs.
std::size_t comments_in(detail::JsonValue value) {
  std::size_t count = 0;
  if (!value.is(detail::JsonKind::Object) && !value.is(detail::JsonKind::Array)) return count;
  value.for_each([&](detail::JsonValue member) {
    const bool comment = value.is(detail::JsonKind::Object) && detail::is_comment(member);
    count += comment ? 1 : comments_in(member);
  });
  return count;
}

Converted read_own(std::string_view text) {
  Converted converted{.problem = detail::parse_problem_spec(text)};
  const detail::JsonDocument document = detail::JsonDocument::parse(text);
  const std::size_t kept = static_cast<std::size_t>(!converted.problem.note.empty()) +
                           static_cast<std::size_t>(!converted.problem.source.empty());
  const std::size_t left_out = comments_in(document.root()) - kept;
  if (left_out > 0) {
    converted.notes.push_back(fmt::format(
        "comments are left out ({} note{}, source{} or x- key{} inside of the file)", left_out,
        left_out == 1 ? "" : "s", left_out == 1 ? "" : "s", left_out == 1 ? "" : "s"));
  }
  return converted;
}

Written write_own(const WriteRequest& request) {
  return {.text = problem_text(request.problem)};
}

constexpr auto kFormats = std::to_array<Format>({
    {.name = "orasp",
     .endings = ".json",
     .summary = "a problem file of orasp",
     .limits =
         "notes, sources and x- keys inside of parts, connections and constraints are left out",
     .read = read_own,
     .write = write_own},
    {.name = "graphml",
     .endings = ".graphml",
     .summary = "GraphML: nodes are parts, edges connections",
     .limits = "no nested graphs and no hyperedges; words at nodes are left out; written, it holds "
               "the whole problem",
     .read = read_graphml,
     .write = write_graphml},
    {.name = "node-link",
     .endings = ".json",
     .summary = "node-link JSON of networkx: nodes are parts, links connections",
     .limits = "values that are lists or objects are left out, as are words at nodes",
     .read = read_node_link},
    {.name = "in2",
     .endings = ".in2",
     .summary = "task times and precedence of assembly line balancing",
     .limits = "tasks are connections to one base; stations and cycle times mean nothing",
     .read = read_in2},
    {.name = "pycaalp",
     .endings = ".json",
     .summary = "parts and joints of PyCAALP",
     .limits =
         "degrees of freedom, which stand in another file, and PyCAALP's weights are not read",
     .read = read_pycaalp},
    {.name = "matrices",
     .endings = ".csv",
     .summary = "CSV of a contact matrix and interference matrices",
     .limits = "directions are the six axes; cells are 0 or 1",
     .read = read_matrices},
    {.name = "mjcf",
     .endings = ".xml",
     .summary = "MJCF of MuJoCo: bodies are parts, welds connections",
     .limits = "poses, joints, other constraints and welds to the world are left out; nothing is "
               "included",
     .read = read_mjcf},
    {.name = "parts-csv",
     .endings = ".csv",
     .summary = "CSV, a line for each part",
     .limits = "parts alone",
     .write = write_parts_csv},
    {.name = "connections-csv",
     .endings = ".csv",
     .summary = "CSV, a line for each connection",
     .limits = "connections alone",
     .write = write_connections_csv},
    {.name = "dot",
     .endings = ".dot .gv",
     .summary = "a graph for Graphviz, parts and connections",
     .limits = "masses and durations; all else that a problem says is left out",
     .write = write_dot},
    {.name = "pddl-domain",
     .endings = ".pddl",
     .summary = "PDDL, the domain: an action for each connection",
     .limits = "no limits, blocking, steps that take parts off, or fleets; what steps earn is left "
               "out",
     .write = write_pddl_domain},
    {.name = "pddl-problem",
     .endings = ".pddl",
     .summary = "PDDL, the problem that belongs to that domain",
     .limits = "as pddl-domain",
     .write = write_pddl_problem},
    {.name = "steps-csv",
     .endings = ".csv",
     .summary = "CSV, a line for each step of a plan",
     .limits = "plans of one robot",
     .write = write_steps_csv,
     .of_plan = true},
    {.name = "order-graphml",
     .endings = ".graphml",
     .summary = "GraphML of a plan: which step must come before which",
     .limits = "plans of one robot",
     .write = write_order_graphml,
     .of_plan = true},
    {.name = "order-dot",
     .endings = ".dot .gv",
     .summary = "the same for Graphviz",
     .limits = "plans of one robot",
     .write = write_order_dot,
     .of_plan = true},
    {.name = "behavior-tree",
     .endings = ".xml",
     .summary = "a plan as a behaviour tree (BehaviorTree.CPP 4), step after step",
     .limits = "plans of one robot; what to do after a failure is left out",
     .write = write_behavior_tree,
     .of_plan = true},
    {.name = "behavior-tree-parallel",
     .endings = ".xml",
     .summary = "the same with operations side by side where the order allows it",
     .limits = "as behavior-tree; whether there are hands and room for it is not looked at",
     .write = write_parallel_behavior_tree,
     .of_plan = true},
    {.name = "task-graph",
     .endings = ".json",
     .summary = "a plan as JSON: tasks, what each moves and waits for, durations",
     .limits = "plans of one robot; what to do after a failure is left out",
     .write = write_task_graph,
     .of_plan = true},
});

bool has_ending(const Format& format, std::string_view ending) {
  std::string_view rest = format.endings;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (rest.substr(0, end) == ending) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

/// ".graphml" of "a/b.GraphML"; empty where there is none.
std::string ending_of(std::string_view file) {
  const std::string_view name = file.substr(file.find_last_of('/') + 1);  // npos + 1 is 0
  const std::size_t dot = name.rfind('.');
  std::string ending(dot == std::string_view::npos || dot == 0 ? std::string_view()
                                                               : name.substr(dot));
  std::ranges::transform(ending, ending.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

template <class Wanted>
std::vector<std::string_view> names_where(Wanted&& wanted) {
  std::vector<std::string_view> names;
  for (const Format& format : kFormats)
    if (wanted(format)) names.push_back(format.name);
  return names;
}

/// The name of the outermost element of an XML text, without its prefix; empty where it is none.
std::string_view root_element(std::string_view text) {
  std::size_t at = 0;
  while (true) {
    at = text.find('<', at);
    if (at == std::string_view::npos) return {};
    const std::string_view rest = text.substr(at);
    if (rest.starts_with("<!--")) {
      at = text.find("-->", at);
    } else if (rest.starts_with("<?") || rest.starts_with("<!")) {
      at = text.find('>', at);
    } else {
      const std::string_view name =
          rest.substr(1, std::min(rest.find_first_of(" \t\r\n/>"), rest.size()) - 1);
      return name.substr(name.find(':') + 1);  // npos + 1 is 0
    }
    if (at == std::string_view::npos) return {};
  }
}

/// The keys of the outermost object of a JSON text.
std::vector<std::string> keys_of(std::string_view text) {
  std::vector<std::string> keys;
  const detail::JsonDocument document = detail::JsonDocument::parse(text);
  if (document.root().is(detail::JsonKind::Object))
    document.root().for_each([&](detail::JsonValue member) { keys.emplace_back(member.key()); });
  return keys;
}

/// What a JSON text is, by its keys.
std::optional<std::string_view> json_format(std::string_view text) {
  const std::vector<std::string> keys = keys_of(text);
  const auto has = [&keys](std::string_view key) {
    return std::ranges::find(keys, key) != keys.end();
  };
  if (has("format")) return "orasp";
  if (has("nodes")) return "node-link";
  if (has("joints")) return "pycaalp";
  if (has("connections")) return "orasp";
  return std::nullopt;
}

std::optional<std::string_view> recognised(std::string_view ending, std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  const char begin = first == std::string_view::npos ? '\0' : text[first];
  if (ending == ".graphml") return "graphml";
  if (ending == ".in2") return "in2";
  if (ending == ".csv") return "matrices";
  if (begin == '<' || ending == ".xml") {
    const std::string_view root = root_element(text);
    if (root == "graphml") return "graphml";
    if (root == "mujoco") return "mjcf";
    return std::nullopt;
  }
  if (begin == '{' || ending == ".json") return json_format(text);
  return std::nullopt;
}

Written written_by(const Format& format, const WriteRequest& request) {
  if (format.of_plan && request.problem.objective().of_fleet()) {
    throw InputError(fmt::format("{} takes a plan of one robot, and {} is an objective of several",
                                 format.name, request.problem.objective().type));
  }
  return format.write(request);
}

const Format& format_to_write(std::string_view name) {
  const Format& format = find_format(name);
  if (format.write == nullptr) {
    throw InputError(fmt::format(
        "{} is read, not written; what is written is {}", name,
        detail::listed(names_where([](const Format& row) { return row.write != nullptr; }))));
  }
  return format;
}

}  // namespace

std::span<const Format> formats() {
  return kFormats;
}

const Format& find_format(std::string_view name) {
  const auto* const found = std::ranges::find(kFormats, name, &Format::name);
  if (found != kFormats.end()) return *found;
  const auto names = names_where([](const Format&) { return true; });
  throw InputError(fmt::format("unknown format {}; known: {}{}", in_quotes(name),
                               detail::listed(names), detail::suggestion(name, names)));
}

const Format& format_of_input(std::string_view file, std::string_view text) {
  if (const auto name = recognised(ending_of(file), text)) return find_format(*name);
  const auto names = names_where([](const Format& row) { return row.read != nullptr; });
  throw InputError(
      fmt::format("neither its ending nor what stands in it tells its format; --from says which it "
                  "is: {}",
                  detail::listed(names)));
}

const Format& format_of_output(std::string_view file) {
  if (file == "-") return find_format("orasp");
  const std::string ending = ending_of(file);
  const auto names = names_where([&](const Format& row) {
    return row.write != nullptr && !ending.empty() && has_ending(row, ending);
  });
  // The problem itself, where an ending is that of problems and of plans.
  if (ending == ".json" || ending == ".graphml" || ending == ".dot" || ending == ".gv")
    return find_format(names.front());
  if (names.size() == 1) return find_format(names.front());
  if (names.empty()) {
    throw InputError(fmt::format(
        "the ending of {} tells no format; --to says which to write: {}", in_quotes(file),
        detail::listed(names_where([](const Format& row) { return row.write != nullptr; }))));
  }
  throw InputError(
      fmt::format("the ending of {} is that of several formats; --to says which to "
                  "write: {}",
                  in_quotes(file), detail::listed(names)));
}

Converted read_format(std::string_view text, std::string_view format) {
  const Format& row = find_format(format);
  if (row.read == nullptr) {
    throw InputError(fmt::format(
        "{} is written, not read; what is read is {}", format,
        detail::listed(names_where([](const Format& other) { return other.read != nullptr; }))));
  }
  if (text.size() > detail::kMaxJsonBytes) throw InputError("it is larger than 256 MiB");
  Converted converted = row.read(text);
  const Problem problem(converted.problem);
  converted.notes.insert(converted.notes.end(), problem.warnings().begin(),
                         problem.warnings().end());
  converted.problem = problem.spec();
  return converted;
}

Written write_format(const Problem& problem, std::string_view format) {
  const Format& row = format_to_write(format);
  if (row.of_plan)
    throw InputError(fmt::format("{} is a format of plans, and there is no plan", format));
  return written_by(row, {.problem = problem});
}

Written write_format(const Problem& problem, std::string_view format, const PlanFile& plan) {
  const Format& row = format_to_write(format);
  const Evaluation evaluation = replayed(problem, plan);
  if (!evaluation.valid) {
    const StepViolation& first = evaluation.violations.front();
    throw InputError(
        fmt::format("the plan breaks a rule at step {}: {}", first.step, first.violation.message));
  }
  return written_by(row, {.problem = problem, .plan = &evaluation});
}

}  // namespace orasp
