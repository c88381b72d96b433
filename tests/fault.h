#pragma once

#include <string>
#include <utility>

#include "orasp/model/error.h"

namespace orasp {

/// The sentence of the InputError that `act` throws; "no fault" if it throws nothing.
template <class Act>
[[nodiscard]] std::string fault_of(Act&& act) {
  try {
    (void)std::forward<Act>(act)();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no fault";
}

}  // namespace orasp
