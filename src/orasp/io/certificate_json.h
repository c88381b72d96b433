#pragma once

#include <string>
#include <string_view>

#include "orasp/certificate/certificate.h"
#include "orasp/io/plan_json.h"
#include "orasp/model/problem.h"

namespace orasp {

/// A certificate as a file, format `orasp-certificate/1` (docs/certificates.md). Ends with a
/// newline. Numbers read back unchanged.
[[nodiscard]] std::string certificate_text(const Problem& problem, const Certificate& certificate);

/// Reads such a file for this very problem. Whether it proves anything is for check_certificate()
/// to say. @throws InputError for a file that is none, that has unknown or missing keys, that was
///         made for another problem (by its digest), or that names what the problem does not have.
[[nodiscard]] Certificate parse_certificate(const Problem& problem, std::string_view text);

/// check_optimality() of what a plan file says. @throws InputError as plan_steps().
[[nodiscard]] OptimalityCheck check_optimality(const Problem& problem, const PlanFile& plan,
                                               const Certificate& certificate);

}  // namespace orasp
