// Fuzz target: the bytes say what has happened to a job, a line for each event:
//
//     removed 1-2        inaccessible 4-5      accessible 4-5     not-next 2-3
//     lost 7             replaced 7            late 3             arrived 3
//     max-moved-parts 2
//
// A line that names no event is skipped; an id that does not exist is refused in one sentence.
// After the last event the replanner's answer is that of solving the problem that is left from the
// beginning, and its plan is legal from where the work stands.
#include <algorithm>
#include <charconv>

#include "fuzz/property.h"
#include "orasp/execution/replanner.h"
#include "orasp/io/scenarios.h"
#include "orasp/model/validate.h"
#include "orasp/planners/automatic.h"

namespace orasp::fuzz {
namespace {

void apply(Replanner& replanner, std::string_view line) {
  const std::size_t space = line.find(' ');
  if (space == std::string_view::npos) return;
  const std::string_view event = line.substr(0, space);
  const std::string id(line.substr(space + 1));
  const Problem& problem = replanner.problem();
  const auto connection = [&] { return problem.find_connection(id, std::string(event)); };
  const auto part = [&] { return problem.find_part(id, std::string(event)); };
  if (event == "removed") replanner.set_done(connection());
  if (event == "inaccessible") replanner.set_accessible(connection(), false);
  if (event == "accessible") replanner.set_accessible(connection(), true);
  if (event == "not-next") replanner.set_possible_next(connection(), false);
  if (event == "lost") replanner.set_lost(part(), true);
  if (event == "replaced") replanner.set_lost(part(), false);
  if (event == "late") replanner.set_late(part(), true);
  if (event == "arrived") replanner.set_late(part(), false);
  if (event == "max-moved-parts") {
    std::size_t parts = 0;
    const auto [end, error] = std::from_chars(id.data(), id.data() + id.size(), parts);
    if (error != std::errc() || end != id.data() + id.size()) return;
    Limits limits = problem.limits();
    limits.max_moved_parts = parts;
    replanner.set_limits(limits);
  }
}

void check_answer(Replanner& replanner) {
  const Result quick = replanner.plan();
  const Problem problem = replanner.problem();
  const TransitionSystem system(problem, replanner.situation());
  const Result fresh = automatic(system, 1, {});
  require(quick.status == fresh.status,
          "replanning agrees with planning on whether there is a plan");
  if (!quick.has_plan()) return;
  const Evaluation replay = evaluate(system, quick.sequence);
  require(replay.valid, "a plan is legal from where the work stands");
  double greatest = 0;
  for (const Step& step : replay.steps) greatest = std::max(greatest, std::abs(step.reward));
  require(same_sum(replay.reward, quick.reward, greatest, replay.steps.size()),
          "a plan earns what it says");
  require(same_sum(fresh.reward, quick.reward, greatest, replay.steps.size()),
          "replanning agrees with planning on the best reward");
}

}  // namespace
}  // namespace orasp::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace orasp;
  using namespace orasp::fuzz;
  constexpr std::size_t kMostBytes = 400;
  static const Problem kProblem = load_scenario("2x3");
  Replanner replanner(kProblem);
  std::string_view text = text_of(data, std::min(size, kMostBytes));
  const auto events = accepted([&] {
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      apply(replanner, text.substr(0, end));
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    return true;
  });
  if (events) check_answer(replanner);
  return 0;
}
