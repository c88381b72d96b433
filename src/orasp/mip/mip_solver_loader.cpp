// Finds and loads the module that holds the solver: the only place that knows of it. No CBC here.

#include <cstdlib>

#include "orasp/containers/module_loader.h"
#include "orasp/mip/mip_solver.h"

namespace orasp {

namespace {

constexpr detail::Module kModule = {
    .file = "orasp_cbc.so",
    .symbol = "orasp_make_mip_solver_1",
    .method = "mip",
    .absent =
        "cannot solve in this build, which was made without CBC: install the package "
        "coinor-libcbc-dev and build again, or write the model with --write-model for "
        "another solver",
    .unloadable = "the module with CBC cannot be loaded",
    .packages = "coinor-libcbc-dev"};

using Make = MipSolver* (*)();

Make load() {
  // Where LAPACK is OpenBLAS, it would start threads that CBC has no use for.
  setenv("OPENBLAS_NUM_THREADS", "1", 0);
  return reinterpret_cast<Make>(detail::load_module(kModule));
}

}  // namespace

std::optional<std::string> mip_solver_obstacle() {
  return detail::module_obstacle(kModule);
}

bool mip_solver_available() {
  return !mip_solver_obstacle();
}

std::unique_ptr<MipSolver> make_mip_solver() {
  static const Make make = load();  // stays loaded
  return std::unique_ptr<MipSolver>(make());
}

}  // namespace orasp
