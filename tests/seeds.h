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

/// The share of `all` that is looked at, and at least one.
template <class Number>
[[nodiscard]] Number some_of(Number all) {
  return std::max(Number{1}, all * static_cast<Number>(percent_of_seeds()) / Number{100});
}

/// How often a test must have met something in its problems, to be worth what it says: `count`
/// times where it looks at all of them. A share of them may by chance hold none.
template <class Number>
[[nodiscard]] Number least_of(Number count) {
  return percent_of_seeds() == 100 ? count : Number{0};
}

/// The same for something that must have been met more often than `count` times.
template <class Number>
[[nodiscard]] Number more_than(Number count) {
  return least_of(count + Number{1});
}

}  // namespace orasp
