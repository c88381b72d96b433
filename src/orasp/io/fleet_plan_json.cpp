#include "orasp/io/fleet_plan_json.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "orasp/io/detail/json_document.h"
#include "orasp/io/detail/json_text.h"
#include "orasp/io/problem_json.h"
#include "orasp/model/detail/wording.h"

namespace orasp {
namespace {

using detail::in_quotes;
using detail::inline_text;
using detail::JsonDocument;
using detail::JsonKind;
using detail::JsonValue;
using detail::number_or_null;
using nlohmann::ordered_json;

constexpr std::string_view kFormat = "orasp-plan/1";

ordered_json ids(const std::vector<ConnectionIndex>& connections, const Problem& problem) {
  ordered_json list = ordered_json::array();
  for (const ConnectionIndex c : connections) list.push_back(problem.connection_id(c));
  return list;
}

ordered_json move_json(const FleetMove& move, const Problem& problem) {
  ordered_json parts = ordered_json::array();
  for (const PartIndex part : move.parts) parts.push_back(problem.part_id(part));
  return {{"robots", move.robots},
          {"parts", std::move(parts)},
          {"from", FleetProblem::place_name(move.from)},
          {"to", FleetProblem::place_name(move.to)},
          {"motion", motion_name(move.motion)},
          {"distance", number_or_null(move.distance)}};
}

std::string steps_text(const FleetResult& result, const Problem& problem) {
  if (result.plan.steps.empty()) return "[]";
  std::string text = "[";
  double total = 0;
  for (std::size_t i = 0; i < result.plan.steps.size(); ++i) {
    const FleetStep& step = result.plan.steps[i];
    const double reward = result.objective == FleetObjective::Makespan ? -1.0 : 0.0 - step.distance;
    total += reward;
    text += fmt::format("{}\n    {{\"step\": {}, \"connections\": {}, \"moves\": [",
                        i == 0 ? "" : ",", i + 1, inline_text(ids(step.cut, problem)));
    for (std::size_t m = 0; m < step.moves.size(); ++m)
      text += fmt::format("{}\n      {}", m == 0 ? "" : ",",
                          inline_text(move_json(step.moves[m], problem)));
    text += fmt::format(
        "\n    ], \"robots_used\": {}, \"distance\": {}, \"reward\": {}, \"total\": {}}}",
        step.robots_used, inline_text(number_or_null(step.distance)),
        inline_text(number_or_null(reward)), inline_text(number_or_null(total)));
  }
  return text + "\n  ]";
}

std::string options_text(const std::map<std::string, std::string>& options) {
  std::string text = "{";
  for (const auto& [name, value] : options)
    text += (text.size() > 1 ? ", " : "") + inline_text(name) + ": " + value;
  return text + "}";
}

/// Reads members of one object; `place` is where it stands.
class Reader {
 public:
  Reader(JsonValue object, std::string place) : object_(object), place_(std::move(place)) {
    if (!object.is(JsonKind::Object)) fail(place_, "expected an object", object);
  }

  [[nodiscard]] JsonValue member(std::string_view key, JsonKind kind,
                                 std::string_view expected) const {
    std::optional<JsonValue> found;
    object_.for_each([&](JsonValue member) {
      if (member.key() == key) found = member;
    });
    if (!found) throw InputError(detail::at(place_, fmt::format("the key \"{}\" is missing", key)));
    if (!found->is(kind)) fail(place_of(key), fmt::format("expected {}", expected), *found);
    return *found;
  }
  [[nodiscard]] std::string place_of(std::string_view key) const {
    return place_.empty() ? std::string(key) : place_ + "." + std::string(key);
  }
  /// Calls `visit(element, its place)` for each element of a list.
  void for_each(std::string_view key, JsonKind kind, std::string_view expected,
                const std::function<void(JsonValue, const std::string&)>& visit) const {
    std::size_t i = 0;
    member(key, JsonKind::Array, "an array").for_each([&](JsonValue element) {
      const std::string place = fmt::format("{}[{}]", place_of(key), i++);
      if (!element.is(kind)) fail(place, fmt::format("expected {}", expected), element);
      visit(element, place);
    });
  }

 private:
  [[noreturn]] static void fail(const std::string& place, const std::string& expected,
                                JsonValue value) {
    throw InputError(detail::at(place, expected + ", found " + value.description()));
  }

  JsonValue object_;
  std::string place_;
};

PlaceIndex read_place(const Reader& move, std::string_view key, const FleetProblem& fleet) {
  const std::string_view name = move.member(key, JsonKind::String, "a place").string();
  for (PlaceIndex place = 0; place < fleet.num_places(); ++place) {
    if (FleetProblem::place_name(place) == name) return place;
  }
  throw InputError(
      fmt::format("{}: no place {}; places are \"depot\" and \"site 1\" to \"site {}\"",
                  move.place_of(key), in_quotes(name), fleet.num_sites()));
}

Motion read_motion(const Reader& move) {
  const std::string_view name = move.member("motion", JsonKind::String, "a motion").string();
  for (Motion motion = 0; motion < kNumMotions; ++motion) {
    if (motion_name(motion) == name) return motion;
  }
  throw InputError(
      fmt::format("{}: {} is not a motion; motions are stay, +x, -x, +y, -y, +z and -z",
                  move.place_of("motion"), in_quotes(name)));
}

std::size_t read_robot(JsonValue value, const std::string& place) {
  constexpr double kMost = 1e6;
  const double number = value.number();
  if (!(number >= 0 && number <= kMost) || number != std::floor(number))
    throw InputError(
        fmt::format("{}: {} is not the number of a robot", place, detail::number_text(number)));
  return static_cast<std::size_t>(number);
}

FleetMove read_move(const Reader& reader, const FleetProblem& fleet) {
  FleetMove move;
  reader.for_each(
      "parts", JsonKind::String, "a part id, which is a string",
      [&](JsonValue id, const std::string& place) {
        move.parts.push_back(fleet.problem().find_part(std::string(id.string()), place));
      });
  if (move.parts.empty())
    throw InputError(fmt::format("{}: a move has at least one part", reader.place_of("parts")));
  reader.for_each("robots", JsonKind::Number, "the number of a robot",
                  [&](JsonValue robot, const std::string& place) {
                    move.robots.push_back(read_robot(robot, place));
                  });
  move.from = read_place(reader, "from", fleet);
  move.to = read_place(reader, "to", fleet);
  move.motion = read_motion(reader);
  move.distance = reader.member("distance", JsonKind::Number, "a number").number();
  return move;
}

}  // namespace

std::string fleet_plan_text(const FleetProblem& fleet, const FleetResult& result,
                            const std::map<std::string, std::string>& options) {
  const Problem& problem = fleet.problem();
  const bool has_bound = result.bound && std::isfinite(*result.bound);
  const bool has_gap = has_bound && result.has_plan();
  std::vector<ConnectionIndex> sequence = result.plan.sequence();

  std::string text = "{\n  \"format\": " + inline_text(kFormat);
  const auto put = [&text](std::string_view key, std::string_view value) {
    text.append(",\n  \"").append(key).append("\": ").append(value);
  };
  const auto put_number = [&](std::string_view key, std::optional<double> number) {
    put(key, inline_text(number ? number_or_null(*number) : ordered_json(nullptr)));
  };
  put("problem", inline_text(problem.name()));
  put("problem_digest", inline_text(problem_digest(problem)));
  put("method", inline_text(result.method));
  put("status", inline_text(status_name(result.status)));
  if (result.stop != Stop::None) put("stopped", inline_text(stop_name(result.stop)));
  put_number("reward", result.has_plan() ? std::optional(result.reward) : std::nullopt);
  put_number("bound", has_bound ? result.bound : std::nullopt);
  put_number("gap",
             has_gap ? std::optional(std::max(0.0, *result.bound - result.reward)) : std::nullopt);
  ordered_json summary = {{"objective", objective_name(result.objective)}};
  if (result.steps_allowed) summary["steps_allowed"] = *result.steps_allowed;
  summary["makespan"] = result.has_plan() ? ordered_json(result.plan.makespan()) : nullptr;
  summary["travel"] = result.has_plan() ? number_or_null(result.plan.travel()) : nullptr;
  put("fleet", inline_text(summary));
  put("disassembly", inline_text(ids(sequence, problem)));
  std::ranges::reverse(sequence);
  put("assembly", inline_text(ids(sequence, problem)));
  put("steps", steps_text(result, problem));
  const Statistics& statistics = result.statistics;
  put("statistics", inline_text({{"states", statistics.states},
                                 {"expanded", statistics.expanded},
                                 {"generated", statistics.generated},
                                 {"pruned", statistics.pruned},
                                 {"seconds", number_or_null(statistics.seconds)},
                                 {"peak_bytes", statistics.peak_bytes}}));
  put("seed", std::to_string(result.seed));
  put("options", options_text(options));
  if (!result.notes.empty()) put("notes", inline_text(result.notes));
  return text + "\n}\n";
}

bool is_fleet_plan(std::string_view text) {
  const std::size_t first = text.find('{');
  if (first == std::string_view::npos || text.find("\"fleet\"") == std::string_view::npos)
    return false;
  try {
    const JsonDocument document = JsonDocument::parse(text);
    bool found = false;
    if (document.root().is(JsonKind::Object))
      document.root().for_each([&](JsonValue member) { found |= member.key() == "fleet"; });
    return found;
  } catch (const InputError&) {
    return false;
  }
}

FleetPlanFile parse_fleet_plan(std::string_view text, const FleetProblem& fleet) {
  const JsonDocument document = JsonDocument::parse(text);
  const Reader root(document.root(), "");
  const std::string_view format = root.member("format", JsonKind::String, "a string").string();
  if (format != kFormat)
    throw InputError(fmt::format("format: {} is not the format of a plan; that is \"{}\"",
                                 in_quotes(format), kFormat));
  FleetPlanFile file;
  document.root().for_each([&](JsonValue member) {
    if (member.key() == "problem_digest" && member.is(JsonKind::String))
      file.problem_digest = member.string();
  });
  const Reader summary(root.member("fleet", JsonKind::Object, "an object"), "fleet");
  const std::string_view objective =
      summary.member("objective", JsonKind::String, "an objective").string();
  if (objective == objective_name(FleetObjective::Travel)) {
    file.objective = FleetObjective::Travel;
  } else if (objective != objective_name(FleetObjective::Makespan)) {
    throw InputError(
        fmt::format("fleet.objective: {} is neither makespan nor travel", in_quotes(objective)));
  }
  file.plan.start.assign(fleet.num_parts(), kDepot);
  std::vector<bool> known(fleet.num_parts(), false);
  root.for_each(
      "steps", JsonKind::Object, "a step, which is an object",
      [&](JsonValue value, const std::string& place) {
        const Reader reader(value, place);
        FleetStep step;
        reader.for_each(
            "connections", JsonKind::String, "a connection id, which is a string",
            [&](JsonValue id, const std::string& at) {
              step.cut.push_back(fleet.problem().find_connection(std::string(id.string()), at));
            });
        reader.for_each("moves", JsonKind::Object, "a move, which is an object",
                        [&](JsonValue move, const std::string& at) {
                          step.moves.push_back(read_move(Reader(move, at), fleet));
                        });
        for (const FleetMove& move : step.moves) {
          step.robots_used += move.robots.size();
          step.distance += move.distance;
          for (const PartIndex part : move.parts) {
            if (!known[part]) file.plan.start[part] = move.from;
            known[part] = true;
          }
        }
        file.plan.steps.push_back(std::move(step));
      });
  return file;
}

}  // namespace orasp
