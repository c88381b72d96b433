#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings.h"
#include "orasp/catalogue.h"
#include "orasp/io/plan_json.h"
#include "orasp/task/memory_limit.h"
#include "watch.h"

namespace py = pybind11;

namespace orasp::python {
namespace {

/// A result with the problem that it answers.
struct Outcome {
  std::shared_ptr<Problem> problem;
  Result result;

  [[nodiscard]] std::string text(const std::map<std::string, std::string>& settings) const {
    return plan_text(*problem, result, settings);
  }
};

Outcome solve_problem(const std::shared_ptr<Problem>& problem, const std::string& method,
                      const OptionTexts& given, std::uint64_t seed) {
  Options options = options_from(method, given);
  options.seed = seed;
  Outcome outcome{problem, {}};
  run_watched({}, {}, true, [&](const Budget& budget) {
    outcome.result = solve(*problem, method, options, budget);
  });
  return outcome;
}

}  // namespace

void bind_solve(py::module_& module) {
  py::class_<Outcome>(module, "Outcome")
      .def_property_readonly("reward", [](const Outcome& o) { return o.result.reward; })
      .def_property_readonly("status", [](const Outcome& o) { return status_name(o.result.status); })
      .def("text", &Outcome::text);
  module.def("solve", &solve_problem);
}

}  // namespace orasp::python
