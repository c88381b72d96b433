#pragma once

#include <array>
#include <cstddef>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "orasp/io/run_records.h"
#include "orasp/model/transition_system.h"
#include "orasp/model/validate.h"
#include "orasp/report/part_shapes.h"
#include "orasp/task/result.h"

namespace orasp {

/// The largest page that is written, the shapes of the parts apart.
inline constexpr std::size_t kMaxReportBytes = std::size_t{2} << 20U;
/// The largest H that the page draws.
inline constexpr std::size_t kMaxReportStates = 400;
inline constexpr std::size_t kMaxReportActions = 2'000;

/// One plan of a report.
struct ReportPlan {
  std::string label;   ///< what to call it: "auto", "plan.json"
  std::string origin;  ///< a sentence: where it comes from
  std::vector<std::string>
      sequence;  ///< connection ids in the order of the problem's direction, as given
  /// Empty, or for each of them the direction that the plan states; "" for none.
  std::vector<std::string> directions{};
  /// Where steps take parts off (StepKind::Part): what each takes, and its direction, instead of
  /// the two above.
  std::vector<PlanStep> part_steps{};
  std::optional<double> expected;  ///< expected reward where attempts may fail, if known
  std::vector<std::string> notes;  ///< sentences
};

/// Rewards of random sequences.
struct ReportSample {
  std::string origin;  ///< a sentence: where it comes from
  std::vector<double> rewards;
  double mean = 0;
  double deviation = 0;
  double least = 0;
  std::array<double, 3> quartiles{};
  double greatest = 0;
};

/// What a report shows beside the problem itself. Texts are data: the page shows them as they are,
/// whatever they hold.
struct Report {
  std::string title;
  std::vector<ReportPlan> plans;      ///< may be empty, where there is none
  Result best;                        ///< of a planner: what is proved of the problem
  std::string effort;                 ///< what `best` took, in words
  std::vector<std::string> conflict;  ///< why there is no plan, a sentence each
  std::vector<LearningPoint> learning;
  std::optional<ReportSample> sample;
  std::optional<PartShapes> shapes;  ///< the page then shows the true parts
  std::string shapes_fault;  ///< why it does not, though the problem names a file; a sentence
};

/// The plan of a report, replayed by evaluate() of model/validate.h.
[[nodiscard]] Evaluation replayed(const TransitionSystem& system, const ReportPlan& plan);

/// The report as JSON, the data of the page: the problem, each plan replayed by evaluate() with the
/// grounds of each step, H where it has at most kMaxReportStates states and kMaxReportActions
/// actions (and what precedence takes from it), the learning curve and the distribution. All facts
/// are worked out here; the page arranges and draws. `<` is written `\u003c`.
[[nodiscard]] std::string report_data(const TransitionSystem& system, const Report& report);

/// The report as one HTML page that needs nothing else: no network, no other file. @throws
/// InputError if it would be larger than kMaxReportBytes.
[[nodiscard]] std::string report_html(const TransitionSystem& system, const Report& report);

/// report_html into a stream. @throws InputError as above.
void write_report(std::ostream& out, const TransitionSystem& system, const Report& report);

}  // namespace orasp
