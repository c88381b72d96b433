#include <memory>
#include <string>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings.h"
#include "orasp/io/problem_json.h"
#include "orasp/io/problem_source.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/problem.h"

namespace py = pybind11;

namespace orasp::python {

void bind_problem(py::module_& module) {
  py::class_<Problem, std::shared_ptr<Problem>>(module, "Problem")
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
      .def_property_readonly("objective",
                             [](const Problem& problem) { return problem.objective().type; })
      .def_property_readonly("direction",
                             [](const Problem& problem) {
                               return problem.direction() == Direction::Assembly ? "assembly"
                                                                                 : "disassembly";
                             })
      .def_property_readonly("of_fleet",
                             [](const Problem& problem) { return problem.objective().of_fleet(); })
      .def_property_readonly("warnings", &Problem::warnings)
      .def("text", &problem_text)
      .def("digest", &problem_digest);

  module.def("find_problem", [](const std::string& name) {
    return std::make_shared<Problem>(find_problem(name));
  });
  module.def("parse_problem", [](const std::string& text) {
    return std::make_shared<Problem>(parse_problem(text));
  });
}

}  // namespace orasp::python
