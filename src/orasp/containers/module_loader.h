#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace orasp::detail {

/// A module: a shared object of this project that is opened when it is first needed, since the
/// library behind it takes long to load or may be missing.
struct Module {
  const char* file;  ///< "orasp_torch.so"
  const char*
      /// The C function that makes what the module holds; its number changes with its type.
      symbol;
  std::string_view
      absent;  ///< what to say where the file is missing, a sentence that says how to get it
  std::string_view unloadable;  ///< how a sentence about a file that cannot be loaded begins
  std::string_view packages;    ///< Debian packages that it needs, for the same sentence
};

/// Where the module lies: beside the program, in the folder above, in ../lib/orasp, or where this
/// library was to be installed.
[[nodiscard]] std::optional<std::filesystem::path> module_file(const Module& module);

/// Opens the module, which stays open, and looks its function up.
/// @throws InputError if it is missing, cannot be loaded or is of another version.
[[nodiscard]] void* load_module(const Module& module);

}  // namespace orasp::detail
