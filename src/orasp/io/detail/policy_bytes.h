#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

/// What the files of policies share: a line of JSON, little-endian floats, and a checksum.
namespace orasp::detail {

/// Appends the numbers as they are in memory.
void append_floats(std::string& bytes, const std::vector<float>& numbers);

/// The bytes with their checksum behind them.
[[nodiscard]] std::string sealed(std::string bytes);

struct PolicyBytes {
  std::string_view line;
  std::string_view numbers;
};
/// The parts of a sealed file. @throws InputError where it is cut off or its checksum does not fit.
[[nodiscard]] PolicyBytes opened(std::string_view bytes);

/// Takes floats off the front of the numbers of a file.
class FloatReader {
 public:
  explicit FloatReader(std::string_view bytes) : bytes_(bytes) {}
  /// @throws InputError where there are fewer, or one is not finite.
  [[nodiscard]] std::vector<float> take(std::size_t count);
  /// @throws InputError where something is left.
  void end() const;

 private:
  std::string_view bytes_;
};

}  // namespace orasp::detail
