#include "cli/output/fleet_table.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "cli/output/text.h"

namespace orasp::cli {
namespace {

constexpr std::size_t kLeastListWidth = 16;

}  // namespace

std::string fleet_table(const Problem& problem, const FleetPlan& plan, const Context& context) {
  constexpr std::size_t kOtherColumns = 52;
  const std::size_t width =
      std::max(kLeastListWidth, (context.width() - std::min(context.width(), kOtherColumns)) / 2);
  TextTable table;
  table.add_column("step", TextTable::Align::Right);
  table.add_column("robots", TextTable::Align::Left);
  table.add_column("parts", TextTable::Align::Left);
  table.add_column("from", TextTable::Align::Left);
  table.add_column("to", TextTable::Align::Left);
  table.add_column("motion", TextTable::Align::Left);
  table.add_column("distance", TextTable::Align::Right);
  table.add_column("cuts", TextTable::Align::Left);
  std::vector<double> distances;
  for (const FleetStep& step : plan.steps) {
    for (const FleetMove& move : step.moves) distances.push_back(move.distance);
  }
  const std::vector<std::string> distance_texts = aligned_numbers(distances);
  std::size_t next_distance = 0;
  for (std::size_t i = 0; i < plan.steps.size(); ++i) {
    const FleetStep& step = plan.steps[i];
    std::vector<std::string> cut;
    for (const ConnectionIndex c : step.cut) cut.push_back(problem.connection_id(c));
    bool first = true;
    for (const FleetMove& move : step.moves) {
      std::vector<std::string> robots;
      std::vector<std::string> parts;
      for (const std::size_t robot : move.robots) robots.push_back(fmt::to_string(robot));
      for (const PartIndex part : move.parts) parts.push_back(problem.part_id(part));
      table.add_row({first ? fmt::to_string(i + 1) : "", capped_list(robots, width),
                     capped_list(parts, width), FleetProblem::place_name(move.from),
                     FleetProblem::place_name(move.to), std::string(motion_name(move.motion)),
                     distance_texts[next_distance++], first ? capped_list(cut, width) : ""});
      first = false;
    }
  }
  return table.text(context.colour());
}

}  // namespace orasp::cli
