#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings.h"
#include "orasp/catalogue.h"
#include "orasp/explain/alternatives.h"
#include "orasp/fleet/fleet_mip.h"
#include "orasp/graph/graph_estimate.h"
#include "orasp/io/mip_file.h"
#include "orasp/io/plan_json.h"
#include "orasp/io/state_policy_json.h"
#include "orasp/learning/graph_policy.h"
#include "orasp/method_options.h"
#include "orasp/mip/mip.h"
#include "outcome.h"
#include "watch.h"

namespace py = pybind11;

namespace orasp::python {
namespace {

std::string hyphened(std::string name) {
  std::ranges::replace(name, '_', '-');
  return name;
}

/// The options of a method from texts by their names in Python, which stand in the sentences.
Options options_called(const std::string& method, const OptionTexts& given) {
  Options options;
  const std::span<const OptionSpec> rows = find_planner(method).options();
  for (const auto& [name, text] : given) {
    const std::string of_table = hyphened(name);
    if (const auto row = std::ranges::find(rows, of_table, &OptionSpec::name); row != rows.end()) {
      set_option(*row, name, text, options);
      continue;
    }
    try {
      options = options_from(method, {{of_table, text}});
    } catch (const InputError& error) {
      std::string sentence = error.what();
      if (const std::size_t place = sentence.find(of_table); place != std::string::npos)
        sentence.replace(place, of_table.size(), name);
      throw InputError(sentence);
    }
  }
  return options;
}

/// What plan_text writes under "options" of a method's own options.
std::map<std::string, std::string> settings_of(const std::string& method,
                                               const OptionTexts& given) {
  std::map<std::string, std::string> settings;
  const Options chosen = options_called(method, given);
  const py::object to_json = py::module_::import("json").attr("dumps");
  for (const OptionSpec& row : find_planner(method).options()) {
    for (const auto& [name, text] : given) {
      if (hyphened(name) != row.name) continue;
      settings[std::string(row.name)] =
          is_bare(row) ? value_of(row, chosen)
                       : to_json(text, py::arg("ensure_ascii") = false).cast<std::string>();
    }
  }
  return settings;
}

/// Refuses to list or count orders where the plan is none, or not the whole of it.
void require_sense_of_other_plans(const Problem& problem, const char* option) {
  if (problem.objective().of_fleet()) {
    throw InputError(
        fmt::format("{} lists plans of one robot, and {} is an objective of several; leave it out",
                    option, problem.objective().type));
  }
  if (problem.uncertain()) {
    throw InputError(fmt::format(
        "{} lists plans for attempts that always succeed, and an attempt at connection \"{}\" may "
        "fail (its success is below 1); leave it out",
        option, problem.connection_id(*problem.first_uncertain())));
  }
}

std::unique_ptr<Outcome> solve_problem(const ProblemPointer& problem, const std::string& method,
                                       const OptionTexts& given,
                                       const std::shared_ptr<const Policy>& policy,
                                       const std::shared_ptr<const GraphPolicy>& graph_policy,
                                       std::uint64_t seed, std::optional<std::size_t> steps,
                                       bool count, std::uint64_t most_alternatives, Run run) {
  Options options = options_called(method, given);
  options.seed = seed;
  options.policy = policy;
  options.graph_policy = graph_policy;
  const char* const other_plans = count                   ? "count"
                                  : most_alternatives > 0 ? "alternatives"
                                                          : nullptr;
  if (other_plans != nullptr) require_sense_of_other_plans(*problem, other_plans);
  auto outcome = std::make_unique<Outcome>(
      Outcome{problem, Situation::whole(problem->num_connections()), steps, {}, {}});
  run.calls_back = calls_python(*problem);
  run_watched(run, true, [&](const Budget& budget) {
    std::optional<TransitionSystem> system;
    if (other_plans != nullptr) {
      system.emplace(*problem);
      if (const auto reason = graph_obstacle(*system, budget))
        throw InputError(std::string(other_plans) + " " + *reason);
    }
    outcome->result = solve(outcome->task(), method, options, budget);
    if (!system) return;
    outcome->alternatives = find_alternatives(*system, count, most_alternatives, budget);
    if (const Stop stop = outcome->alternatives.stop; stop != Stop::None) {
      outcome->result.notes.push_back(fmt::format(
          "{} was {}",
          outcome->alternatives.plans ? "the list of the best plans" : "building H for other plans",
          stop == Stop::Cancelled ? "interrupted"
                                  : fmt::format("stopped by the {}", stop_name(stop))));
    }
  });
  return outcome;
}

/// The integer program of the method mip, for another solver.
py::tuple write_program(const ProblemPointer& problem, const std::string& file,
                        std::optional<std::size_t> steps) {
  require_model_file(file);
  std::optional<MipModel> model;
  Run run;
  run.calls_back = calls_python(*problem);
  run_watched(run, false, [&](const Budget&) {
    if (!problem->objective().of_fleet()) {
      model.emplace(mip_model(TransitionSystem(*problem)));
    } else {
      const FleetProblem fleet(*problem);
      if (fleet.objective() == FleetObjective::Travel && !steps) {
        throw InputError("the integer program of the least travel needs steps=N, the most steps");
      }
      model.emplace(fleet_mip_model(fleet, steps.value_or(fleet_mip_horizon(fleet))));
    }
    write_model(*model, file);
  });
  return py::make_tuple(model->num_columns(), model->num_integers(), model->num_rows(),
                        model->num_terms());
}

const char* kind_of(const OptionSpec& option) {
  struct Name {
    const char* operator()(const FlagOption&) const { return "flag"; }
    const char* operator()(const WholeOption&) const { return "whole"; }
    const char* operator()(const WholeListOption&) const { return "wholes"; }
    const char* operator()(const RealOption&) const { return "real"; }
    const char* operator()(const ChoiceOption&) const { return "choice"; }
    const char* operator()(const FileOption&) const { return "file"; }
  };
  return std::visit(Name{}, option.kind);
}

const char* role_name(Role role) {
  switch (role) {
    case Role::Chooser: return "chooser";
    case Role::Search: return "search";
    case Role::Check: return "check";
    case Role::Baseline: return "baseline";
    case Role::Learner: break;
  }
  return "learner";
}

py::list options_as_tuples(std::span<const OptionSpec> options) {
  py::list rows;
  for (const OptionSpec& option : options) {
    py::list words;
    for (const std::string_view word : words_of(option)) words.append(py::str(word));
    rows.append(py::make_tuple(option.name, kind_of(option), help_of(option),
                               value_of(option, Options()), std::move(words)));
  }
  return rows;
}

py::list methods() {
  py::list rows;
  for (const Planner& planner : planners()) {
    rows.append(py::make_tuple(planner.name, planner.summary, role_name(planner.role),
                               planner.exact, planner.bounds, planner.one_robot, planner.fleets,
                               planner.uncertain, options_as_tuples(planner.options())));
  }
  return rows;
}

py::object expectation_of(const Outcome& outcome) {
  const auto& expectation = outcome.result.expectation;
  if (!expectation) return py::none();
  py::list course;
  for (const auto& [connection, succeeds] : expectation->most_likely)
    course.append(py::make_tuple(outcome.problem->connection_id(connection), succeeds));
  return py::make_tuple(expectation->attempts, expectation->residual, expectation->error,
                        expectation->probability, std::move(course), expectation->policy.size());
}

py::dict statistics_of(const Statistics& statistics) {
  py::dict counts;
  counts["states"] = statistics.states;
  counts["actions"] = statistics.actions;
  counts["expanded"] = statistics.expanded;
  counts["generated"] = statistics.generated;
  counts["reopened"] = statistics.reopened;
  counts["pruned"] = statistics.pruned;
  counts["sweeps"] = statistics.sweeps;
  counts["seconds"] = statistics.seconds;
  counts["peak_bytes"] = statistics.peak_bytes;
  return counts;
}

}  // namespace

void bind_solve(py::module_& module) {
  const auto of_result = [](auto member) {
    return [member](const Outcome& outcome) { return outcome.result.*member; };
  };
  py::class_<Outcome>(module, "Outcome")
      .def_readonly("problem", &Outcome::problem)
      .def_property_readonly("method", of_result(&Result::method))
      .def_property_readonly("reward", of_result(&Result::reward))
      .def_property_readonly("seed", of_result(&Result::seed))
      .def_property_readonly("notes", of_result(&Result::notes))
      .def_property_readonly("steps_allowed", of_result(&Result::steps_allowed))
      .def_property_readonly("status",
                             [](const Outcome& o) { return status_name(o.result.status); })
      .def_property_readonly("stopped",
                             [](const Outcome& o) -> std::optional<std::string_view> {
                               if (o.result.stop == Stop::None) return std::nullopt;
                               return stop_name(o.result.stop);
                             })
      .def_property_readonly("has_plan", [](const Outcome& o) { return o.result.has_plan(); })
      .def_property_readonly("bound", [](const Outcome& o) { return o.result.shown_bound(); })
      .def_property_readonly("sequence",
                             [](const Outcome& o) { return numbers_of(o.result.sequence); })
      .def_property_readonly("statistics",
                             [](const Outcome& o) { return statistics_of(o.result.statistics); })
      .def_property_readonly("expectation", &expectation_of)
      .def_property_readonly("optimal_sequences",
                             [](const Outcome& o) { return o.alternatives.optimal_sequences; })
      .def_property_readonly("values",
                             [](const py::object& self) -> py::object {
                               const auto& values = self.cast<const Outcome&>().result.values;
                               if (values.empty()) return py::none();
                               return view_of(values.data(),
                                              {static_cast<py::ssize_t>(values.size())}, self);
                             })
      .def("text", &Outcome::text, py::call_guard<py::gil_scoped_release>())
      .def(
          "state_policy_text",
          [](const Outcome& o) {
            if (!o.result.expectation)
              throw InputError(
                  "the result has no policy over states: every attempt succeeds, so its plan is "
                  "all there is");
            return state_policy_text(TransitionSystem(*o.problem), o.result);
          },
          py::call_guard<py::gil_scoped_release>());

  module.def("solve", &solve_problem, py::arg("problem"), py::arg("method"), py::arg("options"),
             py::arg("policy"), py::arg("graph_policy"), py::arg("seed"), py::arg("steps"),
             py::arg("count"), py::arg("alternatives"), py::arg("run"));
  module.def("write_model", &write_program);
  module.def("settings_of", &settings_of);
  module.def("methods", &methods);
  module.def("training_options", [] { return options_as_tuples(training_options()); });
  module.def("obstacle", [](const Problem& problem, const std::string& method) {
    return obstacle(problem, method);
  });
}

}  // namespace orasp::python
