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
  if (std::ranges::find(kFleetObjectiveTypes, objective) == kFleetObjectiveTypes.end()) {
    throw InputError(fmt::format("fleet.objective: {} is none of {}", in_quotes(objective),
                                 fmt::join(kFleetObjectiveTypes, ", ")));
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
