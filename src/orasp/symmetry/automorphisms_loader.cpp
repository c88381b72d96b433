// Finds and loads the module that holds nauty: the only place that knows of it. No nauty here.

#include "orasp/containers/module_loader.h"
#include "orasp/symmetry/automorphisms.h"

namespace orasp {

namespace {

constexpr detail::Module kModule = {
    .file = "orasp_nauty.so",
    .symbol = "orasp_make_automorphism_finder_1",
    .method = "symmetry",
    .absent =
        "cannot look for symmetries in this build, which was made without nauty: install the "
        "package libnauty2-dev and build again, or leave --symmetry out",
    .unloadable = "the module with nauty cannot be loaded",
    .packages = "libnauty2-dev"};

using Make = AutomorphismFinder* (*)();

}  // namespace

std::optional<std::string> automorphism_finder_obstacle() {
  return detail::module_obstacle(kModule);
}

std::unique_ptr<AutomorphismFinder> make_automorphism_finder() {
  static const Make make = reinterpret_cast<Make>(detail::load_module(kModule));  // stays loaded
  return std::unique_ptr<AutomorphismFinder>(make());
}

}  // namespace orasp
