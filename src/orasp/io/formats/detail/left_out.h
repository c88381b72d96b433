#pragma once

#include <string>

#include "orasp/model/problem.h"

namespace orasp::detail {

/// What a format that holds parts and connections alone leaves out of a problem.
struct LeftOut {
  bool base = true;
  bool direction = true;
  bool objective = true;
  bool values = false;  ///< what parts and connections state beside masses and durations
};

/// One sentence that lists what the problem states beyond its parts and connections; empty where
/// that is nothing.
[[nodiscard]] std::string left_out_sentence(const ProblemSpec& spec, const LeftOut& left_out);

}  // namespace orasp::detail
