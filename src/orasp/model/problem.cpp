#include "orasp/model/problem.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "orasp/model/detail/wording.h"
#include "orasp/model/formula.h"
#include "orasp/model/objectives/objective_kind.h"

namespace orasp {
namespace {

using detail::in_quotes;
using detail::number_text;

[[noreturn]] void fail(const std::string& place, const std::string& message) {
  throw InputError(detail::at(place, message));
}

std::string element(const std::string& list, std::size_t index) {
  return list + "[" + std::to_string(index) + "]";
}

void require_count(std::size_t count, std::size_t most, const std::string& things) {
  if (count > most)
    fail(things,
         "more than " + std::to_string(most) + " " + things + ", the most a problem may have");
}

void require_utf8(const std::string& text, const std::string& place) {
  if (detail::ill_formed_utf8(text)) fail(place, in_quotes(text) + " is not valid UTF-8");
}

void require_id(const std::string& id, const std::string& place) {
  if (const auto fault = detail::id_fault(id)) fail(place, *fault);
}

void require_finite(double number, const std::string& place) {
  if (!std::isfinite(number)) fail(place, number_text(number) + " is not a finite number");
}

void require_finite(const Vector3& point, const std::string& place) {
  for (std::size_t axis = 0; axis < point.size(); ++axis)
    require_finite(point[axis], element(place, axis));
}

/// Numbers of the user's own stand in formulas by their names, and as their sums over a piece.
void require_numbers(const std::map<std::string, double>& numbers, const std::string& place) {
  for (const auto& [name, value] : numbers) {
    if (!is_formula_name(name)) {
      fail(place, in_quotes(name) + " is not a name; names are up to " +
                      std::to_string(kLongestFormulaName) +
                      " letters, digits and _, not a digit first");
    }
    for (const std::string& used : names_in_formulas(name)) {
      if (is_formula_variable(used))
        fail(place, in_quotes(used) + " is a variable of every formula; give the number " +
                        in_quotes(name) + " another name");
    }
    require_finite(value, place + "." + name);
  }
}

void require_attributes(const std::map<std::string, std::string>& attributes,
                        const std::string& place) {
  for (const auto& [name, value] : attributes) {
    if (name.empty()) fail(place, "the name of an attribute must not be empty");
    require_utf8(name, place);
    if (name == kDirectionAttribute)
      fail(place + "." + name,
           "the direction is the way in which a piece leaves, by \"blocking\", and is not stated; "
           "give the attribute another name");
    require_utf8(value, place + "." + name);
  }
}

void require_not_negative(double number, const std::string& place) {
  require_finite(number, place);
  if (number < 0) fail(place, number_text(number) + " is not allowed; it must be 0 or more");
}

/// "parts are "1" to "9"": all of them if there are at most three, else the first and the last.
template <class Items>
std::string available(const Items& items, const std::string& thing) {
  if (items.empty()) return "there are no " + thing + "s";
  if (items.size() == 1) return "the only " + thing + " is " + in_quotes(items[0].id);
  const std::string are = thing + "s are ";
  if (items.size() == 2) return are + in_quotes(items[0].id) + " and " + in_quotes(items[1].id);
  if (items.size() == 3) {
    return are + in_quotes(items[0].id) + ", " + in_quotes(items[1].id) + " and " +
           in_quotes(items[2].id);
  }
  return are + in_quotes(items.front().id) + " to " + in_quotes(items.back().id);
}

std::optional<std::size_t> direction_index(const std::string& name) {
  const auto found = std::ranges::find(kDirectionNames, std::string_view(name));
  if (found == kDirectionNames.end()) return std::nullopt;
  return static_cast<std::size_t>(found - kDirectionNames.begin());
}

std::string no_direction(const std::string& name) {
  return in_quotes(name) + " is not a direction; directions are +x, -x, +y, -y, +z and -z";
}

template <class Index>
void sort_and_merge(std::vector<Index>& indices) {
  std::ranges::sort(indices);
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
}

}  // namespace

Problem::Problem(ProblemSpec spec) : spec_(std::move(spec)) {
  require_utf8(spec_.name, "name");
  require_utf8(spec_.note, "note");
  require_utf8(spec_.source, "source");
  index_parts();
  index_connections();
  index_breaks();
  index_precedence();
  index_blocking();
  index_base();
  index_goal();
  check_limits();
  check_action();
  check_objective(spec_.objective, "objective");
  kind_of(spec_.objective).check_problem(spec_.objective.parameters, spec_, "objective");
  check_fleet();
  check_numbers();
}

// Each name in a formula has one meaning.
void Problem::check_numbers() const {
  std::map<std::string, std::string> places;  // of the numbers, by their names
  const auto note = [&](const std::map<std::string, double>& numbers, const std::string& place) {
    for (const auto& number : numbers) places.emplace(number.first, place + ".numbers");
  };
  for (std::size_t i = 0; i < spec_.parts.size(); ++i) {
    if (!spec_.parts[i].numbers.empty()) note(spec_.parts[i].numbers, element("parts", i));
  }
  for (std::size_t i = 0; i < spec_.connections.size(); ++i) {
    if (!spec_.connections[i].numbers.empty())
      note(spec_.connections[i].numbers, element("connections", i));
  }
  for (const auto& [name, place] : places) {
    for (const char* const side : {"moved_", "kept_"}) {
      const auto other = places.find(side + name);
      if (other == places.end()) continue;
      fail(other->second, in_quotes(other->first) + " is what formulas call a sum of " +
                              in_quotes(name) + "; give one of the two another name");
    }
  }
}

void Problem::index_parts() {
  require_count(spec_.parts.size(), kMaxParts, "parts");
  part_by_id_.reserve(spec_.parts.size());
  for (std::size_t i = 0; i < spec_.parts.size(); ++i) {
    const Part& part = spec_.parts[i];
    const std::string place = element("parts", i);
    require_id(part.id, place + ".id");
    const auto [entry, is_new] = part_by_id_.emplace(part.id, static_cast<PartIndex>(i));
    if (!is_new)
      fail(place + ".id",
           in_quotes(part.id) + " is the id of " + element("parts", entry->second) + " too");
    require_utf8(part.name, place + ".name");
    require_utf8(part.product, place + ".product");
    require_not_negative(part.mass, place + ".mass");
    if (part.position) require_finite(*part.position, place + ".position");
    require_numbers(part.numbers, place + ".numbers");
  }
}

void Problem::index_connections() {
  require_count(spec_.connections.size(), kMaxConnections, "connections");
  connection_by_id_.reserve(spec_.connections.size());
  ends_.reserve(spec_.connections.size());
  for (std::size_t i = 0; i < spec_.connections.size(); ++i) {
    Connection& connection = spec_.connections[i];
    const std::string place = element("connections", i);
    std::array<PartIndex, 2> ends{};
    for (std::size_t end = 0; end < ends.size(); ++end) {
      ends[end] = find_part(connection.parts[end], element(place + ".parts", end));
    }
    ends_.push_back(ends);

    const bool has_default_id = connection.id.empty();
    if (has_default_id) connection.id = connection.parts[0] + "-" + connection.parts[1];
    require_id(connection.id, place + ".id");
    const auto [entry, is_new] =
        connection_by_id_.emplace(connection.id, static_cast<ConnectionIndex>(i));
    if (!is_new) {
      const std::string other = element("connections", entry->second);
      if (has_default_id) {
        fail(place, "its default id " + in_quotes(connection.id) + " is the id of " + other +
                        " too; give it an \"id\"");
      }
      fail(place + ".id", in_quotes(connection.id) + " is the id of " + other + " too");
    }
    require_not_negative(connection.duration, place + ".duration");
    require_numbers(connection.numbers, place + ".numbers");
    require_attributes(connection.attributes, place + ".attributes");
    if (connection.position) require_finite(*connection.position, place + ".position");
    if (!(connection.success > 0 && connection.success <= 1)) {
      fail(place + ".success",
           number_text(connection.success) +
               " is not a probability of success; it must be above 0 and at most 1");
    }
    if (!connection.axis.empty() && !direction_index(connection.axis)) {
      fail(place + ".axis", no_direction(connection.axis));
    }
    if (ends[0] == ends[1]) {
      warnings_.push_back("connection " + in_quotes(connection.id) + " joins part " +
                          in_quotes(connection.parts[0]) +
                          " to itself; removing it separates nothing");
    }
  }
}

void Problem::index_breaks() {
  breaks_.resize(spec_.connections.size());
  for (std::size_t i = 0; i < spec_.connections.size(); ++i) {
    const OnFailure& failure = spec_.connections[i].on_failure;
    if (failure.retries()) continue;
    const std::string place = element("connections", i) + ".on_failure";
    if (failure.abort && !failure.breaks.empty())
      fail(place, "\"breaks\" and \"abort\" exclude each other: a job that ended breaks nothing");
    if (failure.abort) {
      require_finite(*failure.abort, place + ".abort");
      continue;
    }
    if (spec_.direction == Direction::Assembly) {
      fail(place + ".breaks",
           "connections come off in disassembly only; in assembly a failure can \"retry\" or "
           "\"abort\"");
    }
    for (std::size_t k = 0; k < failure.breaks.size(); ++k) {
      const std::string entry = element(place + ".breaks", k);
      const ConnectionIndex broken = find_connection(failure.breaks[k], entry);
      if (std::ranges::find(breaks_[i], broken) != breaks_[i].end())
        fail(entry, in_quotes(failure.breaks[k]) + " is listed twice");
      breaks_[i].push_back(broken);
    }
    std::ranges::sort(breaks_[i]);
  }
}

void Problem::index_precedence() {
  precedence_.reserve(spec_.precedence.size());
  for (std::size_t i = 0; i < spec_.precedence.size(); ++i) {
    const Precedence& rule = spec_.precedence[i];
    const std::string place = element("precedence", i);
    const auto indices = [&](const std::vector<std::string>& ids, const std::string& list) {
      std::vector<ConnectionIndex> found;
      found.reserve(ids.size());
      for (std::size_t k = 0; k < ids.size(); ++k)
        found.push_back(find_connection(ids[k], element(list, k)));
      sort_and_merge(found);
      return found;
    };
    const ConnectionIndex connection = find_connection(rule.connection, place + ".connection");
    precedence_.push_back(
        {.entry = i,
         .connection = connection,
         .after = indices(rule.after, place + ".after"),
         .after_any = indices(rule.after_any, place + ".after_any"),
         .made_after_any = indices(rule.made_after_any, place + ".made_after_any")});
    for (const ConnectionIndex earlier : indices(rule.made_after, place + ".made_after"))
      precedence_.push_back(
          {.entry = i, .connection = earlier, .after = {connection}, .after_any = {}});
  }
}

void Problem::index_base() {
  if (spec_.base.empty()) return;
  base_.assign(spec_.parts.size(), false);
  for (std::size_t i = 0; i < spec_.base.size(); ++i) {
    const PartIndex part = find_part(spec_.base[i], element("base", i));
    if (base_[part]) fail(element("base", i), in_quotes(spec_.base[i]) + " is listed twice");
    base_[part] = true;
  }
}

void Problem::index_goal() {
  if (!spec_.goal) return;
  const Goal& goal = *spec_.goal;
  if (spec_.direction == Direction::Assembly)
    fail("goal", "a goal says what is to come off, in disassembly; an assembly makes everything");
  std::vector<bool> free(spec_.parts.size(), false);
  for (std::size_t i = 0; i < goal.free.size(); ++i) {
    const PartIndex part = find_part(goal.free[i], element("goal.free", i));
    if (free[part]) fail(element("goal.free", i), in_quotes(goal.free[i]) + " is listed twice");
    free[part] = true;
  }
  for (std::size_t i = 0; i < goal.removed.size(); ++i) {
    const ConnectionIndex c = find_connection(goal.removed[i], element("goal.removed", i));
    if (std::ranges::find(goal_, c) != goal_.end())
      fail(element("goal.removed", i), in_quotes(goal.removed[i]) + " is listed twice");
    goal_.push_back(c);
  }
  for (ConnectionIndex c = 0; c < spec_.connections.size(); ++c) {
    if (free[ends_[c][0]] || free[ends_[c][1]]) goal_.push_back(c);
  }
  sort_and_merge(goal_);
}

void Problem::check_action() const {
  if (spec_.action == StepKind::Connection) return;
  for (std::size_t c = 0; c < ends_.size(); ++c) {
    if (ends_[c][0] == ends_[c][1])
      fail(element("connections", c),
           "it joins part " + in_quotes(spec_.connections[c].parts[0]) +
               " to itself, and with \"action\": \"part\" no step would ever handle it");
  }
  if (const auto uncertain = first_uncertain())
    fail(element("connections", *uncertain) + ".success",
         "attempts may fail at single connections only; with \"action\": \"part\" a step takes "
         "several");
}

void Problem::check_limits() const {
  if (spec_.limits.max_moved_mass)
    require_not_negative(*spec_.limits.max_moved_mass, "limits.max_moved_mass");
  if (spec_.limits.grounded && spec_.base.empty())
    fail("limits.grounded", "nothing can be grounded without a \"base\"");
}

void Problem::check_fleet() const {
  if (!spec_.fleet) {
    if (!spec_.objective.of_fleet()) return;
    fail("objective.type", in_quotes(spec_.objective.type) +
                               " judges plans of several robots, and the problem has no \"fleet\"");
  }
  if (!spec_.objective.of_fleet())
    fail("objective.type", in_quotes(spec_.objective.type) +
                               " judges plans of one robot, and a problem with \"fleet\" has an "
                               "objective of several, makespan or fleet_travel; without \"fleet\" "
                               "it is planned for one");
  for (std::size_t c = 0; c < spec_.connections.size(); ++c) {
    if (spec_.connections[c].duration != Connection().duration)
      fail(element("connections", c) + ".duration",
           "robots of a fleet work in steps, whose number and travel count; a duration would mean "
           "nothing, leave it out");
  }
  for (std::size_t i = 0; i < spec_.precedence.size(); ++i) {
    if (!spec_.precedence[i].made_after_any.empty())
      fail(element("precedence", i) + ".made_after_any",
           "a fleet of robots takes a product apart, and its precedence is stated that way, with "
           "after, after_any or made_after");
  }
  const auto refuse = [](bool stated, const std::string& key) {
    if (stated)
      fail(key,
           "a fleet of robots takes the whole product apart, one connection a robot and step; " +
               in_quotes(key) + " would mean nothing, leave it out");
  };
  refuse(!spec_.base.empty(), "base");
  refuse(spec_.goal.has_value(), "goal");
  refuse(spec_.action != StepKind::Connection, "action");
  for (std::size_t i = 0; spec_.blocking && i < spec_.blocking->directions.size(); ++i) {
    const BlockingDirection& direction = spec_.blocking->directions[i];
    if (direction.vector)
      fail(element("blocking.directions", i), "robots of a fleet move along the axes, and " +
                                                  in_quotes(direction.id) +
                                                  " is a direction of its own");
  }
  const Fleet& fleet = *spec_.fleet;
  if (fleet.robots < 1) fail("fleet.robots", "0 is not allowed; a fleet has at least 1 robot");
  const auto check_point = [](const std::array<double, 2>& point, const std::string& place) {
    for (std::size_t axis = 0; axis < point.size(); ++axis)
      require_finite(point[axis], element(place, axis));
  };
  check_point(fleet.depot, "fleet.depot");
  for (std::size_t i = 0; i < fleet.sites.size(); ++i)
    check_point(fleet.sites[i], element("fleet.sites", i));
}

std::optional<Vector3> Problem::place(ConnectionIndex c) const {
  if (spec_.connections[c].position) return spec_.connections[c].position;
  const auto& first = spec_.parts[ends_[c][0]].position;
  const auto& second = spec_.parts[ends_[c][1]].position;
  if (!first || !second) return std::nullopt;
  Vector3 middle{};
  for (std::size_t axis = 0; axis < middle.size(); ++axis)
    middle[axis] = ((*first)[axis] + (*second)[axis]) / 2;
  return middle;
}

std::optional<ConnectionIndex> Problem::first_uncertain() const {
  const auto found = std::ranges::find_if(
      spec_.connections, [](const Connection& connection) { return connection.success < 1; });
  if (found == spec_.connections.end()) return std::nullopt;
  return static_cast<ConnectionIndex>(found - spec_.connections.begin());
}

bool Problem::only_retries() const {
  return uncertain() && std::ranges::all_of(spec_.connections, [](const Connection& connection) {
           return connection.success >= 1 || connection.on_failure.retries();
         });
}

ConnectionIndex Problem::find_connection(const std::string& id, const std::string& place) const {
  const auto found = connection_by_id_.find(id);
  if (found == connection_by_id_.end()) {
    fail(place,
         "no connection " + in_quotes(id) + "; " + available(spec_.connections, "connection"));
  }
  return found->second;
}

PartIndex Problem::find_part(const std::string& id, const std::string& place) const {
  const auto found = part_by_id_.find(id);
  if (found == part_by_id_.end())
    fail(place, "no part " + in_quotes(id) + "; " + available(spec_.parts, "part"));
  return found->second;
}

Problem Problem::with_objective(Objective objective) const {
  ProblemSpec changed = spec_;
  changed.objective = std::move(objective);
  return Problem(std::move(changed));
}

Problem Problem::with_direction(Direction direction) const {
  ProblemSpec changed = spec_;
  changed.direction = direction;
  return Problem(std::move(changed));
}

Problem Problem::with_limits(Limits limits) const {
  ProblemSpec changed = spec_;
  changed.limits = limits;
  return Problem(std::move(changed));
}

}  // namespace orasp
