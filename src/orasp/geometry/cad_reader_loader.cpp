// Finds and loads the modules that read models: the only place that knows of them. No OpenCASCADE
// and no assimp here.

#include "orasp/containers/module_loader.h"
#include "orasp/geometry/cad_reader.h"
#include "orasp/geometry/mesh_reader.h"

namespace orasp {

namespace {

constexpr detail::Module kCadModule = {
    .file = "orasp_occt.so",
    .symbol = "orasp_make_cad_reader_1",
    .method = "import",
    .absent =
        "cannot read STEP files in this build, which was made without OpenCASCADE: `./run import` "
        "installs it, or install the packages libocct-data-exchange-dev and libocct-ocaf-dev and "
        "build again",
    .unloadable = "the module with OpenCASCADE cannot be loaded",
    .packages = "libocct-data-exchange-dev and libocct-ocaf-dev"};

constexpr detail::Module kMeshModule = {
    .file = "orasp_assimp.so",
    .symbol = "orasp_make_mesh_reader_1",
    .method = "import",
    .absent =
        "cannot read meshes in this build, which was made without assimp: `./run import` installs "
        "it, or install the package libassimp-dev and build again",
    .unloadable = "the module with assimp cannot be loaded",
    .packages = "libassimp-dev"};

}  // namespace

std::optional<std::string> cad_reader_obstacle() {
  return detail::module_obstacle(kCadModule);
}

std::unique_ptr<CadReader> make_cad_reader() {
  using Make = CadReader* (*)();
  static const Make make = reinterpret_cast<Make>(detail::load_module(kCadModule));  // stays loaded
  return std::unique_ptr<CadReader>(make());
}

std::optional<std::string> mesh_reader_obstacle() {
  return detail::module_obstacle(kMeshModule);
}

std::unique_ptr<MeshReader> make_mesh_reader() {
  using Make = MeshReader* (*)();
  static const Make make = reinterpret_cast<Make>(detail::load_module(kMeshModule));
  return std::unique_ptr<MeshReader>(make());
}

}  // namespace orasp
