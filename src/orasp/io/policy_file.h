#pragma once

#include <string>
#include <string_view>

#include "orasp/learning/policy.h"
#include "orasp/model/problem.h"

namespace orasp {

/// What a policy file holds, format `orasp-policy/1` (docs/format.md).
struct PolicyFile {
  std::string problem_digest;  ///< of the problem it was trained on
  std::string problem_name;
  TrainedPolicy trained;
};

/// The bytes of a policy file: one line of JSON, the numbers as float32, and a checksum of it all.
[[nodiscard]] std::string policy_bytes(const PolicyFile& file);

/// @throws InputError for bytes that are no policy, damaged, cut off, or of sizes that do not fit
/// together.
[[nodiscard]] PolicyFile parse_policy(std::string_view bytes);

/// Refuses a policy that was trained on another problem than this one. `file` is what the sentence
/// calls it. @throws InputError.
void require_trained_on(const Problem& problem, const PolicyFile& policy, std::string_view file);

}  // namespace orasp
