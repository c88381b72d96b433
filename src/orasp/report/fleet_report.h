#pragma once

#include <string>
#include <vector>

#include "orasp/fleet/fleet.h"
#include "orasp/task/result.h"

namespace orasp {

/// One plan of a report on a fleet.
struct FleetReportPlan {
  std::string label;   ///< what to call it: "fleet-search", "plan.json"
  std::string origin;  ///< a sentence: where it comes from
  FleetPlan plan;
  std::vector<std::string> notes;  ///< sentences
};

/// What a report on a fleet shows beside the problem itself (report/report.h is that of one robot).
struct FleetReport {
  std::string title;
  std::vector<FleetReportPlan> plans;
  Result best;         ///< of a planner: what is proved
  std::string effort;  ///< what `best` took, in words
};

/// The report as JSON, the data of the page: each plan checked by evaluate() of
/// fleet/fleet_validate.h, what each robot does in each step, what stands where. `<` is written
/// `\u003c`.
[[nodiscard]] std::string report_data(const FleetProblem& fleet, const FleetReport& report);

/// The report as one HTML page that needs nothing else. @throws InputError if it would be larger
/// than kMaxReportBytes.
[[nodiscard]] std::string report_html(const FleetProblem& fleet, const FleetReport& report);

}  // namespace orasp
