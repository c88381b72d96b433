#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "orasp/model/transition_system.h"
#include "orasp/task/result.h"

namespace orasp {

/// The policy of a result for uncertain attempts (Result::expectation), format
/// `orasp-state-policy/1` (docs/format.md): a line for each state that it can meet, the start
/// first. Ends with a newline.
[[nodiscard]] std::string state_policy_text(const TransitionSystem& system, const Result& result);

/// Reads such a file for this very problem. Whether the policy is complete and legal shows as it is
/// followed (guide_by_policy).
/// @throws InputError for a file that is no policy, that was made for another problem (by its
///         digest), that names unknown connections, or that lists a state twice.
[[nodiscard]] std::vector<PolicyState> parse_state_policy(const TransitionSystem& system,
                                                          std::string_view text);

}  // namespace orasp
