#include "orasp/report/report.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <ostream>
#include <span>
#include <string_view>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "orasp/explain/grounds.h"
#include "orasp/graph/graph_estimate.h"
#include "orasp/graph/state_graph.h"
#include "orasp/io/detail/json_text.h"
#include "orasp/model/operations.h"
#include "orasp/model/tolerance.h"
#include "orasp/model/validate.h"
#include "orasp/planners/planner_support.h"
#include "orasp/planners/value_iteration.h"
#include "orasp/report/detail/report_page.h"

namespace orasp {
namespace {

using detail::counted;
using detail::number_or_null;
using detail::page_number;
using nlohmann::ordered_json;

/// H is counted up to this many states, so that the page can say how large it is.
constexpr std::uint64_t kMostCounted = 50'000;
constexpr std::size_t kMostLearningPoints = 1'000;
constexpr std::size_t kDensityPoints = 96;

// -------------------------------------------------------------------------------------------------
// A plan

/// The pieces of the product in the plan's most connected state, a label for each part, and how
/// each removal splits one.
class Pieces {
 public:
  Pieces(const Problem& problem, const ConnectionSet& present)
      : labels_(problem.num_parts()), singles_(0) {
    std::vector<std::vector<PartIndex>> neighbours(problem.num_parts());
    for_each_connection(present.view(), [&](ConnectionIndex c) {
      neighbours[problem.ends(c)[0]].push_back(problem.ends(c)[1]);
      neighbours[problem.ends(c)[1]].push_back(problem.ends(c)[0]);
    });
    std::vector<bool> seen(problem.num_parts());
    for (PartIndex first = 0; first < problem.num_parts(); ++first) {
      if (seen[first]) continue;
      std::vector<PartIndex> members = {first};
      seen[first] = true;
      for (std::size_t i = 0; i < members.size(); ++i) {
        for (const PartIndex other : neighbours[members[i]]) {
          if (seen[other]) continue;
          seen[other] = true;
          members.push_back(other);
        }
      }
      for (const PartIndex part : members) labels_[part] = sizes_.size();
      add(members.size());
    }
    first_labels_ = labels_;
  }

  /// Takes `off` away from its piece; returns the old label and the new one.
  std::pair<std::size_t, std::size_t> split(const std::vector<PartIndex>& off) {
    const std::size_t from = labels_[off.front()];
    const std::size_t to = sizes_.size();
    for (const PartIndex part : off) labels_[part] = to;
    sizes_[from] -= off.size();
    if (sizes_[from] == 1) ++singles_;
    add(off.size());
    return {from, to};
  }
  [[nodiscard]] std::size_t count() const { return sizes_.size(); }
  [[nodiscard]] std::size_t subassemblies() const { return sizes_.size() - singles_; }
  [[nodiscard]] const std::vector<std::size_t>& first_labels() const { return first_labels_; }

 private:
  void add(std::size_t size) {
    sizes_.push_back(size);
    if (size == 1) ++singles_;
  }
  std::vector<std::size_t> labels_;
  std::vector<std::size_t> first_labels_;
  std::vector<std::size_t> sizes_;
  std::size_t singles_;
};

/// The name of the status and a sentence about it.
struct Verdict {
  std::string_view name;
  std::string sentence;
};

Verdict verdict_of(const Problem& problem, const ReportPlan& plan, const Evaluation& evaluation,
                   const Result& best) {
  if (!evaluation.valid)
    return {"not valid", counted(evaluation.violations.size(), "violation") +
                             ": this order breaks the rules, which are named below."};
  if (problem.uncertain() && !plan.expected)
    return {
        "feasible",
        "Attempts may fail, and this is what the order earns if each succeeds; `orasp simulate` "
        "tells what to expect."};
  const double reward = plan.expected.value_or(evaluation.reward);
  const std::optional<double> bound = best.shown_bound();
  const std::string_view what = problem.uncertain() ? "No policy" : "No plan";
  if (bound && detail::meets(reward, *bound))
    return {"optimal",
            fmt::format("Proved optimal: {} earns more than {}.",
                        problem.uncertain() ? "no policy" : "no plan", page_number(reward))};
  if (bound)
    return {
        "feasible",
        fmt::format("Not proved optimal. {} earns more than {}, which is {} more than this one.",
                    what, page_number(*bound), page_number(*bound - reward))};
  return {"feasible", "Not proved optimal, and no bound is known on what another plan could earn."};
}

ordered_json violations_json(const Evaluation& evaluation) {
  ordered_json list = ordered_json::array();
  for (const StepViolation& found : evaluation.violations)
    list.push_back({found.step, found.connection, constraint_name(found.violation.constraint),
                    found.violation.message});
  return list;
}

ordered_json ground_json(const Ground& ground) {
  ordered_json entry = {constraint_name(ground.constraint), ground.where, ground.disassembly};
  if (ground.assembly != ground.disassembly) entry.push_back(ground.assembly);
  return entry;
}

bool by_part(const Problem& problem) {
  return problem.spec().action == StepKind::Part;
}

/// Whether a step that was replayed is the one that the plan has at this place.
bool is_given(const Problem& problem, const ReportPlan& plan, std::size_t place, const Step& step) {
  return by_part(problem) ? plan.part_steps[place].connections == step.connections
                          : plan.sequence[place] == problem.connection_id(step.connection);
}

/// Messages of the rules that a step breaks, by its place in evaluation.steps.
std::vector<std::vector<std::pair<std::string, std::string>>> broken_rules(
    const Problem& problem, const ReportPlan& plan, const Evaluation& evaluation) {
  std::vector<std::vector<std::pair<std::string, std::string>>> broken(evaluation.steps.size());
  const std::size_t length = by_part(problem) ? plan.part_steps.size() : plan.sequence.size();
  std::vector<std::size_t> made(length, evaluation.steps.size());
  for (std::size_t given = 0, step = 0; given < length && step < evaluation.steps.size(); ++given) {
    if (is_given(problem, plan, given, evaluation.steps[step])) made[given] = step++;
  }
  for (const StepViolation& found : evaluation.violations) {
    if (found.step == 0 || found.step > made.size()) continue;
    const std::size_t step = made[found.step - 1];
    if (step < broken.size())
      broken[step].emplace_back(constraint_name(found.violation.constraint),
                                found.violation.message);
  }
  return broken;
}

/// The pieces that `rest` falls into where these connections are there, the first part's first.
std::vector<std::vector<PartIndex>> pieces_of(const Problem& problem,
                                              const std::vector<PartIndex>& rest,
                                              const ConnectionSet& present) {
  const Pieces pieces(problem, present);
  std::map<std::size_t, std::vector<PartIndex>> by_label;
  for (const PartIndex part : rest) by_label[pieces.first_labels()[part]].push_back(part);
  std::vector<std::vector<PartIndex>> found;
  for (auto& [label, parts] : by_label) found.push_back(std::move(parts));
  return found;
}

/// Steps are written in disassembly order, whatever the problem's direction: a removal splits a
/// piece, and the opposite order undoes that.
ordered_json plan_json(const TransitionSystem& system, const ReportPlan& plan, const Result& best) {
  const Problem& problem = system.problem();
  const bool assembly = problem.direction() == Direction::Assembly;
  const Evaluation evaluation = replayed(system, plan);
  const std::vector<Step>& steps = evaluation.steps;
  const std::vector<std::vector<Ground>> why = grounds(system, steps);
  const auto broken = broken_rules(problem, plan, evaluation);
  const std::size_t n = steps.size();

  ConnectionSet open = system.start();
  for (const Step& step : steps) {
    for (const ConnectionIndex c : step.connections) open.erase(c);
  }
  ConnectionSet present = system.present(assembly ? open.view() : system.start().view());
  Pieces pieces(problem, present);
  ordered_json labels = pieces.first_labels();
  ordered_json states = ordered_json::array();
  const auto note_state = [&] { states.push_back({pieces.count(), pieces.subassemblies()}); };
  note_state();

  std::vector<double> total(n);  // in the order of the problem's direction
  std::vector<double> rest(n);   // from the step to the end
  for (std::size_t i = 0; i < n; ++i) total[i] = (i > 0 ? total[i - 1] : 0) + steps[i].reward;
  for (std::size_t i = n; i-- > 0;) rest[i] = (i + 1 < n ? rest[i + 1] : 0) + steps[i].reward;

  ordered_json list = ordered_json::array();
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = assembly ? n - 1 - k : k;
    const Step& step = steps[i];
    for (const ConnectionIndex c : step.connections) present.erase(c);
    ordered_json entry = {by_part(problem) ? ordered_json{"cut", step.connections}
                                           : ordered_json{"c", step.connection},
                          {"reward", number_or_null(step.reward)},
                          {"total", number_or_null(total[i])},
                          {"back", number_or_null(rest[i])}};
    if (step.separates) {
      // Where both sides are fixed neither goes away; the page draws one of them apart.
      const std::vector<PartIndex>& off = step.both_stay ? step.a : step.moved();
      const auto [from, to] = pieces.split(off);
      entry["split"] = {from, to};
      entry["moved"] = off;
      if (by_part(problem)) {
        // What is left may fall apart: its first piece keeps the label, the others get new ones.
        const auto left = pieces_of(problem, step.kept(), present);
        for (std::size_t piece = 1; piece < left.size(); ++piece)
          entry["rest"].push_back({pieces.split(left[piece]).second, left[piece]});
      }
      if (step.direction) {
        entry["way"] = {problem.direction_name(*step.direction),
                        problem.direction_name(opposite(*step.direction)),
                        problem.direction_vector(*step.direction)};
      }
    }
    note_state();
    ordered_json reasons = ordered_json::array();
    for (const Ground& ground : why[i]) reasons.push_back(ground_json(ground));
    entry["why"] = std::move(reasons);
    if (!broken[i].empty()) entry["broken"] = broken[i];
    list.push_back(std::move(entry));
  }

  // [first, end) in the order of the list.
  ordered_json together = ordered_json::array();
  for (const Operation& operation : operations(steps, problem.direction()))
    together.push_back(assembly ? std::pair(n - operation.end, n - operation.first)
                                : std::pair(operation.first, operation.end));
  if (assembly) std::ranges::reverse(together);

  const Verdict verdict = verdict_of(problem, plan, evaluation, best);
  const std::optional<double> bound = best.shown_bound();
  const double reward = plan.expected.value_or(evaluation.reward);
  const bool comparable = evaluation.valid && (plan.expected || !problem.uncertain());
  ordered_json document = {{"label", plan.label},
                           {"origin", plan.origin},
                           {"status", verdict.name},
                           {"verdict", verdict.sentence},
                           {"valid", evaluation.valid},
                           {"reward", number_or_null(reward)},
                           {"expected", plan.expected.has_value()},
                           {"gap", nullptr},
                           {"notes", plan.notes},
                           {"violations", violations_json(evaluation)},
                           {"labels", std::move(labels)},
                           {"states", std::move(states)},
                           {"steps", std::move(list)},
                           {"operations", std::move(together)}};
  if (bound && comparable)
    document["gap"] = number_or_null(detail::meets(reward, *bound) ? 0 : *bound - reward);
  return document;
}

// -------------------------------------------------------------------------------------------------
// H

using WordsKey = std::vector<std::uint64_t>;

WordsKey key_of(SetView state) {
  return {state.begin(), state.end()};
}

ordered_json size_json(const StateGraph& graph) {
  return {graph.num_states(), graph.num_actions()};
}

bool drawable(const StateGraph& graph) {
  return graph.num_states() <= kMaxReportStates && graph.num_actions() <= kMaxReportActions;
}

/// H, if it is small enough to be counted.
std::optional<StateGraph> counted_graph(const TransitionSystem& system) {
  if (system.wide()) return std::nullopt;  // its states are more than what is open
  if (estimate_graph(system).states > 2.0 * static_cast<double>(kMostCounted)) return std::nullopt;
  Budget budget;
  budget.max_expansions = kMostCounted;
  StateGraph graph = StateGraph::build(system, budget);
  if (graph.stop() != Stop::None) return std::nullopt;
  return graph;
}

/// The states that a plan passes, by their numbers in the drawing.
ordered_json path_json(const TransitionSystem& system, const ReportPlan& plan,
                       const std::map<WordsKey, std::size_t>& number) {
  const Problem& problem = system.problem();
  std::unordered_map<std::string_view, ConnectionIndex> by_id;
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c)
    by_id.emplace(problem.connection_id(c), c);
  ConnectionSet open = system.start();
  ordered_json path = ordered_json::array();
  const auto pass = [&] {
    const auto found = number.find(key_of(open.view()));
    if (found == number.end()) return false;
    path.push_back(found->second);
    return true;
  };
  bool known = pass();
  for (const std::string& id : plan.sequence) {
    const auto found = by_id.find(id);
    if (!known || found == by_id.end() || !open.contains(found->second)) break;
    open.erase(found->second);
    known = pass();
  }
  return path;
}

/// The drawing: each node [layer, connections present, kind, best reward to come], kind 0 a state
/// of H, 1 one that a precedence prunes, 2 a dead end; each action [from, to, connection, reward,
/// whether it is pruned].
ordered_json drawing_json(const StateGraph& graph, const StateGraph& drawn, const Report& report) {
  const TransitionSystem& system = drawn.system();
  std::map<WordsKey, StateId> in_graph;
  for (StateId s = 0; s < graph.num_states(); ++s) in_graph.emplace(key_of(graph.state(s)), s);
  const std::vector<double> values = value_iteration(graph, {}, Budget{}).values;

  ordered_json nodes = ordered_json::array();
  ordered_json actions = ordered_json::array();
  std::map<WordsKey, std::size_t> number;
  for (std::size_t layer = 0; layer < drawn.num_layers(); ++layer) {
    for (StateId s = drawn.layer_begin(layer); s < drawn.layer_end(layer); ++s) {
      number.emplace(key_of(drawn.state(s)), s);
      const auto own = in_graph.find(key_of(drawn.state(s)));
      std::vector<ConnectionIndex> present;
      for_each_connection(system.present(drawn.state(s)).view(),
                          [&](ConnectionIndex c) { present.push_back(c); });
      int kind = 1;
      ordered_json value;
      if (own != in_graph.end()) {
        const bool dead = graph.begin(own->second) == graph.end(own->second) &&
                          count(graph.state(own->second)) > 0;
        kind = dead ? 2 : 0;
        if (own->second < values.size()) value = number_or_null(values[own->second]);
      }
      nodes.push_back({layer, std::move(present), kind, std::move(value)});
      for (ActionId a = drawn.begin(s); a < drawn.end(s); ++a) {
        bool pruned = own == in_graph.end();
        if (!pruned) {
          pruned = true;
          for (ActionId other = graph.begin(own->second); other < graph.end(own->second); ++other)
            pruned = pruned && graph.connection(other) != drawn.connection(a);
        }
        actions.push_back({s, drawn.successor(a), drawn.connection(a),
                           number_or_null(drawn.reward(a)), pruned ? 1 : 0});
      }
    }
  }
  ordered_json paths = ordered_json::array();
  for (const ReportPlan& plan : report.plans)
    paths.push_back(path_json(graph.system(), plan, number));
  return {
      {"nodes", std::move(nodes)}, {"actions", std::move(actions)}, {"paths", std::move(paths)}};
}

ordered_json graph_json(const TransitionSystem& system, const Report& report) {
  const std::optional<StateGraph> graph = counted_graph(system);
  if (!graph) return nullptr;
  ordered_json json = {{"size", size_json(*graph)}, {"free", nullptr}, {"drawing", nullptr}};
  const StateGraph* drawn = &*graph;

  ProblemSpec spec = system.problem().spec();
  const bool has_precedence = !spec.precedence.empty();
  spec.precedence.clear();
  const Problem free_problem(std::move(spec));
  const TransitionSystem free_system(free_problem);
  std::optional<StateGraph> free_graph;
  if (has_precedence) {
    free_graph = counted_graph(free_system);
    if (free_graph) json["free"] = size_json(*free_graph);
    if (free_graph && drawable(*free_graph)) drawn = &*free_graph;
  }
  if (drawable(*drawn)) json["drawing"] = drawing_json(*graph, *drawn, report);
  return json;
}

// -------------------------------------------------------------------------------------------------
// Learning and samples

ordered_json learning_json(const std::vector<LearningPoint>& points) {
  if (points.empty()) return nullptr;
  const auto number = [](const std::optional<double>& value) {
    return value ? number_or_null(*value) : ordered_json();
  };
  const std::size_t every = (points.size() + kMostLearningPoints - 1) / kMostLearningPoints;
  ordered_json list = ordered_json::array();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i % every != 0 && i + 1 != points.size()) continue;
    const LearningPoint& point = points[i];
    list.push_back({number_or_null(point.episodes), number(point.greedy), number(point.best_greedy),
                    number(point.best), number(point.bound)});
  }
  return {{"rounds", points.size()}, {"points", std::move(list)}};
}

/// The density of the rewards at even places, as [reward, density], by Gaussian kernels. Reference.
/// Silverman (1986), Density Estimation for Statistics and Data Analysis, p. 48 (the width).
ordered_json density_json(const ReportSample& sample) {
  const auto n = static_cast<double>(sample.rewards.size());
  const double spread =
      std::min(sample.deviation, (sample.quartiles[2] - sample.quartiles[0]) / 1.34);
  double width = 0.9 * (spread > 0 ? spread : sample.deviation) * std::pow(n, -0.2);
  const double scale = std::max({1e-9, std::abs(sample.least), std::abs(sample.greatest)});
  if (!(width > 1e-6 * scale)) width = 1e-2 * scale;  // equal rewards: a narrow bump
  std::map<double, std::size_t> times;                // rewards repeat often
  for (const double reward : sample.rewards) ++times[reward];
  const double begin = sample.least - 3 * width;
  const double end = sample.greatest + 3 * width;
  ordered_json list = ordered_json::array();
  for (std::size_t i = 0; i <= kDensityPoints; ++i) {
    const double x =
        begin + (end - begin) * static_cast<double>(i) / static_cast<double>(kDensityPoints);
    double density = 0;
    for (const auto& [reward, count] : times) {
      const double z = (x - reward) / width;
      density += static_cast<double>(count) * std::exp(-z * z / 2);
    }
    list.push_back({number_or_null(x), density / (n * width * std::sqrt(2 * std::numbers::pi))});
  }
  return list;
}

ordered_json sample_json(const std::optional<ReportSample>& sample) {
  if (!sample || sample->rewards.empty()) return nullptr;
  return {{"origin", sample->origin},
          {"n", sample->rewards.size()},
          {"mean", number_or_null(sample->mean)},
          {"deviation", number_or_null(sample->deviation)},
          {"min", number_or_null(sample->least)},
          {"quartiles", sample->quartiles},
          {"max", number_or_null(sample->greatest)},
          {"density", density_json(*sample)}};
}

ordered_json shapes_json(const Report& report) {
  if (!report.shapes_fault.empty()) return {{"fault", report.shapes_fault}};
  if (!report.shapes) return nullptr;
  const PartShapes& shapes = *report.shapes;
  std::string note = "The parts are drawn with " + counted(shapes.triangles, "triangle");
  if (shapes.triangles < shapes.triangles_read)
    note += ", simplified from " + counted(shapes.triangles_read, "triangle");
  return {{"note", note + "."}};
}

// -------------------------------------------------------------------------------------------------
// What is proved, in words

ordered_json best_json(const Problem& problem, const Report& report) {
  const Result& best = report.best;
  const std::optional<double> bound = best.shown_bound();
  std::string sentence;
  if (best.status == Status::Optimal) {
    sentence = fmt::format("The best reward is {}, proved.", page_number(best.reward));
  } else {
    sentence = bound ? fmt::format(
                           "No plan earns more than {}, proved; the best plan that was "
                           "found earns {}.",
                           page_number(*bound), page_number(best.reward))
                     : std::string("No bound is known on what a plan can earn.");
  }
  const bool expected = problem.uncertain() && best.has_plan();
  return detail::proved_facts(best, std::move(sentence),
                              expected ? " Rewards are expectations, since attempts may fail." : "",
                              report.effort, report.conflict);
}

}  // namespace

Evaluation replayed(const TransitionSystem& system, const ReportPlan& plan) {
  if (by_part(system.problem()))
    return evaluate(system, std::span<const PlanStep>(plan.part_steps));
  return evaluate(system, std::span<const std::string>(plan.sequence), plan.directions);
}

std::string report_data(const TransitionSystem& system, const Report& report) {
  const Problem& problem = system.problem();
  ordered_json plans = ordered_json::array();
  for (const ReportPlan& plan : report.plans) plans.push_back(plan_json(system, plan, report.best));
  const ordered_json document = {{"format", "orasp-report/1"},
                                 {"version", ORASP_VERSION},
                                 {"title", report.title},
                                 {"problem", detail::report_problem(problem)},
                                 {"best", best_json(problem, report)},
                                 {"plans", std::move(plans)},
                                 {"graph", graph_json(system, report)},
                                 {"learning", learning_json(report.learning)},
                                 {"sample", sample_json(report.sample)},
                                 {"shapes", shapes_json(report)}};
  return detail::script_text(document);
}

std::string report_html(const TransitionSystem& system, const Report& report) {
  return detail::report_page(report.title, report_data(system, report),
                             report.shapes || detail::has_positions(system.problem()),
                             report.shapes ? std::string_view(report.shapes->glb) : "");
}

void write_report(std::ostream& out, const TransitionSystem& system, const Report& report) {
  out << report_html(system, report);
}

}  // namespace orasp
