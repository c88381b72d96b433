// Finds and loads the module that holds the network: the only place that knows of it. No libtorch
// here.

#include <cstdlib>

#include "orasp/containers/module_loader.h"
#include "orasp/learning/network.h"

namespace orasp {

namespace {

constexpr detail::Module kModule = {
    .file = "orasp_torch.so",
    .symbol = "orasp_make_network_1",
    .method = "dqn",
    .absent =
        "is not part of this build, which was made without libtorch: install the packages "
        "libtorch-dev and libopenblas0-pthread and build again",
    .unloadable = "the learning module cannot be loaded",
    .packages = "libtorch-dev and libopenblas0-pthread"};

using Make = Network* (*)(const NetworkOptions&);

Make load() {
  setenv("OPENBLAS_NUM_THREADS", "1",
         0);  // read when OpenBLAS is loaded: more threads are slower at these sizes
  return reinterpret_cast<Make>(detail::load_module(kModule));
}

}  // namespace

std::optional<std::string> network_obstacle() {
  return detail::module_obstacle(kModule);
}

bool network_available() {
  return !network_obstacle();
}

std::unique_ptr<Network> make_network(const NetworkOptions& options) {
  static const Make make = load();  // stays loaded
  return std::unique_ptr<Network>(make(options));
}

}  // namespace orasp
