#pragma once

#include <type_traits>

namespace orasp::detail {

/// The key under which libtorch's optimiser keeps what it knows of a parameter. Up to libtorch 1.13
/// that is a text made of the address of the parameter's tensor, from 2.0 on the address itself:
/// `Key` is the key type of the map, `to_text` makes the text and is asked for in the first case
/// alone.
template <class Key, class Tensor, class ToText>
[[nodiscard]] Key optimiser_key(Tensor* tensor, const ToText& to_text) {
  if constexpr (std::is_pointer_v<Key>) {
    return tensor;
  } else {
    return to_text(tensor);
  }
}

}  // namespace orasp::detail
