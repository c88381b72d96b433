#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "orasp/model/error.h"

/// What the fuzz targets share. A target is one file with the function that driver.cpp calls with
/// the bytes of an input; it has libFuzzer's name and signature. It hands the bytes to a reader of
/// the library and checks what must hold for any bytes at all.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace orasp::fuzz {

/// Ends the process with a message where a property does not hold, as a sanitizer does.
inline void require(bool holds, std::string_view property) {
  if (holds) return;
  std::fprintf(stderr, "fuzz: the property does not hold: %.*s\n",
               static_cast<int>(property.size()), property.data());
  std::abort();
}

/// Whether a message may be shown to a user as it is: one line that is not empty, not endless,
/// holds no control characters and does not end in the middle of nothing.
inline bool is_one_sentence(std::string_view message) {
  constexpr std::size_t kLongest = 20'000;
  if (message.empty() || message.size() > kLongest) return false;
  for (const char c : message) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) return false;
  }
  return message.front() != ' ' && message.back() != ' ';
}

/// What `read()` returns, or nothing where it refuses the input. The only exception that it may
/// throw is InputError, with a message of one sentence; any other one ends the process.
template <class Read>
auto accepted(Read&& read) -> std::optional<decltype(read())> {
  try {
    return std::forward<Read>(read)();
  } catch (const InputError& error) {
    require(is_one_sentence(error.what()), "an InputError is one sentence");
    return std::nullopt;
  }
}

/// Whether two sums of `steps` rewards of at most `greatest` each are the same up to the rounding
/// of another order of summing.
inline bool same_sum(double a, double b, double greatest, std::size_t steps) {
  return a == b || std::abs(a - b) <= 1e-9 * (1 + greatest * static_cast<double>(steps + 1));
}

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

}  // namespace orasp::fuzz
