#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bindings.h"
#include "orasp/geometry/assembly_from_cad.h"
#include "orasp/io/import_files.h"
#include "orasp/io/model_files.h"
#include "watch.h"

namespace py = pybind11;

namespace orasp::python {
namespace {

/// What the package asks for; its names are those of import_model.
struct ModelRequest {
  std::vector<std::string> models;
  std::string poses;
  std::optional<double> tolerance;
  std::optional<double> millimetres_per_unit;
  bool solids = false;
  std::optional<double> density;
  std::vector<std::pair<std::string, double>> densities;
  std::string exclude;
  std::string flexible;
  std::string base;
  bool more_directions = false;
  bool by_part = true;
  std::array<double, 3> durations{};
};

std::shared_ptr<ImportedAssembly> imported(const ModelRequest& request, const Run& run) {
  std::shared_ptr<ImportedAssembly> assembly;
  bool interrupted = false;
  run_watched(run, false, [&](const Budget& budget) {
    const CadReadSettings reading{.tolerance = request.tolerance,
                                  .millimetres_per_unit = request.millimetres_per_unit,
                                  .solids = request.solids,
                                  .threads = budget.threads,
                                  .stop = budget.stop,
                                  .progress = budget.progress};
    ImportSettings settings;
    settings.densities = {request.density, request.densities};
    settings.exclude = request.exclude;
    settings.flexible = request.flexible;
    settings.base = request.base;
    settings.directions =
        request.more_directions ? ImportDirections::Geometry : ImportDirections::Axes;
    settings.action = request.by_part ? StepKind::Part : StepKind::Connection;
    settings.durations = request.durations;
    settings.threads = budget.threads;
    settings.stop = budget.stop;
    settings.progress = budget.progress;
    try {
      ModelFiles files;
      files.models.assign(request.models.begin(), request.models.end());
      files.poses = request.poses;
      CadModel model = read_model(files, reading);
      settings.tolerance = model.tolerance;
      assembly = std::make_shared<ImportedAssembly>(assembly_from_cad(std::move(model), settings));
    } catch (const Interrupted&) {
      interrupted = true;
    }
  });
  if (interrupted) throw InputError("the import was interrupted");
  return assembly;
}

}  // namespace

void bind_models(py::module_& module) {
  py::class_<ImportedAssembly, std::shared_ptr<ImportedAssembly>>(module, "ImportedAssembly")
      .def("problem_text", &imported_problem_text)
      .def("shapes", [](const ImportedAssembly& a) { return py::bytes(shapes_glb(a)); })
      .def(
          "write",
          [](const ImportedAssembly& a, const std::string& file) {
            return write_import(a, file).string();
          },
          py::call_guard<py::gil_scoped_release>())
      .def_readonly("questions", &ImportedAssembly::questions)
      .def_readonly("warnings", &ImportedAssembly::warnings)
      .def_property_readonly("parts", [](const ImportedAssembly& a) {
        py::list parts;
        for (const CadPartFacts& part : a.parts) {
          py::dict facts;
          facts["id"] = part.id;
          facts["name"] = part.name;
          facts["mass"] = part.mass;
          facts["density"] = part.density;
          facts["material"] = part.material;
          facts["volume"] = part.volume * 1e-9;
          facts["closed"] = part.closed;
          facts["triangles"] = part.triangles;
          parts.append(std::move(facts));
        }
        return parts;
      });
  module.def(
      "import_model",
      [](std::vector<std::string> models, std::string poses, std::optional<double> tolerance,
         std::optional<double> millimetres_per_unit, bool solids, std::optional<double> density,
         std::vector<std::pair<std::string, double>> densities, std::string exclude,
         std::string flexible, std::string base, bool more_directions, bool by_part,
         std::array<double, 3> durations, const Run& run) {
        return imported({.models = std::move(models),
                         .poses = std::move(poses),
                         .tolerance = tolerance,
                         .millimetres_per_unit = millimetres_per_unit,
                         .solids = solids,
                         .density = density,
                         .densities = std::move(densities),
                         .exclude = std::move(exclude),
                         .flexible = std::move(flexible),
                         .base = std::move(base),
                         .more_directions = more_directions,
                         .by_part = by_part,
                         .durations = durations},
                        run);
      },
      py::arg("models"), py::arg("poses"), py::arg("tolerance"), py::arg("millimetres_per_unit"),
      py::arg("solids"), py::arg("density"), py::arg("densities"), py::arg("exclude"),
      py::arg("flexible"), py::arg("base"), py::arg("more_directions"), py::arg("by_part"),
      py::arg("durations"), py::arg("run"));
}

}  // namespace orasp::python
