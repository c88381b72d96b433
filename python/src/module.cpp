#include "bindings.h"
#include "orasp/geometry/cad_reader.h"
#include "orasp/model/error.h"

namespace py = pybind11;

PYBIND11_MODULE(_orasp, module) {
  namespace python = orasp::python;
  module.doc() = "The engine behind the package orasp.";
  module.attr("__version__") = ORASP_VERSION;
  auto& input_error =
      py::register_exception<orasp::InputError>(module, "InputError", PyExc_ValueError);
  input_error.attr("__module__") = "orasp";
  input_error.attr("__doc__") =
      "Something that was given is wrong. The message is one sentence that names the thing, where "
      "it stands and what was allowed; it is that of the command line.";
  python::bind_run(module);
  python::bind_problem(module);
  python::bind_rewards(module);
  python::bind_solve(module);
  python::bind_graph(module);
  python::bind_questions(module);
  python::bind_certificates(module);
  python::bind_replanning(module);
  python::bind_learning(module);
  python::bind_environment(module);
  python::bind_models(module);
  python::bind_formats(module);
  python::bind_pictures(module);
}
