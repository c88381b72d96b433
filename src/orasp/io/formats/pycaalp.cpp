#include "orasp/io/formats/pycaalp.h"

#include <algorithm>
#include <array>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "orasp/io/detail/json_document.h"
#include "orasp/io/detail/json_members.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/error.h"

namespace orasp {
namespace {

using detail::JsonKind;
using detail::JsonValue;
using detail::Members;
using detail::Place;

/// An id that stands as a key.
std::string key_id(JsonValue member, const Place& place) {
  std::string id(member.key());
  if (const auto fault = detail::id_fault(id)) detail::fail(place, "the name " + *fault);
  return id;
}

Part read_part(JsonValue member, const Place& place) {
  constexpr auto kKeys = std::to_array<std::string_view>({"weight", "handling"});
  const Members members(member, place, kKeys);
  Part part{.id = key_id(member, place)};
  members.read("weight", part.mass, detail::read_number);
  if (const auto handling = members.find("handling"))
    part.numbers["handling"] = detail::read_number(*handling, Place(place, "handling"));
  return part;
}

Connection read_joint(JsonValue member, const Place& place) {
  constexpr auto kKeys =
      std::to_array<std::string_view>({"parts", "technology", "time", "tolerance"});
  const Members members(member, place, kKeys);
  Connection joint{.id = key_id(member, place)};
  const auto ids = members.read_required("parts", [](JsonValue list, const Place& list_place) {
    auto read =
        detail::read_array(list, list_place, "an array of two names of parts", detail::read_id);
    if (read.size() != 2)
      detail::fail(list_place, fmt::format("expected two names of parts, found {}", read.size()));
    return read;
  });
  std::ranges::copy(ids, joint.parts.begin());
  members.read("time", joint.duration, detail::read_number);
  if (const auto tolerance = members.find("tolerance"))
    joint.numbers["tolerance"] = detail::read_number(*tolerance, Place(place, "tolerance"));
  if (const auto technology = members.find("technology")) {
    joint.attributes["technology"] =
        technology->is(JsonKind::Number)
            ? detail::number_text(technology->number())
            : detail::read_string(*technology, Place(place, "technology"));
  }
  return joint;
}

/// The members of an object, each read by `read(member, place)`.
template <class Read>
auto read_members(JsonValue value, const Place& place, std::size_t most, Read&& read) {
  if (!value.is(JsonKind::Object)) detail::fail_type(place, value, "an object");
  std::vector<decltype(read(value, place))> all;
  if (value.size() > most)
    detail::fail(place, fmt::format("more than {}, the most there may be", most));
  value.for_each(
      [&](JsonValue member) { all.push_back(read(member, Place(place, member.key()))); });
  return all;
}

}  // namespace

Converted read_pycaalp(std::string_view text) {
  constexpr auto kKeys = std::to_array<std::string_view>({"parts", "joints"});
  const detail::JsonDocument document = detail::JsonDocument::parse(text);
  const Place top("");
  if (!document.root().is(JsonKind::Object))
    detail::fail_type(top, document.root(), "an object with \"parts\" and \"joints\"");
  const Members members(document.root(), top, kKeys);
  Converted converted;
  ProblemSpec& problem = converted.problem;
  problem.parts = members.read_required("parts", [](JsonValue value, const Place& place) {
    return read_members(value, place, kMaxParts, read_part);
  });
  if (problem.parts.empty()) detail::fail(Place(top, "parts"), "there are no parts");
  problem.connections = members.read_required("joints", [](JsonValue value, const Place& place) {
    return read_members(value, place, kMaxConnections, read_joint);
  });
  std::unordered_set<std::string> ids;
  for (const Part& part : problem.parts) ids.insert(part.id);
  for (const Connection& joint : problem.connections) {
    for (const std::string& part : joint.parts) {
      if (ids.contains(part)) continue;
      const Place joints(top, "joints");
      const Place here(joints, joint.id);
      detail::fail(Place(here, "parts"), "there is no part " + detail::in_quotes(part));
    }
  }
  problem.direction = Direction::Assembly;
  problem.limits.max_subassemblies = 1;
  const bool states_technology = std::ranges::any_of(
      problem.connections, [](const Connection& joint) { return !joint.attributes.empty(); });
  if (states_technology) {
    Changeover changes;
    changes.attribute = "technology";
    problem.objective = Objective("changeover", std::move(changes));
  } else {
    problem.objective = Objective("time", TimeObjective{.depot = {}, .speed = 1, .transfer = 0});
  }
  return converted;
}

}  // namespace orasp
