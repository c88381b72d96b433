#include "orasp/model/problem.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings.h"
#include "orasp/io/objective_json.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/problem_source.h"
#include "orasp/io/scenarios.h"
#include "orasp/method_options.h"

namespace py = pybind11;

namespace orasp::python {

bool calls_python(const Problem& problem) {
  return std::holds_alternative<Callable>(problem.objective().parameters);
}

py::list ids_of(const Problem& problem, std::span<const ConnectionIndex> connections) {
  py::list ids;
  for (const ConnectionIndex c : connections) ids.append(problem.connection_id(c));
  return ids;
}

py::array numbers_of(std::span<const ConnectionIndex> connections) {
  return array_of(std::vector<std::int64_t>(connections.begin(), connections.end()));
}

namespace {

Sign sign_called(const std::string& name) {
  if (name == "positive") return Sign::Positive;
  if (name == "not_negative") return Sign::NotNegative;
  return Sign::Any;
}

/// The two parts of each connection, by number, shape [connections, 2].
py::array ends_of(const Problem& problem) {
  py::array_t<std::int64_t> ends(
      {static_cast<py::ssize_t>(problem.num_connections()), py::ssize_t{2}});
  auto entries = ends.mutable_unchecked<2>();
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    for (std::size_t i = 0; i < 2; ++i)
      entries(static_cast<py::ssize_t>(c.value()), static_cast<py::ssize_t>(i)) =
          problem.ends(c)[i];
  }
  return ends;
}

}  // namespace

void bind_problem(py::module_& module) {
  using py::gil_scoped_release;
  py::class_<Problem, ProblemPointer>(module, "Problem")
      .def_property_readonly("name", &Problem::name)
      .def_property_readonly("num_parts", &Problem::num_parts)
      .def_property_readonly("num_connections", &Problem::num_connections)
      .def_property_readonly("part_ids",
                             [](const Problem& problem) {
                               py::list ids;
                               for (const Part& part : problem.parts()) ids.append(part.id);
                               return ids;
                             })
      .def_property_readonly("connection_ids",
                             [](const Problem& problem) {
                               py::list ids;
                               for (const Connection& c : problem.connections()) ids.append(c.id);
                               return ids;
                             })
      .def_property_readonly("ends", &ends_of)
      .def_property_readonly("objective",
                             [](const Problem& problem) { return problem.objective().type; })
      .def_property_readonly("direction",
                             [](const Problem& problem) {
                               return problem.direction() == Direction::Assembly ? "assembly"
                                                                                 : "disassembly";
                             })
      .def_property_readonly("of_fleet",
                             [](const Problem& problem) { return problem.objective().of_fleet(); })
      .def_property_readonly("robots",
                             [](const Problem& problem) {
                               return problem.spec().fleet ? problem.spec().fleet->robots
                                                           : std::size_t{0};
                             })
      .def_property_readonly("geometry",
                             [](const Problem& problem) -> std::optional<std::string> {
                               if (!problem.spec().geometry) return std::nullopt;
                               return problem.spec().geometry->file;
                             })
      .def_property_readonly("uncertain", &Problem::uncertain)
      .def_property_readonly("warnings", &Problem::warnings)
      .def("text", &problem_text, py::call_guard<gil_scoped_release>())
      .def("digest", &problem_digest, py::call_guard<gil_scoped_release>())
      .def(
          "edited",
          [](const Problem& problem, std::optional<Objective> objective,
             const std::optional<std::string>& direction,
             std::optional<std::uint64_t> max_subassemblies,
             std::optional<std::uint64_t> max_moved_parts, std::optional<double> max_moved_mass,
             std::optional<std::uint64_t> robots, std::optional<std::uint64_t> sites) {
            ProblemEdits edits{.objective = std::move(objective),
                               .direction = {},
                               .max_subassemblies = max_subassemblies,
                               .max_moved_parts = max_moved_parts,
                               .max_moved_mass = max_moved_mass,
                               .robots = robots,
                               .sites = sites};
            if (direction) edits.direction = find_direction(*direction);
            return std::make_shared<Problem>(edited(problem, edits));
          },
          py::arg("objective") = std::nullopt, py::arg("direction") = std::nullopt,
          py::arg("max_subassemblies") = std::nullopt, py::arg("max_moved_parts") = std::nullopt,
          py::arg("max_moved_mass") = std::nullopt, py::arg("robots") = std::nullopt,
          py::arg("sites") = std::nullopt, py::call_guard<gil_scoped_release>());

  py::class_<Objective>(module, "Objective")
      .def_readonly("type", &Objective::type)
      .def("text", &objective_text);
  module.def("find_objective", &find_objective, py::call_guard<gil_scoped_release>());
  module.def("parse_objective", &parse_objective, py::call_guard<gil_scoped_release>());

  module.def(
      "find_problem",
      [](const std::string& name) { return std::make_shared<Problem>(find_problem(name)); },
      py::call_guard<gil_scoped_release>());
  module.def("is_scenario", &is_scenario);
  module.def(
      "parse_problem",
      [](const std::string& text) { return std::make_shared<Problem>(parse_problem(text)); },
      py::call_guard<gil_scoped_release>());
  module.def("scenarios", [] {
    py::list list;
    for (const ScenarioInfo& scenario : scenarios())
      list.append(py::make_tuple(scenario.name, scenario.summary, scenario.generator));
    return list;
  });
  module.def("objective_types", [] {
    py::list types;
    for (const std::string_view type : kObjectiveTypes) types.append(py::str(type));
    for (const std::string_view type : kFleetObjectiveTypes) types.append(py::str(type));
    return types;
  });

  // Numbers as the command line reads and writes them, so that sentences and texts are the same.
  module.def("number",
             [](const std::string& label, const std::string& text, const std::string& sign) {
               return number(label, text, sign_called(sign));
             });
  module.def("whole_number",
             [](const std::string& label, const std::string& text, std::uint64_t least,
                std::uint64_t greatest) { return whole_number(label, text, least, greatest); });
  module.def("number_text", [](double value) { return fmt::to_string(value); });
}

}  // namespace orasp::python
