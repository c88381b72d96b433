#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace orasp {

/// Something the caller gave is wrong: a file, an option, a number. The message is one sentence
/// that names the thing, where it stands and what was allowed. Nothing else is thrown on purpose;
/// "no plan" and "time is up" are values of Status (task/result.h).
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A method does not take what it was asked. The message is the method's name and the reason, a
/// clause that goes on from it ("plans for one robot, and ..."). solve() adds which methods do.
class Refusal : public InputError {
 public:
  Refusal(std::string_view method, std::string reason)
      : InputError(std::string(method) + " " + reason), reason_(std::move(reason)) {}
  [[nodiscard]] const std::string& reason() const { return reason_; }

 private:
  std::string reason_;
};

}  // namespace orasp
