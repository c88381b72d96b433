#pragma once

#include <string>
#include <vector>

#include "orasp/model/problem.h"
#include "orasp/model/validate.h"

namespace orasp {

/// What a reader made of a file of another format.
struct Converted {
  ProblemSpec problem{};  ///< not yet checked
  /// What the file says and the problem does not, a sentence each; nothing is dropped in silence.
  std::vector<std::string> notes{};
};

/// What a writer made of a problem, or of a plan.
struct Written {
  std::string text{};
  /// What the problem or the plan says and the text does not, a sentence each.
  std::vector<std::string> notes{};
};

/// What a writer is handed.
struct WriteRequest {
  const Problem& problem;
  /// A valid plan of one robot, replayed; null for formats that need none.
  const Evaluation* plan = nullptr;
};

}  // namespace orasp
