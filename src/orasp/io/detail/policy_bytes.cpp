#include "orasp/io/detail/policy_bytes.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "orasp/io/digest.h"
#include "orasp/model/error.h"

namespace orasp::detail {

namespace {

static_assert(std::endian::native == std::endian::little,
              "policy files hold little-endian numbers");

constexpr std::size_t kChecksum = 64;  ///< hex digits at the end

}  // namespace

void append_floats(std::string& bytes, const std::vector<float>& numbers) {
  const std::size_t begin = bytes.size();
  bytes.resize(begin + numbers.size() * sizeof(float));
  if (!numbers.empty())
    std::memcpy(bytes.data() + begin, numbers.data(), numbers.size() * sizeof(float));
}

std::string sealed(std::string bytes) {
  return bytes + sha256_hex(bytes);
}

PolicyBytes opened(std::string_view bytes) {
  const std::size_t line = bytes.find('\n');
  if (line == std::string_view::npos || bytes.size() < line + 1 + kChecksum)
    throw InputError("the policy is damaged: it is cut off");
  const std::string_view body = bytes.substr(0, bytes.size() - kChecksum);
  if (sha256_hex(body) != bytes.substr(body.size()))
    throw InputError("the policy is damaged or cut off: its checksum does not fit");
  return {body.substr(0, line), body.substr(line + 1)};
}

std::vector<float> FloatReader::take(std::size_t count) {
  if (count > bytes_.size() / sizeof(float))
    throw InputError("it holds fewer numbers than its first line says");
  std::vector<float> numbers(count);
  if (count > 0) std::memcpy(numbers.data(), bytes_.data(), count * sizeof(float));
  bytes_.remove_prefix(count * sizeof(float));
  for (const float number : numbers) {
    if (!std::isfinite(number)) throw InputError("it holds a number that is not finite");
  }
  return numbers;
}

void FloatReader::end() const {
  if (!bytes_.empty()) throw InputError("it holds more numbers than its first line says");
}

}  // namespace orasp::detail
