#include "bindings.h"

#include <pybind11/pybind11.h>

#include "orasp/model/error.h"

namespace py = pybind11;

PYBIND11_MODULE(_orasp, module) {
  module.doc() = "The engine behind the package orasp.";
  auto& input_error =
      py::register_exception<orasp::InputError>(module, "InputError", PyExc_ValueError);
  input_error.attr("__module__") = "orasp";
  input_error.attr("__doc__") =
      "Something that was given is wrong. The message is one sentence that names the thing, where "
      "it stands and what was allowed; it is that of the command line.";
  orasp::python::bind_problem(module);
  orasp::python::bind_solve(module);
  orasp::python::bind_environment(module);
}
