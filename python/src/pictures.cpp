#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings.h"
#include "orasp/drawing/figures.h"
#include "orasp/fleet/fleet.h"
#include "orasp/io/fleet_plan_json.h"
#include "orasp/io/plan_json.h"
#include "orasp/planners/reward_statistics.h"
#include "orasp/report/fleet_report.h"
#include "orasp/report/part_shapes.h"
#include "orasp/report/report.h"
#include "outcome.h"
#include "watch.h"

namespace py = pybind11;

namespace orasp::python {
namespace {

std::vector<ConnectionIndex> indices_of(const std::vector<std::uint32_t>& numbers) {
  return {numbers.begin(), numbers.end()};
}

/// A plan of a report: what to call it, a sentence about where it comes from, its text as a plan
/// file, and what else is to be said of it.
struct Shown {
  std::string label;
  std::string origin;
  std::string text;
  std::optional<double> expected;
  std::vector<std::string> notes;
};

ReportPlan plan_of(const Problem& problem, const Shown& shown) {
  ReportPlan plan;
  plan.label = shown.label;
  plan.origin = shown.origin;
  plan.expected = shown.expected;
  plan.notes = shown.notes;
  PlanFile read = parse_plan(shown.text, problem.direction());
  if (problem.spec().action == StepKind::Part) {
    plan.part_steps = plan_steps(problem, read);
  } else {
    plan.sequence = std::move(read.sequence);
    plan.directions = std::move(read.directions);
  }
  return plan;
}

/// What a page shows beside the plans.
struct Page {
  std::string title;
  std::string effort;
  std::vector<std::string> conflict;
  std::string sample_origin;
  std::vector<double> sample;
  std::optional<std::string> shapes;  ///< bytes of a glTF file
  std::string shapes_fault;
};

std::string fleet_page(const Outcome& best, const std::vector<Shown>& plans, const Page& page) {
  const FleetProblem fleet(*best.problem);
  FleetReport report;
  report.title = page.title;
  report.best = best.result;
  report.effort = page.effort;
  for (const Shown& shown : plans)
    report.plans.push_back(
        {shown.label, shown.origin, parse_fleet_plan(shown.text, fleet).plan, shown.notes});
  return report_html(fleet, report);
}

std::string page_text(const Outcome& best, const std::vector<Shown>& plans, const Page& page) {
  const Problem& problem = *best.problem;
  if (problem.objective().of_fleet()) return fleet_page(best, plans, page);
  const TransitionSystem system(problem);
  Report report;
  report.title = page.title;
  report.best = best.result;
  report.effort = page.effort;
  report.conflict = page.conflict;
  report.shapes_fault = page.shapes_fault;
  for (const Shown& shown : plans) report.plans.push_back(plan_of(problem, shown));
  if (!page.sample.empty()) {
    const RewardFigures figures = figures_of(page.sample);
    report.sample = ReportSample{
        .origin = page.sample_origin,
        .rewards = page.sample,
        .mean = figures.mean,
        .deviation = figures.deviation,
        .least = figures.least,
        .quartiles = {figures.percentiles[1], figures.percentiles[2], figures.percentiles[3]},
        .greatest = figures.greatest};
  }
  if (page.shapes) {
    try {
      report.shapes = part_shapes(problem, *page.shapes);
    } catch (const InputError& error) {
      report.shapes_fault = fmt::format("The true parts are not shown: {}.", error.what());
    }
  }
  return report_html(system, report);
}

using PlanTuple = std::tuple<std::string, std::string, std::string, std::optional<double>,
                             std::vector<std::string>>;

std::string report_page(const Outcome& best, const std::vector<PlanTuple>& plans,
                        const std::string& title, const std::string& effort,
                        const std::vector<std::string>& conflict, const std::string& sample_origin,
                        const std::vector<double>& sample, const std::optional<py::bytes>& shapes,
                        const std::string& shapes_fault) {
  std::vector<Shown> shown;
  for (const auto& [label, origin, text, expected, notes] : plans)
    shown.push_back({label, origin, text, expected, notes});
  const Page page{.title = title,
                  .effort = effort,
                  .conflict = conflict,
                  .sample_origin = sample_origin,
                  .sample = sample,
                  .shapes = shapes ? std::optional(std::string(*shapes)) : std::nullopt,
                  .shapes_fault = shapes_fault};
  std::string text;
  Run run;
  run.calls_back = calls_python(*best.problem);
  run_watched(run, false, [&](const Budget&) { text = page_text(best, shown, page); });
  return text;
}

}  // namespace

void bind_pictures(py::module_& module) {
  using Release = py::call_guard<py::gil_scoped_release>;
  module.def("structure_svg", &structure_svg, Release());
  module.def(
      "steps_svg",
      [](const Problem& problem, const std::vector<std::uint32_t>& plan) {
        return steps_svg(TransitionSystem(problem), indices_of(plan));
      },
      Release());
  module.def(
      "tree_svg",
      [](const Problem& problem, const std::vector<std::uint32_t>& path) {
        return tree_svg(TransitionSystem(problem), indices_of(path));
      },
      Release());
  module.def(
      "distribution_svg",
      [](const std::vector<double>& rewards,
         const std::vector<std::tuple<std::string, double>>& marks) {
        std::vector<Mark> all;
        for (const auto& [name, reward] : marks) all.push_back({name, reward, Mark::Kind::Plan});
        return distribution_svg({rewards, all});
      },
      Release());
  module.def("write_figures",
             [](const ProblemPointer& problem, const std::vector<std::uint32_t>& plan,
                const std::vector<double>& sample,
                const std::vector<std::tuple<std::string, double>>& marks,
                const std::string& folder, Run run) {
               const std::vector<ConnectionIndex> sequence = indices_of(plan);
               FigureRequest request{.plan = sequence, .sample = sample, .marks = {}};
               for (const auto& [name, reward] : marks)
                 request.marks.push_back({name, reward, Mark::Kind::Plan});
               std::vector<FigureFile> written;
               run.calls_back = calls_python(*problem);
               run_watched(run, false, [&](const Budget& budget) {
                 written = write_figures(*problem, request, folder, budget);
               });
               py::list names;
               for (const FigureFile& figure : written)
                 names.append(py::make_tuple(figure.name, figure.caption));
               return names;
             });
  module.def("report_page", &report_page, py::arg("best"), py::arg("plans"), py::arg("title"),
             py::arg("effort"), py::arg("conflict"), py::arg("sample_origin"), py::arg("sample"),
             py::arg("shapes"), py::arg("shapes_fault"));
}

}  // namespace orasp::python
