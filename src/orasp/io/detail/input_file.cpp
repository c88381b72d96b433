#include "orasp/io/detail/input_file.h"

#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <system_error>

#include "orasp/io/detail/json_document.h"
#include "orasp/model/error.h"

namespace orasp::detail {

std::string input_bytes(const std::filesystem::path& file) {
  const auto reason = [](int error) { return InputError(std::generic_category().message(error)); };
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored))
    throw InputError("it is a directory, not a file");
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"),
                                                               std::fclose);
  if (!stream) throw reason(errno);
  std::string bytes;
  constexpr std::size_t kChunk = std::size_t{1} << 20U;
  const auto size = std::filesystem::file_size(file, ignored);
  if (!ignored && size > kMaxJsonBytes) throw InputError("it is larger than 256 MiB");
  if (!ignored) bytes.reserve(static_cast<std::size_t>(size) + kChunk);
  while (bytes.size() <= kMaxJsonBytes) {
    const std::size_t before = bytes.size();
    bytes.resize(before + kChunk);
    const std::size_t got = std::fread(bytes.data() + before, 1, kChunk, stream.get());
    bytes.resize(before + got);
    if (got == kChunk) continue;
    if (std::ferror(stream.get()) != 0) throw reason(errno);
    return bytes;
  }
  throw InputError("it is larger than 256 MiB");
}

}  // namespace orasp::detail
