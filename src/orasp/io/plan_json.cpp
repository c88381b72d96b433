#include "orasp/io/plan_json.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "orasp/explain/plan_order.h"
#include "orasp/fleet/fleet.h"
#include "orasp/io/detail/json_document.h"
#include "orasp/io/detail/json_text.h"
#include "orasp/io/problem_json.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/operations.h"
#include "orasp/model/plan_check.h"
#include "orasp/model/tolerance.h"
#include "orasp/model/validate.h"

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

/// The ids in quotes, ready to be written: a long plan names each part in thousands of steps.
template <class Items>
std::vector<std::string> quoted_ids(const Items& items) {
  std::vector<std::string> ids;
  ids.reserve(items.size());
  for (const auto& item : items) ids.push_back(inline_text(item.id));
  return ids;
}

template <class Indices>
std::string id_list(const Indices& indices, const std::vector<std::string>& ids) {
  std::string text = "[";
  for (const auto index : indices) {
    if (text.size() > 1) text += ", ";
    text += ids[index];
  }
  return text + "]";
}

std::string steps_text(const Problem& problem, const std::vector<Step>& steps,
                       const std::vector<std::string>& part_ids,
                       const std::vector<std::string>& connection_ids) {
  std::vector<std::string> direction_names;
  for (const DirectionIndex d : problem.directions()) {
    direction_names.resize(std::max<std::size_t>(direction_names.size(), d + 1U));
    direction_names[d] = inline_text(problem.direction_name(d));
  }
  if (steps.empty()) return "[]";
  const bool by_part = problem.spec().action == StepKind::Part;
  std::string text = "[";
  double total = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Step& step = steps[i];
    total += step.reward;
    text += i == 0 ? "\n" : ",\n";
    const std::string taken = by_part
                                  ? R"("connections": )" + id_list(step.connections, connection_ids)
                                  : R"("connection": )" + connection_ids[step.connection];
    text += fmt::format(R"(    {{"step": {}, {}, "reward": {}, "total": {}, )"
                        R"("separates": {}, "pieces": )",
                        i + 1, taken, inline_text(number_or_null(step.reward)),
                        inline_text(number_or_null(total)), step.separates);
    if (step.separates) {
      text += "[" + id_list(step.a, part_ids) + ", " + id_list(step.b, part_ids) +
              R"(], "moved": )" + id_list(step.moved(), part_ids);
    } else {
      text += R"([], "moved": [])";
    }
    if (step.direction) {
      text += R"(, "direction": )" + direction_names[*step.direction] + R"(, "free_directions": )" +
              id_list(step.free_directions, direction_names);
    }
    text += "}";
  }
  return text + "\n  ]";
}

/// The connections in the order in which they are handled, where steps take several: a list of
/// lists.
std::string lists_text(const std::vector<PlanStep>& steps, bool backwards,
                       const std::vector<std::string>& connection_ids) {
  std::string text = "[";
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (i > 0) text += ", ";
    text += id_list(steps[backwards ? steps.size() - 1 - i : i].connections, connection_ids);
  }
  return text + "]";
}

std::string operations_text(const std::vector<Step>& steps, Direction direction,
                            const Problem& problem, const std::vector<std::string>& part_ids) {
  if (steps.empty()) return "[]";
  std::string text = "[";
  for (const Operation& operation : operations(steps, direction)) {
    text += text.size() > 1 ? ",\n" : "\n";
    text += R"(    {"steps": [)";
    for (std::size_t i = operation.first; i < operation.end; ++i)
      text += fmt::format("{}{}", i == operation.first ? "" : ", ", i + 1);
    text += R"(], "moved": )";
    if (!operation.moving) {
      text += "[]}";
      continue;
    }
    const Step& moving = steps[*operation.moving];
    text += id_list(moving.moved(), part_ids);
    if (moving.direction)
      text += R"(, "direction": )" + inline_text(problem.direction_name(*moving.direction));
    text += "}";
  }
  return text + "\n  ]";
}

ordered_json ids_json(const std::vector<ConnectionIndex>& connections, const Problem& problem) {
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

std::string fleet_steps_text(const FleetPlan& plan, const Problem& problem) {
  if (plan.steps.empty()) return "[]";
  const bool travels = problem.objective().type == "fleet_travel";
  std::string text = "[";
  double total = 0;
  for (std::size_t i = 0; i < plan.steps.size(); ++i) {
    const FleetStep& step = plan.steps[i];
    const double reward = travels ? 0.0 - step.distance : -1.0;
    total += reward;
    text += fmt::format("{}\n    {{\"step\": {}, \"connections\": {}, \"moves\": [",
                        i == 0 ? "" : ",", i + 1, inline_text(ids_json(step.cut, problem)));
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

/// Pairs of step numbers, from 1.
std::string order_text(const std::vector<OrderedPair>& pairs) {
  std::string text = "[";
  for (const auto& [early, late] : pairs) {
    text += text.size() > 1 ? ", [" : "[";
    text.append(std::to_string(early + 1))
        .append(", ")
        .append(std::to_string(late + 1))
        .append("]");
  }
  return text + "]";
}

/// Decimal digits as a number, or past 2^53, which not every reader of JSON holds exactly, as a
/// string.
std::string exact_integer(const std::string& digits) {
  constexpr std::string_view kLargest = "9007199254740992";
  const bool fits =
      digits.size() < kLargest.size() || (digits.size() == kLargest.size() && digits <= kLargest);
  return fits ? digits : inline_text(digits);
}

std::string most_likely_text(const Expectation& expectation,
                             const std::vector<std::string>& connection_ids) {
  std::string attempts;
  for (const auto& [connection, succeeds] : expectation.most_likely) {
    attempts += attempts.empty() ? "" : ", ";
    attempts += fmt::format(R"({{"connection": {}, "succeeds": {}}})", connection_ids[connection],
                            succeeds);
  }
  return fmt::format(R"({{"probability": {}, "attempts": [{}]}})",
                     inline_text(number_or_null(expectation.probability)), attempts);
}

std::string alternatives_text(const std::vector<Alternative>& plans, bool is_assembly,
                              const std::vector<std::string>& connection_ids) {
  if (plans.empty()) return "[]";
  std::string text = "[";
  for (const Alternative& plan : plans) {
    const bool by_part = std::ranges::any_of(
        plan.steps, [](const PlanStep& step) { return step.connections.size() > 1; });
    const std::string forward = by_part ? lists_text(plan.steps, false, connection_ids)
                                        : id_list(plan.sequence, connection_ids);
    const std::string backward =
        by_part
            ? lists_text(plan.steps, true, connection_ids)
            : id_list(std::vector(plan.sequence.rbegin(), plan.sequence.rend()), connection_ids);
    text += text.size() > 1 ? ",\n" : "\n";
    text += fmt::format(R"(    {{"reward": {}, "disassembly": {}, "assembly": {}}})",
                        inline_text(number_or_null(plan.reward)), is_assembly ? backward : forward,
                        is_assembly ? forward : backward);
  }
  return text + "\n  ]";
}

std::string statistics_text(const Statistics& statistics) {
  return inline_text({{"states", statistics.states},
                      {"actions", statistics.actions},
                      {"expanded", statistics.expanded},
                      {"generated", statistics.generated},
                      {"reopened", statistics.reopened},
                      {"pruned", statistics.pruned},
                      {"sweeps", statistics.sweeps},
                      {"seconds", number_or_null(statistics.seconds)},
                      {"peak_bytes", statistics.peak_bytes}});
}

std::string options_text(const std::map<std::string, std::string>& options) {
  std::string text = "{";
  for (const auto& [name, value] : options) {
    if (text.size() > 1) text += ", ";
    text += inline_text(name) + ": " + value;
  }
  return text + "}";
}

std::vector<std::string> read_ids(JsonValue list, const std::string& place) {
  std::vector<std::string> ids;
  list.for_each([&](JsonValue id) {
    if (!id.is(JsonKind::String)) {
      throw InputError(fmt::format("{}[{}]: expected a connection id, which is a string, found {}",
                                   place, ids.size(), id.description()));
    }
    ids.emplace_back(id.string());
  });
  return ids;
}

/// What the steps of a plan take: an id, or a list of them where steps take several.
std::vector<std::vector<std::string>> read_steps(JsonValue list, std::string_view place) {
  if (!list.is(JsonKind::Array)) {
    throw InputError(
        detail::at(place, "expected an array of connection ids, found " + list.description()));
  }
  std::vector<std::vector<std::string>> steps;
  list.for_each([&](JsonValue step) {
    const std::string here = fmt::format("{}[{}]", place, steps.size());
    if (step.is(JsonKind::Array)) {
      steps.push_back(read_ids(step, here));
    } else if (step.is(JsonKind::String)) {
      steps.push_back({std::string(step.string())});
    } else {
      throw InputError(here + ": expected a connection id, which is a string, found " +
                       step.description());
    }
  });
  return steps;
}

/// The steps of a plan file, taken apart.
PlanFile plan_of(const std::vector<std::vector<std::string>>& steps) {
  PlanFile plan;
  for (const std::vector<std::string>& step : steps) {
    plan.sequence.insert(plan.sequence.end(), step.begin(), step.end());
    plan.sizes.push_back(step.size());
  }
  if (std::ranges::all_of(plan.sizes, [](std::size_t size) { return size == 1; }))
    plan.sizes.clear();
  return plan;
}

/// What the steps of a plan file state as the direction of each connection of `sequence`; empty if
/// none of them states one. Nothing else of the steps is read.
std::vector<std::string> read_directions(JsonValue steps,
                                         const std::vector<std::string>& sequence) {
  std::vector<std::string> directions;
  if (!steps.is(JsonKind::Array)) return directions;
  std::unordered_map<std::string_view, std::size_t> places;
  std::size_t number = 0;
  steps.for_each([&](JsonValue step) {
    const std::string place = fmt::format("steps[{}]", number++);
    if (!step.is(JsonKind::Object)) return;
    std::vector<std::string> taken;
    std::optional<JsonValue> direction;
    step.for_each([&](JsonValue member) {
      if (member.key() == "connection" && member.is(JsonKind::String))
        taken = {std::string(member.string())};
      if (member.key() == "connections" && member.is(JsonKind::Array))
        taken = read_ids(member, place + ".connections");
      if (member.key() == "direction") direction = member;
    });
    if (!direction) return;
    if (!direction->is(JsonKind::String)) {
      throw InputError(fmt::format("{}.direction: expected the name of a direction, found {}",
                                   place, direction->description()));
    }
    if (taken.empty()) throw InputError(place + ": it states a direction, but no connection");
    if (directions.empty()) {
      directions.resize(sequence.size());
      for (std::size_t i = 0; i < sequence.size(); ++i) places.emplace(sequence[i], i);
    }
    for (const std::string& id : taken) {
      const auto found = places.find(id);
      if (found != places.end()) directions[found->second] = direction->string();
    }
  });
  return directions;
}

PlanFile read_plan_object(JsonValue root, Direction direction) {
  const bool is_assembly = direction == Direction::Assembly;
  const std::string_view wanted_key = is_assembly ? "assembly" : "disassembly";
  const std::string_view other_key = is_assembly ? "disassembly" : "assembly";
  std::optional<JsonValue> format;
  std::optional<JsonValue> digest;
  std::optional<JsonValue> wanted;
  std::optional<JsonValue> other;
  std::optional<JsonValue> steps;
  root.for_each([&](JsonValue member) {
    if (member.key() == "format") format = member;
    if (member.key() == "problem_digest") digest = member;
    if (member.key() == wanted_key) wanted = member;
    if (member.key() == other_key) other = member;
    if (member.key() == "steps") steps = member;
  });
  if (!format) throw InputError("the key \"format\" is missing");
  if (!format->is(JsonKind::String))
    throw InputError("format: expected a string, found " + format->description());
  if (format->string() != kFormat) {
    throw InputError(fmt::format("format: {} is not the format of a plan; that is \"{}\"",
                                 in_quotes(format->string()), kFormat));
  }
  if (!wanted && !other)
    throw InputError(R"(the key "disassembly" or "assembly" is missing, one of them is needed)");

  std::optional<std::vector<std::vector<std::string>>> reversed;
  if (other) {
    reversed = read_steps(*other, other_key);
    std::ranges::reverse(*reversed);
  }
  const std::vector<std::vector<std::string>> taken =
      wanted ? read_steps(*wanted, wanted_key) : *reversed;
  if (reversed && taken != *reversed)
    throw InputError("assembly: it is not the reverse of \"disassembly\"");
  PlanFile plan = plan_of(taken);
  if (digest) {
    if (!digest->is(JsonKind::String)) {
      throw InputError("problem_digest: expected a string, found " + digest->description());
    }
    plan.problem_digest = digest->string();
  }
  if (steps) plan.directions = read_directions(*steps, plan.sequence);
  return plan;
}

/// A step a line: an id, or several with tabs between them.
PlanFile read_lines(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  if (const auto byte = detail::ill_formed_utf8(text)) {
    const auto line = std::ranges::count(text.substr(0, *byte), '\n') + 1;
    throw InputError(fmt::format("line {}: the byte 0x{:02x} is not valid UTF-8", line,
                                 static_cast<unsigned char>(text[*byte])));
  }
  const auto trimmed = [&](std::string_view part) {
    part.remove_prefix(std::min(part.find_first_not_of(kBlank), part.size()));
    return part.substr(0, part.find_last_not_of(kBlank) + 1);
  };
  std::vector<std::vector<std::string>> steps;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    line = trimmed(line);
    if (line.empty() || line.front() == '#') continue;
    std::vector<std::string>& step = steps.emplace_back();
    while (true) {
      const std::size_t tab = line.find('\t');
      if (const std::string_view id = trimmed(line.substr(0, tab)); !id.empty())
        step.emplace_back(id);
      if (tab == std::string_view::npos) break;
      line.remove_prefix(tab + 1);
    }
  }
  return plan_of(steps);
}

/// What of a plan file depends on how many robots there are.
struct PlanBody {
  double reward = -kInfinity;
  /// In the order of the problem's direction.
  std::vector<ConnectionIndex> sequence;
  /// The same step by step, where steps take several.
  std::vector<PlanStep> part_steps;
  /// The text of `stays`; empty: the key is left out.
  std::string stays;
  std::string steps = "[]";
  /// The text of `operations`; empty: the key is left out.
  std::string operations;
  /// The text of `order`; empty: the key is left out.
  std::string order;
  /// The text of `fleet`; empty: the key is left out.
  std::string fleet;
};

/// The directions that the steps have, checked by themselves.
void require_free_directions(const Task& task, const std::vector<Step>& steps) {
  if (task.problem.directions().empty()) return;
  std::vector<PlanStep> directed;
  for (const Step& step : steps) directed.push_back({step.connections, step.direction});
  const PlanCheck check = check_plan(task.problem, task.situation, directed);
  if (!check.legal)
    throw std::logic_error("a direction was chosen that is not free: " + check.fault);
}

PlanBody body_of_one_robot(const Task& task, const Result& result,
                           const std::vector<std::string>& connection_ids) {
  PlanBody body;
  body.sequence = result.sequence;
  body.operations = "[]";
  const TransitionSystem system(task.problem, task.situation);
  // What the order of single connections keeps legal is known where they are all there is to steps.
  const bool whole = task.whole() && !system.wide();
  if (whole) body.order = "[]";
  if (!result.has_plan()) return body;
  const Evaluation evaluation = evaluate(system, result);
  if (task.problem.spec().action == StepKind::Part) body.part_steps = result.steps;
  if (task.problem.spec().goal) body.stays = id_list(evaluation.stays, connection_ids);
  // Where attempts may fail, the reward is an expectation, which no replay gives.
  body.reward = result.expectation ? result.reward : evaluation.reward;
  require_free_directions(task, evaluation.steps);
  const std::vector<std::string> part_ids = quoted_ids(task.problem.parts());
  body.steps = steps_text(task.problem, evaluation.steps, part_ids, connection_ids);
  body.operations =
      operations_text(evaluation.steps, task.problem.direction(), task.problem, part_ids);
  if (whole) body.order = order_text(plan_order(task.problem, result.sequence));
  return body;
}

PlanBody body_of_fleet(const Task& task, const Result& result) {
  PlanBody body;
  const FleetPlan& plan = result.fleet_plan;
  if (result.has_plan()) body.reward = result.reward;
  body.sequence = plan.sequence();
  body.steps = fleet_steps_text(plan, task.problem);
  ordered_json summary = {{"objective", task.problem.objective().type}};
  if (result.steps_allowed) summary["steps_allowed"] = *result.steps_allowed;
  summary["makespan"] = result.has_plan() ? ordered_json(plan.makespan()) : nullptr;
  summary["travel"] = result.has_plan() ? number_or_null(plan.travel()) : nullptr;
  body.fleet = inline_text(summary);
  return body;
}

}  // namespace

std::string plan_text(const Task& task, const Result& result,
                      const std::map<std::string, std::string>& options,
                      const Alternatives* alternatives,
                      const std::map<std::string, std::string>& more) {
  const Problem& problem = task.problem;
  const std::vector<std::string> connection_ids = quoted_ids(problem.connections());
  const PlanBody body = problem.objective().of_fleet()
                            ? body_of_fleet(task, result)
                            : body_of_one_robot(task, result, connection_ids);

  // A bound and a reward are sums of the same numbers in another order: what rounding did to them
  // is not a gap.
  const double reward = body.reward;
  std::optional<double> bound = result.bound;
  if (result.status == Status::Optimal) bound = reward;
  if (bound) bound = std::max(*bound, reward);
  const bool has_gap = bound && result.has_plan();

  const std::string forward = id_list(body.sequence, connection_ids);
  const std::string backward =
      id_list(std::vector(body.sequence.rbegin(), body.sequence.rend()), connection_ids);
  const bool is_assembly = problem.direction() == Direction::Assembly;

  std::string text = "{\n  \"format\": " + inline_text(kFormat);
  const auto put = [&text](std::string_view key, std::string_view value) {
    text.append(",\n  \"").append(key).append("\": ").append(value);
  };
  put("problem", inline_text(problem.name()));
  put("problem_digest", inline_text(problem_digest(problem)));
  put("method", inline_text(result.method));
  put("status", inline_text(status_name(result.status)));
  if (result.stop != Stop::None) put("stopped", inline_text(stop_name(result.stop)));
  put("reward", inline_text(number_or_null(reward)));
  put("bound", inline_text(bound ? number_or_null(*bound) : nullptr));
  put("gap", inline_text(has_gap ? number_or_null(*bound - reward) : nullptr));
  if (result.expectation && result.has_plan()) {
    put("expected", inline_text({{"reward", number_or_null(reward)},
                                 {"attempts", number_or_null(result.expectation->attempts)},
                                 {"residual", number_or_null(result.expectation->residual)},
                                 {"error", number_or_null(result.expectation->error)}}));
    put("most_likely", most_likely_text(*result.expectation, connection_ids));
  }
  if (!body.fleet.empty()) put("fleet", body.fleet);
  if (problem.spec().action == StepKind::Part) {
    put("disassembly", lists_text(body.part_steps, is_assembly, connection_ids));
    put("assembly", lists_text(body.part_steps, !is_assembly, connection_ids));
  } else {
    put("disassembly", is_assembly ? backward : forward);
    put("assembly", is_assembly ? forward : backward);
  }
  if (!body.stays.empty()) put("stays", body.stays);
  put("steps", body.steps);
  if (!body.operations.empty()) put("operations", body.operations);
  if (!body.order.empty()) put("order", body.order);
  for (const auto& [name, value] : more) put(name, value);
  if (alternatives != nullptr) {
    if (alternatives->optimal_sequences)
      put("optimal_sequences", exact_integer(*alternatives->optimal_sequences));
    if (alternatives->optimal_up_to_symmetry)
      put("optimal_up_to_symmetry", exact_integer(*alternatives->optimal_up_to_symmetry));
    if (alternatives->plans)
      put("alternatives", alternatives_text(*alternatives->plans, is_assembly, connection_ids));
  }
  put("statistics", statistics_text(result.statistics));
  put("seed", std::to_string(result.seed));
  put("options", options_text(options));
  if (!result.notes.empty()) put("notes", inline_text(result.notes));
  return text + "\n}\n";
}

std::string plan_text(const Problem& problem, const Result& result,
                      const std::map<std::string, std::string>& options,
                      const Alternatives* alternatives) {
  return plan_text(Task(problem), result, options, alternatives);
}

std::vector<PlanStep> plan_steps(const Problem& problem, const PlanFile& plan) {
  std::vector<PlanStep> steps;
  std::size_t next = 0;
  const std::size_t count = plan.sizes.empty() ? plan.sequence.size() : plan.sizes.size();
  for (std::size_t i = 0; i < count; ++i) {
    PlanStep& step = steps.emplace_back();
    const std::size_t size = plan.sizes.empty() ? 1 : plan.sizes[i];
    for (std::size_t k = 0; k < size; ++k) {
      const std::string place = fmt::format("step {}", i + 1);
      if (k == 0 && !plan.directions.empty())
        step.direction = problem.find_direction(plan.directions[next]);
      step.connections.push_back(problem.find_connection(plan.sequence[next++], place));
    }
  }
  return steps;
}

Evaluation replayed(const Problem& problem, const PlanFile& plan) {
  if (problem.spec().action == StepKind::Part)
    return evaluate(TransitionSystem(problem),
                    std::span<const PlanStep>(plan_steps(problem, plan)));
  return evaluate(problem, plan.sequence, plan.directions);
}

PlanFile parse_plan(std::string_view text, Direction direction) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) throw InputError("the file is empty");
  if (text[first] != '{' && text[first] != '[') return read_lines(text);
  const JsonDocument document = JsonDocument::parse(text);
  const JsonValue root = document.root();
  if (root.is(JsonKind::Array)) return plan_of(read_steps(root, ""));
  return read_plan_object(root, direction);
}

}  // namespace orasp
