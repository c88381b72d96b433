#include "cli/paper/paper.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/exit_codes.h"
#include "cli/paper/paper_printed.h"
#include "orasp/drawing/drawing_process.h"
#include "orasp/io/scenarios.h"
#include "orasp/learning/network.h"
#include "orasp/model/error.h"
#include "orasp/model/validate.h"
#include "orasp/planners/random_rewards.h"
#include "orasp/planners/value_iteration.h"

namespace orasp::cli {
namespace {

constexpr std::uint64_t kRandomSequences = 100;
constexpr std::uint64_t kSeed = 1;

double median(std::vector<double> numbers) {
  std::ranges::sort(numbers);
  const std::size_t middle = numbers.size() / 2;
  return numbers.size() % 2 == 1 ? numbers[middle] : (numbers[middle - 1] + numbers[middle]) / 2;
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("model name"))
      return line.substr(std::min(line.find(':') + 2, line.size()));
  }
  return "an unknown processor";
}

/// The paper plans furniture under the reward of its benchmark, everything else for the CubeSat.
std::string_view objective_of(std::string_view problem) {
  return problem == "table-hemnes" ? "completion" : "cubesat";
}

/// `time` with what its method takes; `steps` is a horizon for fleets, or empty. Empty where a run
/// was stopped by a signal.
std::optional<PaperTime> measured(PaperTime time, const std::string& steps,
                                  const std::string& program, std::size_t repeats) {
  std::vector<std::string> words = {"solve",       time.problem,   "--method", time.method,
                                    "--objective", time.objective, "--json",   "--quiet"};
  if (!steps.empty()) words.insert(words.end(), {"--steps", steps});
  std::vector<double> process;
  std::vector<double> solve;
  for (std::size_t i = 0; i < repeats; ++i) {
    const std::optional<ProgramRun> run = run_program(program, words);
    if (run && (run->exit_code == kStopped || run->signal != 0)) return std::nullopt;
    if (!run || run->exit_code != 0) {
      throw std::runtime_error(fmt::format("`orasp {}` failed: {}", fmt::join(words, " "),
                                           run ? run->errors : "it is not there"));
    }
    const nlohmann::json plan = nlohmann::json::parse(run->output);
    process.push_back(run->seconds);
    solve.push_back(plan["statistics"]["seconds"]);
    time.reward = plan["reward"];
    time.status = plan["status"];
  }
  time.least_process = *std::ranges::min_element(process);
  time.process = median(std::move(process));
  time.solve = median(std::move(solve));
  return time;
}

/// H of a problem, kept together with what it refers to.
struct Built {
  Built(Problem from, const Budget& budget)
      : problem(std::move(from)), graph(StateGraph::build(system, budget)) {}
  Problem problem;
  TransitionSystem system{problem};
  StateGraph graph;
};

double best_reward(const StateGraph& graph, const Budget& budget) {
  return value_iteration(graph, {}, budget).reward;
}

/// The least that a plan earns, from the same H with every reward turned round.
double worst_reward(Built& built, const Budget& budget) {
  const Problem turned = built.problem.with_objective(
      {"sum", WeightedSum{{WeightedObjective{-1, built.problem.objective()}}}});
  const TransitionSystem system(turned);
  if (built.graph.reweigh(system, budget) != StateGraph::Reweighed::Done) return 0;
  const double worst = -best_reward(built.graph, budget);
  return built.graph.reweigh(built.system, budget) == StateGraph::Reweighed::Done ? worst : 0;
}

PaperConstraint compared(std::string name, std::string constraint, const Problem& with,
                         const Problem& without, const Budget& budget) {
  const Built bound(with, budget);
  const Built free(without, budget);
  return {.problem = std::move(name),
          .objective = with.objective().type,
          .constraint = std::move(constraint),
          .states = bound.graph.num_states(),
          .actions = bound.graph.num_actions(),
          .best = best_reward(bound.graph, budget),
          .states_without = free.graph.num_states(),
          .actions_without = free.graph.num_actions(),
          .best_without = best_reward(free.graph, budget)};
}

struct Family {
  const char* name;
  std::vector<std::string> problems;
};
std::vector<Family> families() {
  Family chains{"chains", {}};
  Family trees{"trees", {}};
  for (std::size_t n = 2; n <= 20; n += 2) {
    chains.problems.push_back(fmt::format("chain:{}", n + 1));
    trees.problems.push_back(fmt::format("tree:{}:1", n + 2));
  }
  Family grids{"grids", {}};
  for (const char* sides : {"2x2", "2x3", "2x4", "3x3", "2x6", "3x4", "2x7"})
    grids.problems.push_back(fmt::format("grid:{}", sides));
  return {chains, grids, trees};
}

GrowthPoint grown(const Problem& problem, bool with_tree, const Budget& budget) {
  const Built built(problem, budget);
  GrowthPoint point{problem.num_connections(), static_cast<double>(built.graph.num_states()),
                    static_cast<double>(built.graph.num_actions()), 0};
  if (with_tree) point.tree_nodes = std::stod(graph_size(built.graph).tree_nodes);
  return point;
}

PaperDistribution distribution(const std::string& name, const PaperEffort& effort, bool learns,
                               const Budget& budget) {
  const Problem problem = load_scenario(name);
  const TransitionSystem system(problem);
  PaperDistribution row;
  row.problem = name;
  row.parts = problem.num_parts();
  row.connections = problem.num_connections();
  row.rewards = draw_rewards(system, kRandomSequences, kSeed, false, budget).rewards;
  row.figures = figures_of(row.rewards);
  Budget limited = budget;
  limited.set_time_limit(60);
  const Result best = solve(problem, "auto", {}, limited);
  row.best = best.reward;
  row.status = best.status;
  row.bound = best.bound;
  row.greedy = solve(problem, "greedy", {}, budget).reward;
  if (!learns) return row;
  Budget training_budget = budget;
  training_budget.set_time_limit(effort.training_seconds(problem.num_connections()));
  const Training training = train(system, DqnOptions(), training_budget);
  row.episodes = training.record.episodes;
  row.training_seconds = training.record.seconds;
  if (std::isfinite(training.record.greedy)) row.final_reward = training.record.greedy;
  if (training.trained.policy.empty()) return row;
  const Result followed = follow_policy(system, training.trained.policy, budget);
  if (!followed.has_plan()) return row;
  const Evaluation replayed = evaluate(problem, followed.sequence);
  if (!replayed.valid) throw std::logic_error("the learned plan breaks a rule");
  row.learned = replayed.reward;
  return row;
}

// -------------------------------------------------------------------------------------------------
// The pieces, in order

struct Work {
  const PaperEffort& effort;
  const std::string& program;
  const Budget& budget;
  const std::function<void(std::string_view)>& say;
  [[nodiscard]] bool stopped() const { return budget.stop.stop_requested(); }
};

void add_times(Paper& paper, const Work& work) {
  for (const printed::Time& time : printed::kTimes) {
    if (work.stopped()) return;
    std::optional<PaperTime> row = measured({.problem = std::string(time.problem),
                                             .method = std::string(time.method),
                                             .objective = std::string(objective_of(time.problem)),
                                             .printed = time.seconds,
                                             .status = {}},
                                            "", work.program, work.effort.repeats());
    paper.interrupted = !row;
    if (!row) return;
    paper.times.push_back(*std::move(row));
  }
  for (const printed::IlpTime& time : printed::kIlpTimes) {
    if (work.stopped()) return;
    PaperIlpTime row{.problem = std::string(time.problem),
                     .objective = std::string(time.objective),
                     .steps = std::string(time.steps),
                     .printed = time.seconds,
                     .ours = std::nullopt};
    if (!time.fleet.empty()) {
      row.ours = measured({.problem = std::string(time.fleet),
                           .method = "fleet-search",
                           .objective = std::string(time.fleet_objective),
                           .printed = time.seconds,
                           .status = {}},
                          row.steps, work.program, work.effort.repeats());
      paper.interrupted = !row.ours;
      if (!row.ours) return;
    }
    paper.ilp_times.push_back(std::move(row));
  }
}

void add_sizes(Paper& paper, const Work& work) {
  for (const char* name : {"3piece", "4brick", "4piece", "2x3", "lattice", "hubble", "hubble-free",
                           "hubble-upc", "table-hemnes"}) {
    if (work.stopped()) return;
    Built built(load_scenario(name), work.budget);
    PaperSize size{name, graph_size(built.graph), best_reward(built.graph, work.budget), 0};
    size.worst = worst_reward(built, work.budget);
    paper.sizes.push_back(std::move(size));
  }
}

void add_rewards(Paper& paper, const Work& work) {
  for (const char* name : {"3piece", "4brick", "4piece", "2x3", "lattice", "hubble"}) {
    for (const char* objective :
         {"cubesat", "cubesat_zone", "custom", "indexed", "time", "fuel", "completion"}) {
      if (work.stopped()) return;
      const Problem problem = load_scenario(name).with_objective(Objective::named(objective));
      paper.rewards.push_back(
          {name, objective, solve(problem, "value-iteration", {}, work.budget).reward});
    }
  }
}

void add_constraints(Paper& paper, const Work& work) {
  paper.constraints.push_back(compared(std::string(kPaperRing), "2-3 before 1-2",
                                       constrained_ring(), ring_of_paper(), work.budget));
  for (const char* name : {"2x3", "lattice", "hubble"}) {
    if (work.stopped()) return;
    const Problem problem = load_scenario(name);
    paper.constraints.push_back(
        compared(name, "its precedence", problem, without_precedence(problem), work.budget));
  }
}

void add_paths(Paper& paper, const Work& work) {
  // One H; the second objective only gives its actions other rewards.
  const Problem ring = load_scenario(kPaperRing);
  const std::array<std::string, 2> objectives = {"indexed", "time"};
  Built built(ring.with_objective(Objective::named(objectives[0])), work.budget);
  const Problem second = ring.with_objective(Objective::named(objectives[1]));
  const TransitionSystem system(second);
  for (const std::string& objective : objectives) {
    if (objective == objectives[1] &&
        built.graph.reweigh(system, work.budget) != StateGraph::Reweighed::Done)
      return;
    const Result best = value_iteration(built.graph, {}, work.budget);
    paper.paths.push_back({objective, best.reward, best.sequence});
  }
}

void add_growth(Paper& paper, const Work& work) {
  Limits limits;  // section "Reinforcement Learning Methods": M_num and M_size
  limits.max_subassemblies = 4;
  limits.max_moved_parts = 3;
  for (const Family& family : families()) {
    GrowthSeries free{family.name, {}};
    GrowthSeries limited{fmt::format("{}, limits", family.name), {}};
    for (const std::string& name : family.problems) {
      const Problem problem = load_scenario(name);
      if (problem.num_connections() > work.effort.most_connections() || work.stopped()) break;
      free.points.push_back(grown(problem, true, work.budget));
      limited.points.push_back(grown(problem.with_limits(limits), false, work.budget));
    }
    paper.growth.push_back(std::move(free));
    paper.limited_growth.push_back(std::move(limited));
  }
}

void add_distributions(Paper& paper, const Work& work) {
  bool learns = work.effort.learning;
  if (!learns) {
    paper.learning_left_out = "it was not asked for (`--no-learning`)";
  } else if (!network_available()) {
    learns = false;
    paper.learning_left_out = "this build has no libtorch (`./run train` installs it)";
  }
  if (learns) {  // libtorch takes a second to load, which is no training
    DqnOptions once;
    once.episodes = 1;
    const Problem small = load_scenario("3piece");
    static_cast<void>(train(TransitionSystem(small), once, work.budget));
  }
  for (const char* name :
       {"4brick", "2x3", "lattice", "hubble-upc", "iss-upc", "jwst-upc", "table-hemnes"}) {
    if (work.stopped()) return;
    work.say(fmt::format("  {}", name));
    paper.distributions.push_back(distribution(name, work.effort, learns, work.budget));
  }
}

}  // namespace

Problem ring_of_paper() {
  return load_scenario(kPaperRing).with_objective(Objective::named("time"));
}

Problem constrained_ring() {
  ProblemSpec spec = ring_of_paper().spec();
  spec.precedence = {{"1-2", {"2-3"}, {}}};
  return Problem(std::move(spec));
}

Problem without_precedence(const Problem& problem) {
  ProblemSpec spec = problem.spec();
  spec.precedence.clear();
  return Problem(std::move(spec));
}

std::optional<Paper> computed_paper(const PaperEffort& effort, const std::string& program,
                                    const Budget& budget,
                                    const std::function<void(std::string_view)>& say) {
  struct Piece {
    const char* name;
    void (*add)(Paper&, const Work&);
  };
  constexpr std::array<Piece, 7> kPieces = {
      {{"table of runtimes", add_times},
       {"sizes of H, best and worst plans", add_sizes},
       {"other objectives", add_rewards},
       {"constraints", add_constraints},
       {"two objectives, one H", add_paths},
       {"growth of states and actions", add_growth},
       {"random sequences, learned plans, optima", add_distributions}}};
  Paper paper;
  paper.effort = effort;
  paper.processor = processor_name();
  paper.threads = budget.threads;
  std::ifstream("/proc/loadavg") >> paper.load;
  const Work work{effort, program, budget, say};
  for (const Piece& piece : kPieces) {
    say(piece.name);
    piece.add(paper, work);
    if (work.stopped() || paper.interrupted) return std::nullopt;
  }
  return paper;
}

}  // namespace orasp::cli
