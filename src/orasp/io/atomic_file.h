#pragma once

#include <filesystem>
#include <string_view>

namespace orasp {

/// Writes a file so that a reader finds the old bytes or all of the new ones, never a part: into a
/// temporary file in the same directory, forced to the disk, then renamed. A symbolic link stays
/// one and its target is replaced; the mode of a file that is there is kept; a device or a pipe is
/// written to directly.
/// @throws InputError naming the file and the reason; then nothing is left behind.
void write_file(const std::filesystem::path& file, std::string_view bytes);

}  // namespace orasp
