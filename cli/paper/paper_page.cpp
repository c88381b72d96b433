#include "cli/paper/paper_page.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/output/text.h"
#include "cli/paper/paper_printed.h"
#include "orasp/io/scenarios.h"
#include "orasp/planners/value_iteration.h"

namespace orasp::cli {
namespace {

using Cells = std::vector<std::string>;

/// Seconds in a table, without their unit.
std::string seconds_cell(double seconds) {
  std::string text = seconds_text(seconds);
  return text.substr(0, text.find(' '));
}

/// Three digits of a ratio: "0.482", "12.3", "9,860".
std::string ratio_cell(double ratio) {
  if (ratio >= 100) return grouped(static_cast<std::uint64_t>(std::llround(ratio)));
  return fmt::format("{:.{}f}", ratio, ratio >= 10 ? 1 : ratio >= 1 ? 2 : 3);
}

std::string reward_cell(double reward) {
  return fmt::format("{:.4f}", reward == 0 ? 0.0 : reward);
}

template <class Rows>
const auto* row_for(const Rows& rows, std::string_view problem) {
  const auto found =
      std::ranges::find_if(rows, [&](const auto& row) { return row.problem == problem; });
  return found == rows.end() ? nullptr : &*found;
}

/// "4Brick (4, 3)", as the paper writes it, with our numbers.
std::string label_of(std::string_view problem) {
  const Problem loaded = load_scenario(problem);
  return fmt::format("{} ({}, {})", loaded.name(), loaded.num_parts(), loaded.num_connections());
}

struct Graph {
  explicit Graph(Problem from) : problem(std::move(from)) {}
  Problem problem;
  TransitionSystem system{problem};
  StateGraph graph = StateGraph::build(system, {});
  [[nodiscard]] std::vector<ConnectionIndex> plan() const {
    return value_iteration(graph, {}, {}).sequence;
  }
};

void add_introduction(Document& page, const Paper& paper) {
  page.paragraph(
      fmt::format("Everything of Nagpal and Mehr, \"Optimal Robotic Assembly Sequence Planning "
                  "(ORASP)\", that can "
                  "be computed, again, beside what it prints. Made by `orasp paper{}`, orasp {}, "
                  "on {} with {}, at a load of {:.1f} when it began. "
                  "Rewards and sizes are exact and the same on every machine; times are not.",
                  paper.effort.quick ? " --quick" : "", ORASP_VERSION, paper.processor,
                  counted(paper.threads, "thread"), paper.load));
}

void add_times(Document& page, const Paper& paper) {
  page.heading("Runtimes (the paper's Table I)");
  page.paragraph(fmt::format(
      "Seconds. The paper's: Python on an AMD Ryzen 9 5900X, so the ratios compare other hardware "
      "and another language too. Ours: the median of {} runs of the program; whole process from "
      "its start to its end, reading the problem and printing the plan included, solve alone the "
      "method itself. The least is what it takes where nothing else runs. {}",
      paper.effort.repeats(),
      std::ranges::all_of(paper.times,
                          [](const PaperTime& time) { return time.status == "optimal"; })
          ? "Every plan is proved optimal."
          : "Not every plan is proved optimal."));
  std::vector<Cells> rows;
  for (const PaperTime& time : paper.times) {
    rows.push_back({time.problem, time.method, fmt::format("{:.6f}", time.printed),
                    seconds_cell(time.process), seconds_cell(time.least_process),
                    seconds_cell(time.solve), ratio_cell(time.printed / time.process),
                    ratio_cell(time.printed / time.solve), reward_cell(time.reward), time.status});
  }
  page.table({"problem", "method", "paper, s", "whole process, s", "its least, s", "solve alone, s",
              "paper / whole process (other hardware)", "paper / solve alone (other hardware)",
              "reward", "status"},
             std::move(rows));
  page.paragraph(
      "The paper's IKEA Table has 9 parts and 8 connections. Its file was not published and no "
      "product of the furniture collection that it names has these numbers; `table-hemnes` (11, "
      "10) "
      "is a larger table of that collection, under the `completion` objective as in the paper. The "
      "paper's small times are near those of starting a process.");
  std::vector<Cells> ilp;
  for (const PaperIlpTime& time : paper.ilp_times) {
    Cells cells = {time.problem, time.objective, fmt::format("{:g}", time.printed)};
    if (time.ours) {
      const std::string amount = fmt::format("{:g}", 0.0 - time.ours->reward);
      const std::string horizon = time.steps.empty() ? "" : fmt::format(" in {} steps", time.steps);
      cells.insert(
          cells.end(),
          {time.ours->problem,
           time.ours->objective == "makespan" ? amount + " steps" : amount + " m\u00b2" + horizon,
           time.ours->status, seconds_cell(time.ours->process),
           seconds_cell(time.ours->least_process), seconds_cell(time.ours->solve),
           ratio_cell(time.printed / time.ours->process)});
    } else {
      cells.insert(cells.end(), {"no file of it", "", "", "", "", "", ""});
    }
    ilp.push_back(std::move(cells));
  }
  page.paragraph(
      "The paper's column \"State of the Art\": an integer program that plans for several robots "
      "in "
      "synchronous steps, solved by CPLEX on 8 virtual CPUs. Beside it our search on the same "
      "problem (`--method fleet-search`), with the robots, sites and horizon of the published "
      "program. What its least travel adds up is squared distances.");
  page.table(
      {"problem", "objective", "integer program, s", "here", "answer", "status", "whole process, s",
       "its least, s", "solve alone, s", "integer program / whole process (other hardware)"},
      std::move(ilp));
}

void add_structures(Document& page) {
  page.heading("Structures (Figures 1, 2 and 5)");
  std::vector<Cells> rows;
  std::vector<DocumentFigure> small;
  std::vector<DocumentFigure> large;
  for (const printed::Structure& structure : printed::kStructures) {
    const std::string name(structure.problem);
    const Problem problem = load_scenario(name);
    rows.push_back({std::string(structure.label),
                    fmt::format("({}, {})", structure.parts, structure.connections), name,
                    fmt::format("({}, {})", problem.num_parts(), problem.num_connections())});
    const bool is_large = problem.num_connections() > 12;
    std::vector<DocumentFigure>& list = is_large ? large : small;
    list.push_back({fmt::format("structure-{}.svg", name), label_of(name), structure_svg(problem),
                    is_large                        ? 33
                    : problem.num_connections() < 5 ? 15
                                                    : 25});
  }
  page.table({"paper", "paper: parts, connections", "here", "here: parts, connections"},
             std::move(rows));
  page.figures(std::move(small));
  page.figures(std::move(large));
}

void add_sizes(Document& page, const Paper& paper) {
  page.heading("From the tree of all orders to H (Figures 3 and 7)");
  const Graph brick(load_scenario("4brick"));
  page.figures({{"tree-4brick.svg",
                 "4Brick: the tree H~ of all orders; colours are the connections of its structure",
                 tree_svg(brick.system), 32},
                {"graph-4brick.svg", "4Brick: H, in which states that are the same are one",
                 state_graph_svg(brick.graph, {.coloured = true}), 40}});
  page.paragraph(
      "Exact sizes, and the rewards of the best and the worst plan (objective `cubesat`). The "
      "published notebook prints two sizes.");
  std::vector<Cells> rows;
  for (const PaperSize& row : paper.sizes) {
    const auto* const printed = row_for(printed::kSizes, row.problem);
    rows.push_back({row.problem, grouped(row.size.states), grouped(row.size.actions),
                    printed != nullptr ? grouped(printed->states) : "-",
                    printed != nullptr ? grouped(printed->actions) : "-",
                    grouped(row.size.tree_nodes), reward_cell(row.best), reward_cell(row.worst)});
  }
  page.table({"problem", "states", "actions", "notebook: states", "notebook: actions",
              "nodes of the tree", "best", "worst"},
             std::move(rows));
  const Graph forward(load_scenario("4brick").with_direction(Direction::Assembly));
  page.paragraph(
      fmt::format("Figure 7 shows that H is the same for assembly and disassembly: 4Brick has "
                  "{} states and "
                  "{} actions one way, {} and {} the other.",
                  brick.graph.num_states(), brick.graph.num_actions(), forward.graph.num_states(),
                  forward.graph.num_actions()));
  page.figures({{"backward-4brick.svg", "4Brick taken apart: H and the best plan",
                 state_graph_svg(brick.graph, {.path = brick.plan()}), 38},
                {"forward-4brick.svg", "4Brick put together: H and the best plan",
                 state_graph_svg(forward.graph, {.path = forward.plan()}), 38}});
}

void add_constraints(Document& page, const Paper& paper) {
  page.heading("A sequential constraint (Figure 8)");
  const Graph free(ring_of_paper());
  const Graph bound(constrained_ring());
  page.paragraph(fmt::format(
      "Four parts in a ring; connection 2-3 must be removed before 1-2. What the constraint takes "
      "from H is dashed; the best plan, in green, {}.",
      free.plan() == bound.plan() ? "stays" : "is another"));
  page.figures({{"constraint-without.svg", "Without the constraint",
                 state_graph_svg(free.graph, {.path = free.plan()}), 50},
                {"constraint-with.svg", "With it",
                 state_graph_svg(bound.graph, {.path = bound.plan(), .whole = &free.graph}), 50}});
  std::vector<Cells> rows;
  for (const PaperConstraint& row : paper.constraints) {
    rows.push_back({row.problem, row.objective, row.constraint, grouped(row.states_without),
                    grouped(row.actions_without), number_text(row.best_without),
                    grouped(row.states), grouped(row.actions), number_text(row.best)});
  }
  page.table({"problem", "objective", "constraint", "states without", "actions without",
              "best without", "states with", "actions with", "best with"},
             std::move(rows));
}

void add_paths(Document& page, const Paper& paper) {
  page.heading("Two objectives, two paths through one H (Figure 9)");
  page.paragraph(
      "4Piece with rewards that are whole numbers. H is generated once; the second objective only "
      "gives its actions other rewards.");
  const Graph ring(load_scenario(kPaperRing));
  std::vector<DocumentFigure> figures;
  std::vector<Cells> rows;
  for (const PaperPath& path : paper.paths) {
    const Graph weighed(ring.problem.with_objective(Objective::named(path.objective)));
    figures.push_back({fmt::format("path-{}.svg", path.objective),
                       fmt::format("Objective `{}`: the best plan earns {}", path.objective,
                                   number_text(path.reward)),
                       state_graph_svg(weighed.graph, {.path = path.plan}), 50});
    std::string order;
    for (const ConnectionIndex c : path.plan)
      order += (order.empty() ? "" : ", ") + ring.problem.connection_id(c);
    rows.push_back({path.objective, number_text(path.reward), std::move(order)});
  }
  page.figures(std::move(figures));
  page.table({"objective", "reward", "disassembly"}, std::move(rows));
  page.paragraph("The best rewards of the structures under other objectives:");
  Cells head = {"problem"};
  std::vector<Cells> table;
  for (const PaperReward& row : paper.rewards) {
    if (std::ranges::find(head, row.objective) == head.end()) head.push_back(row.objective);
    if (table.empty() || table.back()[0] != row.problem) table.push_back({row.problem});
    table.back().push_back(number_text(row.reward));
  }
  page.table(std::move(head), std::move(table));
}

void add_growth(Document& page, const Paper& paper) {
  page.heading("Growth of states and actions (Figures 4 and 6)");
  page.paragraph(
      "Points are counted, lines are formulas. Where nothing is constrained the shape does not "
      "matter: n connections make 2^n states and n 2^(n-1) actions, and a tree of all orders of "
      "the "
      "sum of n!/k! nodes. With the paper's limits (at most 4 subassemblies, at most 3 parts "
      "moved) "
      "it does.");
  std::vector<GrowthSeries> limited = paper.limited_growth;
  page.figures({{"growth.svg", "Without constraints", growth_svg(paper.growth), 50},
                {"growth-limits.svg", "With the paper's limits", growth_svg(limited), 50}});
  std::vector<Cells> rows;
  for (std::size_t f = 0; f < paper.growth.size(); ++f) {
    const GrowthSeries& free = paper.growth[f];
    for (std::size_t i = 0; i < free.points.size(); ++i) {
      const GrowthPoint& point = free.points[i];
      const GrowthPoint& tight = limited[f].points[i];
      const auto whole = [](double number) { return grouped(static_cast<std::uint64_t>(number)); };
      rows.push_back({free.name, grouped(point.connections), whole(point.states),
                      whole(states_of(point.connections)), whole(point.actions),
                      whole(actions_of(point.connections)), whole(tight.states),
                      whole(tight.actions)});
    }
  }
  page.table({"family", "connections", "states", "2^n", "actions", "n 2^(n-1)",
              "states with limits", "actions with limits"},
             std::move(rows));
  page.paragraph(fmt::format(
      "JWST's 256 connections would make {:.2e} states without limits. The caption of the paper's "
      "Figure 2 speaks of 14 quinvigintillion (1.4e+79) potential subassemblies and does not say "
      "how they are counted.",
      states_of(256)));
}

void add_distributions(Document& page, const Paper& paper) {
  page.heading("Random sequences, learned plans, proved optima (Figures 2 and 10)");
  std::string text =
      "100 sequences drawn step by step, each legal action as likely as any other (seed 1), under "
      "`cubesat`; the `-upc` problems with the paper's limits, at most 4 subassemblies and 3 parts "
      "moved. The optimum is that of `auto`. ";
  if (paper.learning_left_out.empty()) {
    text += fmt::format(
        "A network is trained here by deep Q-learning, without a GPU, for at most {} s (until its "
        "plan is proved optimal). The figures show what it earns by itself at the end of training; "
        "beside that the table has the best that it ever earned, which is what `orasp train` "
        "keeps, from before training on, when it makes the `greedy` plan. The "
        "paper trained 15 minutes for Hubble and ISS and 35 for JWST.",
        paper.effort.quick ? "1 to 2" : "60 to 120");
  } else {
    text += fmt::format("Learned plans are left out: {}.", paper.learning_left_out);
  }
  page.paragraph(std::move(text));
  std::vector<DocumentFigure> figures;
  std::vector<Cells> rows;
  for (const PaperDistribution& row : paper.distributions) {
    const auto* const learned = row_for(printed::kLearned, row.problem);
    std::vector<Mark> marks = {
        {row.status == Status::Optimal ? "optimum, proved" : "best plan, not proved", row.best,
         Mark::Kind::Best}};
    if (row.final_reward)
      marks.push_back({"the network at the end of training", *row.final_reward, Mark::Kind::Plan});
    if (learned != nullptr) {
      marks.push_back({"paper's learned plan, replayed", learned->replayed, Mark::Kind::Other});
    }
    figures.push_back({fmt::format("distribution-{}.svg", row.problem), label_of(row.problem),
                       distribution_svg({row.rewards, marks}), 50});
    rows.push_back({row.problem, reward_cell(row.figures.mean), reward_cell(row.figures.least),
                    reward_cell(row.figures.greatest), reward_cell(row.greedy),
                    row.final_reward ? reward_cell(*row.final_reward) : "-",
                    row.learned ? reward_cell(*row.learned) : "-",
                    row.learned ? grouped(row.episodes) : "-",
                    row.learned ? seconds_cell(row.training_seconds) : "-", reward_cell(row.best),
                    row.status == Status::Optimal ? "proved" : "not proved",
                    learned != nullptr ? fmt::format("{:g}", learned->reported) : "-",
                    learned != nullptr ? fmt::format("{:g}", learned->replayed) : "-"});
  }
  page.figures(std::move(figures));
  page.table({"problem", "random: mean", "random: least", "random: greatest", "greedy",
              "network at the end", "best kept", "episodes", "training, s", "optimum", "proof",
              "paper: learned, reported", "paper: stored plan, replayed"},
             std::move(rows));
  page.paragraph(
      "The plans that were published do not earn what the paper reports when they are replayed; "
      "both numbers stand above. For JWST the best of the stored plans counts.");
}

}  // namespace

Document paper_page(const Paper& paper) {
  Document page("The paper's numbers, computed again");
  add_introduction(page, paper);
  add_times(page, paper);
  add_structures(page);
  add_sizes(page, paper);
  add_constraints(page, paper);
  add_paths(page, paper);
  add_growth(page, paper);
  add_distributions(page, paper);
  return page;
}

nlohmann::ordered_json paper_json(const Paper& paper) {
  using Json = nlohmann::ordered_json;
  const auto number = [](std::optional<double> value) {
    return value && std::isfinite(*value) ? Json(*value) : Json();
  };
  Json document = {{"format", "orasp-paper/1"},        {"version", ORASP_VERSION},
                   {"quick", paper.effort.quick},      {"processor", paper.processor},
                   {"threads", paper.threads},         {"load", paper.load},
                   {"repeats", paper.effort.repeats()}};
  Json& times = document["times"] = Json::array();
  for (const PaperTime& row : paper.times) {
    times.push_back({{"problem", row.problem},
                     {"method", row.method},
                     {"objective", row.objective},
                     {"paper_seconds", row.printed},
                     {"process_seconds", row.process},
                     {"least_process_seconds", row.least_process},
                     {"solve_seconds", row.solve},
                     {"reward", row.reward},
                     {"status", row.status}});
  }
  Json& ilp = document["integer_program"] = Json::array();
  for (const PaperIlpTime& row : paper.ilp_times) {
    Json entry = {
        {"problem", row.problem}, {"objective", row.objective}, {"paper_seconds", row.printed}};
    if (row.ours) {
      entry.update({{"fleet", row.ours->problem},
                    {"fleet_objective", row.ours->objective},
                    {"reward", row.ours->reward},
                    {"status", row.ours->status},
                    {"process_seconds", row.ours->process},
                    {"least_process_seconds", row.ours->least_process},
                    {"solve_seconds", row.ours->solve}});
    }
    ilp.push_back(std::move(entry));
  }
  Json& sizes = document["sizes"] = Json::array();
  for (const PaperSize& row : paper.sizes) {
    const auto* const printed = row_for(printed::kSizes, row.problem);
    sizes.push_back({{"problem", row.problem},
                     {"states", row.size.states},
                     {"actions", row.size.actions},
                     {"paper_states", printed != nullptr ? Json(printed->states) : Json()},
                     {"paper_actions", printed != nullptr ? Json(printed->actions) : Json()},
                     {"tree_nodes", row.size.tree_nodes},
                     {"sequences", row.size.sequences},
                     {"best", row.best},
                     {"worst", row.worst}});
  }
  Json& rewards = document["rewards"] = Json::array();
  for (const PaperReward& row : paper.rewards)
    rewards.push_back(
        {{"problem", row.problem}, {"objective", row.objective}, {"reward", row.reward}});
  Json& constraints = document["constraints"] = Json::array();
  for (const PaperConstraint& row : paper.constraints) {
    constraints.push_back({{"problem", row.problem},
                           {"objective", row.objective},
                           {"constraint", row.constraint},
                           {"states", row.states},
                           {"actions", row.actions},
                           {"best", row.best},
                           {"states_without", row.states_without},
                           {"actions_without", row.actions_without},
                           {"best_without", row.best_without}});
  }
  const Problem ring = load_scenario(kPaperRing);
  Json& paths = document["paths"] = Json::array();
  for (const PaperPath& row : paper.paths) {
    Json plan = Json::array();
    for (const ConnectionIndex c : row.plan) plan.push_back(ring.connection_id(c));
    paths.push_back(
        {{"objective", row.objective}, {"reward", row.reward}, {"disassembly", std::move(plan)}});
  }
  Json& growth = document["growth"] = Json::array();
  for (const auto* const list : {&paper.growth, &paper.limited_growth}) {
    for (const GrowthSeries& series : *list) {
      for (const GrowthPoint& point : series.points) {
        growth.push_back({{"family", series.name},
                          {"connections", point.connections},
                          {"states", point.states},
                          {"actions", point.actions}});
        if (point.tree_nodes > 0) growth.back()["tree_nodes"] = point.tree_nodes;
      }
    }
  }
  Json& distributions = document["distributions"] = Json::array();
  for (const PaperDistribution& row : paper.distributions) {
    const auto* const learned = row_for(printed::kLearned, row.problem);
    distributions.push_back(
        {{"problem", row.problem},
         {"parts", row.parts},
         {"connections", row.connections},
         {"mean", row.figures.mean},
         {"deviation", row.figures.deviation},
         {"min", row.figures.least},
         {"quartiles",
          {row.figures.percentiles[1], row.figures.percentiles[2], row.figures.percentiles[3]}},
         {"max", row.figures.greatest},
         {"greedy", row.greedy},
         {"final", number(row.final_reward)},
         {"learned", number(row.learned)},
         {"episodes", row.episodes},
         {"training_seconds", row.training_seconds},
         {"best", row.best},
         {"status", status_name(row.status)},
         {"bound", number(row.bound)},
         {"paper_reported", learned != nullptr ? Json(learned->reported) : Json()},
         {"paper_replayed", learned != nullptr ? Json(learned->replayed) : Json()},
         {"rewards", row.rewards}});
  }
  if (!paper.learning_left_out.empty()) document["learning_left_out"] = paper.learning_left_out;
  return document;
}

}  // namespace orasp::cli
