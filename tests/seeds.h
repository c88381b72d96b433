#pragma once

#include <algorithm>
#include <cstdlib>

namespace orasp {

/// How many percent of its random problems a test looks at: the variable ORASP_TEST_SEEDS, from 1
/// to 100, or all of them where it is not set. Programs under a sanitizer are several times slower,
/// so their presets ask for fewer; the release preset asks for all.
[[nodiscard]] inline int percent_of_seeds() {
  const char* const given = std::getenv("ORASP_TEST_SEEDS");
  return given == nullptr ? 100 : std::clamp(std::atoi(given), 1, 100);
}

/// The share of `all` that is looked at, and at least one. A test that counts what its problems
/// had in them asks for the same share of the count.
template <class Number>
[[nodiscard]] Number some_of(Number all) {
  return std::max(Number{1}, all * static_cast<Number>(percent_of_seeds()) / Number{100});
}

}  // namespace orasp
