#include "orasp/io/formats.h"

#include <memory>
#include <optional>
#include <string>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings.h"
#include "orasp/io/plan_json.h"

namespace py = pybind11;

namespace orasp::python {
namespace {

py::list formats_as_tuples() {
  py::list rows;
  for (const Format& format : formats()) {
    rows.append(py::make_tuple(format.name, format.endings, format.summary, format.limits,
                               format.read != nullptr, format.write != nullptr, format.of_plan));
  }
  return rows;
}

/// The problem of a text, the name of its format, and what was left out.
py::tuple read_text_of(const std::string& text, const std::string& file,
                       const std::optional<std::string>& name) {
  ProblemPointer problem;
  std::string format;
  Converted converted;
  {
    const py::gil_scoped_release released;
    format = name ? find_format(*name).name : format_of_input(file, text).name;
    converted = read_format(text, format);
    problem = std::make_shared<Problem>(converted.problem);
  }
  return py::make_tuple(std::move(problem), format, converted.notes);
}

/// The text of a problem, or of a plan for it, in a format, and what was left out.
py::tuple written_text(const Problem& problem, const std::string& name,
                       const std::optional<std::string>& plan_text) {
  Written written;
  {
    const py::gil_scoped_release released;
    const Format& format = find_format(name);
    if (plan_text) {
      written = write_format(problem, format.name, parse_plan(*plan_text, problem.direction()));
    } else {
      written = write_format(problem, format.name);
    }
  }
  return py::make_tuple(written.text, written.notes);
}

}  // namespace

void bind_formats(py::module_& module) {
  module.def("formats", &formats_as_tuples);
  module.def("read_format", &read_text_of);
  module.def("write_format", &written_text);
  module.def("format_of_output",
             [](const std::string& file) { return format_of_output(file).name; });
}

}  // namespace orasp::python
