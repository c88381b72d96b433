#include "orasp/containers/module_loader.h"

#include <system_error>
#include <vector>

#include <dlfcn.h>

#include "orasp/model/error.h"

namespace orasp::detail {

std::optional<std::filesystem::path> module_file(const Module& module) {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::filesystem::path folder = program.parent_path();
  std::vector<std::filesystem::path> places = {folder, folder.parent_path(),
                                               folder.parent_path() / ORASP_MODULE_FOLDER,
                                               ORASP_INSTALLED_MODULE_FOLDER};
  // This library may stand in a shared object, of which the program knows nothing: Python's, say.
  Dl_info here{};
  if (dladdr(reinterpret_cast<const void*>(&module_file), &here) != 0 && here.dli_fname != nullptr)
    places.insert(places.begin(), std::filesystem::path(here.dli_fname).parent_path());
  for (const std::filesystem::path& place : places) {
    if (std::filesystem::is_regular_file(place / module.file, error)) return place / module.file;
  }
  return std::nullopt;
}

std::optional<std::string> module_obstacle(const Module& module) {
  if (module_file(module)) return std::nullopt;
  return std::string(module.absent);
}

void* load_module(const Module& module) {
  const std::optional<std::filesystem::path> file = module_file(module);
  if (!file) throw Refusal(module.method, std::string(module.absent));
  void* const opened = dlopen(file->c_str(), RTLD_NOW | RTLD_LOCAL);
  if (opened == nullptr) {
    const char* const reason = dlerror();
    throw InputError(std::string(module.unloadable) + ": " +
                     std::string(reason != nullptr ? reason : file->string()) +
                     "; install the packages " + std::string(module.packages) + " and build again");
  }
  void* const symbol = dlsym(opened, module.symbol);
  if (symbol == nullptr)
    throw InputError(file->string() + " is not a module of this version of orasp");
  return symbol;
}

}  // namespace orasp::detail
