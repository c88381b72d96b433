#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace orasp::detail {

/// A module: a shared object of this project that is opened when it is first needed, since the
/// library behind it takes long to load or may be missing.
struct Module {
  /// Its name, such as "orasp_torch.so".
  const char* file;
  /// The C function that makes what the module holds; its number changes with its type.
  const char* symbol;
  /// The method of the catalogue that needs it.
  std::string_view method;
  /// Why the method does not answer where the file is missing: a clause that goes on from its name
  /// and says how to get it.
  std::string_view absent;
  /// How a sentence about a file that cannot be loaded begins.
  std::string_view unloadable;
  /// Debian packages that it needs, for the same sentence.
  std::string_view packages;
};

/// Where the module lies: beside the shared object that holds this library, beside the program, in
/// the folder above, in ../lib/orasp, or where this library was to be installed.
[[nodiscard]] std::optional<std::filesystem::path> module_file(const Module& module);

/// Module::absent where the file is missing; else empty.
[[nodiscard]] std::optional<std::string> module_obstacle(const Module& module);

/// Opens the module, which stays open, and looks its function up.
/// @throws Refusal if it is missing; InputError if it cannot be loaded or is of another version.
[[nodiscard]] void* load_module(const Module& module);

}  // namespace orasp::detail
