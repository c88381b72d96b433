#pragma once

#include <filesystem>
#include <string>

namespace orasp::detail {

/// The bytes of a file. @throws InputError with the reason, without the name: it cannot be read, is
/// a directory, or is larger than 256 MiB.
[[nodiscard]] std::string input_bytes(const std::filesystem::path& file);

}  // namespace orasp::detail
