// Finds and loads the module that holds the network: the only place that knows of it. No libtorch here.

#include <array>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <system_error>

#include <dlfcn.h>

#include "orasp/learning/network.h"
#include "orasp/model/error.h"

namespace orasp {

namespace {

constexpr const char* kModule = "orasp_torch.so";

std::optional<std::filesystem::path> module_file() {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::filesystem::path folder = program.parent_path();
  const std::array<std::filesystem::path, 4> places = {folder, folder.parent_path(),
                                                       folder.parent_path() / ORASP_MODULE_FOLDER,
                                                       ORASP_INSTALLED_MODULE_FOLDER};
  for (const std::filesystem::path& place : places) {
    if (std::filesystem::is_regular_file(place / kModule, error)) return place / kModule;
  }
  return std::nullopt;
}

using Make = Network* (*)(const NetworkOptions&);

Make load() {
  const std::optional<std::filesystem::path> file = module_file();
  if (!file) {
    throw InputError(
        "dqn is not part of this build, which was made without libtorch: install the packages "
        "libtorch-dev and libopenblas0-pthread and build again");
  }
  setenv("OPENBLAS_NUM_THREADS", "1",
         0);  // read when OpenBLAS is loaded: more threads are slower at these sizes
  void* const module = dlopen(file->c_str(), RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) {
    const char* const reason = dlerror();
    throw InputError(
        "the learning module cannot be loaded: " +
        std::string(reason != nullptr ? reason : file->string()) +
        "; install the packages libtorch-dev and libopenblas0-pthread and build again");
  }
  void* const make = dlsym(module, "orasp_make_network_1");
  if (make == nullptr)
    throw InputError(file->string() + " is not the learning module of this version of orasp");
  return reinterpret_cast<Make>(make);
}

}  // namespace

bool network_available() {
  return module_file().has_value();
}

std::unique_ptr<Network> make_network(const NetworkOptions& options) {
  static const Make make = load();  // stays loaded
  return std::unique_ptr<Network>(make(options));
}

}  // namespace orasp
