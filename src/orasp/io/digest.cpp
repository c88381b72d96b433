#include "orasp/io/digest.h"

#include <array>
#include <cstdint>

#include <sha256.h>

namespace orasp::detail {

std::string sha256_hex(std::string_view bytes) {
  SHA256_CTX context;
  SHA256_Init(&context);
  SHA256_Update(&context, reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  std::array<char, SHA256_DIGEST_STRING_LENGTH> digits{};
  SHA256_End(&context, digits.data());
  return digits.data();
}

}  // namespace orasp::detail
