// The optimiser's state is found under either way of keying: libtorch 1's texts, libtorch 2's
// addresses.

#include "orasp/learning/detail/optimiser_key.h"

#include <cstdint>
#include <map>
#include <string>

#include <gtest/gtest.h>

namespace orasp {
namespace {

struct Tensor {};
/// As libtorch 1 and 2 keep it.
using TextKeyed = std::map<std::string, int>;
using AddressKeyed = std::map<void*, int>;

/// As learning/network.cpp finds a parameter's moments.
template <class State>
int& moments_of(State& state, Tensor& parameter) {
  const auto to_text = [](const auto* tensor) {
    return std::to_string(reinterpret_cast<std::uintptr_t>(tensor));
  };
  return state[detail::optimiser_key<typename State::key_type>(&parameter, to_text)];
}

template <class State>
void expect_found_again() {
  State state;
  Tensor first;
  Tensor second;
  moments_of(state, first) = 1;
  moments_of(state, second) = 2;
  EXPECT_EQ(moments_of(state, first), 1);
  EXPECT_EQ(moments_of(state, second), 2);
  EXPECT_EQ(state.size(), 2U);
}

TEST(OptimiserKey, FindsWhatIsKeyedByText) {
  expect_found_again<TextKeyed>();
}

TEST(OptimiserKey, FindsWhatIsKeyedByAddress) {
  expect_found_again<AddressKeyed>();
}

}  // namespace
}  // namespace orasp
