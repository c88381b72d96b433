#pragma once

#include <stdexcept>

namespace orasp {

/// Something the caller gave is wrong: a file, an option, a number. The message is one sentence
/// that names the thing, where it stands and what was allowed. Nothing else is thrown on purpose;
/// "no plan" and "time is up" are values of Status (task/result.h).
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace orasp
