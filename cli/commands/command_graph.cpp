#include "cli/commands/command_graph.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/options/command_line.h"
#include "cli/options/shared_options.h"
#include "cli/output/json_output.h"
#include "cli/output/progress.h"
#include "cli/output/text.h"
#include "orasp/drawing/graphviz.h"
#include "orasp/graph/graph_estimate.h"
#include "orasp/graph/graph_size.h"
#include "orasp/graph/state_graph.h"
#include "orasp/io/atomic_file.h"
#include "orasp/planners/value_iteration.h"

namespace orasp::cli {
namespace {

/// Everything that is said about one H.
struct Facts {
  GraphSize size;
  Stop stop = Stop::None;
  bool infeasible = false;
  std::string reason;  ///< why it is infeasible, where that is known without search
  double seconds = 0;
};

/// Every reader of JSON holds whole numbers up to 2^53 exactly; larger ones are written as strings.
nlohmann::ordered_json exact_integer(const std::string& digits) {
  constexpr std::uint64_t kLargest = std::uint64_t{1} << 53;
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || number > kLargest) return digits;
  return number;
}

nlohmann::ordered_json as_json(const Facts& facts) {
  nlohmann::ordered_json layers = nlohmann::ordered_json::array();
  for (const LayerSize& layer : facts.size.layers)
    layers.push_back({{"states", layer.states}, {"actions", layer.actions}});
  nlohmann::ordered_json document = {{"states", facts.size.states},
                                     {"actions", facts.size.actions},
                                     {"layers", std::move(layers)},
                                     {"dead_ends", facts.size.dead_ends},
                                     {"tree_nodes", exact_integer(facts.size.tree_nodes)},
                                     {"sequences", exact_integer(facts.size.sequences)},
                                     {"seconds", facts.seconds}};
  if (facts.stop != Stop::None) {
    for (const char* unknown : {"dead_ends", "tree_nodes", "sequences"})
      document[unknown] = nullptr;
    document["stopped"] = stop_name(facts.stop);
  }
  return document;
}

std::string summary(const Problem& problem, const Facts& facts, const GraphOptions& options,
                    const Context& context) {
  const GraphSize& size = facts.size;
  const bool whole = facts.stop == Stop::None;
  std::string text = fmt::format("{}: {}, {}\n", title(problem, options.problem),
                                 counted(problem.num_parts(), "part"),
                                 counted(problem.num_connections(), "connection"));
  text += fmt::format("graph H   {}, {}", counted(size.states, "state"),
                      counted(size.actions, "action"));
  if (whole) {
    text += ", " + counted(size.dead_ends, "dead end");
    text += fmt::format("\ntree H~   {}, {}", counted(size.tree_nodes, "node"),
                        counted(size.sequences, "complete sequence"));
  } else {
    text += fmt::format(" so far: {}, only whole layers are counted", stop_text(facts.stop));
  }
  text += fmt::format("\neffort    {}\n\n", seconds_text(facts.seconds));

  TextTable table;
  table.add_column("layer", TextTable::Align::Right);
  table.add_column("states", TextTable::Align::Right);
  table.add_column("actions", TextTable::Align::Right);
  for (std::size_t k = 0; k < size.layers.size(); ++k)
    table.add_row(
        {fmt::to_string(k), grouped(size.layers[k].states), grouped(size.layers[k].actions)});
  text += table.text(context.colour());
  if (facts.infeasible) {
    text += "\ninfeasible (proved): no sequence handles every connection\n";
    if (!facts.reason.empty()) text += printable(facts.reason) + '\n';
  }
  return text;
}

/// H with an optimal plan highlighted, where there is one.
std::string drawing(const StateGraph& graph, const Budget& budget) {
  const Result best = value_iteration(graph, {}, budget);
  // A path is known by single connections.
  const bool wide = graph.system().wide();
  return state_graph_dot(graph, wide ? std::vector<ConnectionIndex>{} : best.sequence);
}

void refuse_wrong_outputs(const GraphOptions& options) {
  const std::array to_stdout = {options.json, options.dot == "-", options.svg == "-"};
  if (std::ranges::count(to_stdout, true) > 1)
    throw InputError("only one of --json, --dot - and --svg - can be on standard output");
}

}  // namespace

int run(const GraphOptions& options, const Context& context) {
  refuse_wrong_outputs(options);
  const Problem problem =
      load_one_robot_problem(options.problem, options.changes, context, "graph");
  const TransitionSystem system(problem);

  Facts facts;
  std::string dot;
  std::string svg;
  {
    ProgressLine progress(context, title(problem, options.problem) + ", graph");
    Budget budget = make_budget(options.limits);
    progress.attach_to(budget);
    if (const auto reason = graph_obstacle(system, budget)) throw InputError("graph " + *reason);

    const Stopwatch stopwatch;
    const StateGraph graph = StateGraph::build(system, budget);
    facts.size = graph_size(graph);
    facts.stop = graph.stop();
    facts.seconds = stopwatch.seconds();
    const std::optional<Violation> reason = system.infeasibility();
    facts.infeasible = facts.stop == Stop::None && (reason || !graph.goal());
    if (reason) facts.reason = reason->message;

    const bool draws = !options.dot.empty() || !options.svg.empty();
    if (draws && facts.stop != Stop::None)
      throw InputError(fmt::format("H cannot be drawn: building it was {}", stop_text(facts.stop)));
    if (!options.svg.empty()) require_drawable(graph);
    if (draws) dot = drawing(graph, budget);
  }
  if (!options.svg.empty()) svg = svg_text(dot);

  if (!options.dot.empty() && options.dot != "-") write_file(options.dot, dot);
  if (!options.svg.empty() && options.svg != "-") write_file(options.svg, svg);
  if (options.dot == "-" || options.svg == "-") {
    if (!options.output.empty()) write_file(options.output, json_text(as_json(facts)));
    context.print(options.dot == "-" ? dot : svg);
  } else {
    print_result(context, options.output, options.json, as_json(facts),
                 [&] { return summary(problem, facts, options, context); });
  }
  return facts.stop != Stop::None ? kStopped : facts.infeasible ? kNoPlan : kSolved;
}

CommandWork graph_command(CommandLine& line) {
  const auto chosen = std::make_shared<GraphOptions>();
  GraphOptions& options = *chosen;
  line.about(
      "Builds the state-action graph H and prints its size, layer by layer, and that\n"
      "of the tree H~ that repeats a state for every order that reaches it.");
  line.positional("PROBLEM", options.problem, kProblemHelp);
  line.group("Drawing");
  line.text("--dot", "FILE",
            "Write H in the DOT language, an optimal plan in green; - for standard output "
            "(default: none).",
            options.dot);
  line.text("--svg", "FILE",
            "Draw H with Graphviz, up to 5,000 states; - for standard output (default: none).",
            options.svg);
  add_problem_options(line, options.changes);
  add_limit_options(line, options.limits);
  add_output_options(line, options.json, options.output, "the sizes");
  line.footer(
      "\nExamples:\n"
      "  orasp graph lattice\n"
      "  orasp graph 4piece --svg 4piece.svg\n"
      "  orasp graph 2x3 --dot - | dot -Tpdf -o 2x3.pdf\n"
      "\n"
      "Exit codes: 0 built, 10 proved infeasible, 20 a limit stopped it, 30 wrong input.");
  return [chosen](const Context& context) { return run(*chosen, context); };
}

}  // namespace orasp::cli
