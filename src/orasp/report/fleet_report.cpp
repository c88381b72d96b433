#include "orasp/report/fleet_report.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "orasp/fleet/fleet_validate.h"
#include "orasp/io/detail/json_text.h"
#include "orasp/model/detail/wording.h"
#include "orasp/model/tolerance.h"
#include "orasp/planners/planner_support.h"
#include "orasp/report/detail/report_page.h"

namespace orasp {
namespace {

using detail::counted;
using detail::in_quotes;
using detail::number_or_null;
using detail::page_number;
using nlohmann::ordered_json;

std::string amount(FleetObjective objective, double reward) {
  return objective == FleetObjective::Makespan
             ? counted(static_cast<std::uint64_t>(std::llround(0.0 - reward)), "step")
             : page_number(0.0 - reward) + " m\u00b2";
}

/// A label for each part, the same for parts in one piece: the position of its first part.
std::vector<PartIndex> labels_of(const Problem& problem, const ConnectionSet& present) {
  std::vector<PartIndex> label(problem.num_parts());
  std::iota(label.begin(), label.end(), PartIndex{0});
  for (bool changed = true; changed;) {
    changed = false;
    for_each_connection(present.view(), [&](ConnectionIndex c) {
      const auto [a, b] = problem.ends(c);
      const PartIndex least = std::min(label[a], label[b]);
      changed = changed || label[a] != least || label[b] != least;
      label[a] = label[b] = least;
    });
  }
  return label;
}

ordered_json state_json(const std::vector<PartIndex>& labels,
                        const std::vector<PlaceIndex>& places) {
  return {{"labels", labels}, {"places", places}};
}

/// Numbers of pieces and of those with two or more parts.
ordered_json counts_json(const std::vector<PartIndex>& labels) {
  std::map<PartIndex, std::size_t> sizes;
  for (const PartIndex label : labels) ++sizes[label];
  const auto subassemblies =
      std::ranges::count_if(sizes, [](const auto& piece) { return piece.second > 1; });
  return {sizes.size(), subassemblies};
}

std::string motion_back(Motion motion) {
  return std::string(
      motion_name(motion == kStay ? kStay : motion_along(opposite(direction_of(motion)))));
}

ordered_json move_json(const FleetMove& move) {
  return {{"robots", move.robots},
          {"parts", move.parts},
          {"from", move.from},
          {"to", move.to},
          {"motion", {std::string(motion_name(move.motion)), motion_back(move.motion)}},
          {"distance", number_or_null(move.distance)}};
}

/// What allows a step, as of one robot: [constraint, place, taken apart, put together].
ordered_json why_json(const FleetProblem& fleet, const FleetStep& step, std::size_t number,
                      const std::map<ConnectionIndex, std::size_t>& cut_at, std::size_t total,
                      std::size_t subassemblies_before, std::size_t subassemblies_after) {
  const Problem& problem = fleet.problem();
  ordered_json why = ordered_json::array();
  why.push_back({"robots", "fleet.robots",
                 fmt::format("{} of {} work", step.robots_used, counted(fleet.robots(), "robot"))});
  why.push_back(
      {"max_subassemblies", "fleet.sites",
       fmt::format("leaves {} of at most {} subassemblies, one a site", subassemblies_after,
                   fleet.most_subassemblies()),
       fmt::format("starts from {} and leaves {} of at most {} subassemblies, one a site",
                   subassemblies_after, subassemblies_before, fleet.most_subassemblies())});
  for (const PrecedenceClause& clause : problem.precedence()) {
    if (std::ranges::find(step.cut, clause.connection) == step.cut.end()) continue;
    std::string off;
    std::string on;
    for (const ConnectionIndex other : clause.after) {
      const auto found = cut_at.find(other);
      if (found == cut_at.end() || found->second > number) continue;
      const std::string id = in_quotes(problem.connection_id(other));
      off += fmt::format("{}{} (step {})", off.empty() ? "" : ", ", id, found->second);
      on += fmt::format("{}{} (step {})", on.empty() ? "" : ", ", id, total + 1 - found->second);
    }
    if (off.empty()) continue;
    const std::string id = in_quotes(problem.connection_id(clause.connection));
    why.push_back({"precedence", fmt::format("precedence[{}]", clause.entry),
                   fmt::format("{} goes only after {}", id, off),
                   fmt::format("{} is made before {}", id, on)});
  }
  return why;
}

struct Verdict {
  std::string_view name;
  std::string sentence;
};

Verdict verdict_of(const FleetProblem& fleet, const FleetReport& report,
                   const FleetEvaluation& evaluation, double reward) {
  if (!evaluation.valid)
    return {"not valid", counted(evaluation.violations.size(), "violation") +
                             ": this plan breaks the rules, which are named below."};
  const std::optional<double> bound = report.best.shown_bound();
  const std::string own = amount(fleet.objective(), reward);
  const std::string_view verb = fleet.objective() == FleetObjective::Makespan ? "takes" : "travels";
  if (bound && detail::meets(reward, *bound))
    return {"optimal", fmt::format("Proved optimal: no plan {} less than {}.", verb, own)};
  if (bound)
    return {"feasible",
            fmt::format("Not proved optimal: this plan {} {}, and none {} less than {}.", verb, own,
                        verb, amount(fleet.objective(), *bound))};
  return {"feasible", "Not proved optimal, and no bound is known."};
}

ordered_json plan_json(const FleetProblem& fleet, const FleetReport& report,
                       const FleetReportPlan& shown) {
  const Problem& problem = fleet.problem();
  const FleetPlan& plan = shown.plan;
  const FleetEvaluation evaluation = evaluate(fleet, plan);
  const std::size_t n = plan.steps.size();
  std::map<ConnectionIndex, std::size_t> cut_at;
  for (std::size_t k = 0; k < n; ++k) {
    for (const ConnectionIndex c : plan.steps[k].cut) cut_at.emplace(c, k + 1);
  }
  std::vector<std::vector<std::pair<std::string, std::string>>> broken(n + 1);
  ordered_json violations = ordered_json::array();
  for (const FleetViolation& found : evaluation.violations) {
    violations.push_back({found.step, found.connection, rule_name(found.rule), found.message});
    if (found.step > 0 && found.step <= n)
      broken[found.step].emplace_back(rule_name(found.rule), found.message);
  }

  const auto reward_of = [&](const FleetStep& step) {
    return fleet.objective() == FleetObjective::Makespan ? -1.0 : 0.0 - step.distance;
  };
  double rest = 0;
  for (const FleetStep& step : plan.steps) rest += reward_of(step);
  const double reward = rest;

  ConnectionSet present = ConnectionSet::all(problem.num_connections());
  std::vector<PlaceIndex> places = plan.start;
  places.resize(problem.num_parts(), kDepot);
  std::vector<PartIndex> labels = labels_of(problem, present);
  ordered_json states = {counts_json(labels)};
  ordered_json world = {state_json(labels, places)};
  ordered_json steps = ordered_json::array();
  double total = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const FleetStep& step = plan.steps[k];
    std::set<PartIndex> moved;
    ordered_json moves = ordered_json::array();
    for (const FleetMove& move : step.moves) {
      moves.push_back(move_json(move));
      for (const PartIndex part : move.parts) {
        moved.insert(part);
        if (part < places.size()) places[part] = move.to;
      }
    }
    for (const ConnectionIndex c : step.cut) present.erase(c);
    const std::size_t before = states.back()[1];
    labels = labels_of(problem, present);
    states.push_back(counts_json(labels));
    world.push_back(state_json(labels, places));
    total += reward_of(step);
    ordered_json entry = {
        {"cut", step.cut},
        {"reward", number_or_null(reward_of(step))},
        {"total", number_or_null(total)},
        {"back", number_or_null(rest)},
        {"moved", moved},
        {"moves", std::move(moves)},
        {"robots", step.robots_used},
        {"why", why_json(fleet, step, k + 1, cut_at, n, before, states.back()[1])}};
    rest -= reward_of(step);
    if (!broken[k + 1].empty()) entry["broken"] = broken[k + 1];
    steps.push_back(std::move(entry));
  }

  const Verdict verdict = verdict_of(fleet, report, evaluation, reward);
  const std::optional<double> bound = report.best.shown_bound();
  ordered_json gap;
  if (bound && evaluation.valid) gap = detail::meets(reward, *bound) ? 0.0 : *bound - reward;
  return {{"label", shown.label},
          {"origin", shown.origin},
          {"status", verdict.name},
          {"verdict", verdict.sentence},
          {"valid", evaluation.valid},
          {"reward", number_or_null(reward)},
          {"expected", false},
          {"gap", std::move(gap)},
          {"makespan", evaluation.makespan},
          {"travel", number_or_null(evaluation.travel)},
          {"notes", shown.notes},
          {"violations", std::move(violations)},
          {"labels", world.front()["labels"]},
          {"states", std::move(states)},
          {"world", std::move(world)},
          {"steps", std::move(steps)}};
}

ordered_json best_json(const FleetProblem& fleet, const FleetReport& report) {
  const Result& best = report.best;
  const std::optional<double> bound = best.shown_bound();
  std::string sentence;
  if (best.status != Status::Optimal) {
    sentence = bound
                   ? fmt::format("No plan is below {}, proved.", amount(fleet.objective(), *bound))
                   : std::string("No bound is known.");
  } else if (fleet.objective() == FleetObjective::Makespan) {
    sentence = fmt::format("The fewest steps are {}, proved.", best.fleet_plan.makespan());
  } else {
    sentence = fmt::format(
        "The least travel is {}, proved{}.", amount(fleet.objective(), best.reward),
        best.steps_allowed ? fmt::format(" for {}", counted(*best.steps_allowed, "step")) : "");
  }
  return detail::proved_facts(best, std::move(sentence), "", report.effort, {});
}

}  // namespace

std::string report_data(const FleetProblem& fleet, const FleetReport& report) {
  const Problem& problem = fleet.problem();
  ordered_json described = detail::report_problem(problem);
  described["objective"] =
      fleet.objective() == FleetObjective::Makespan
          ? ordered_json({"makespan", "as few steps as can be, each costing 1"})
          : ordered_json({"fleet_travel", "the least squared distance of all parts, in m\u00b2"});
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    described["constraints"].push_back(
        {"axis", fmt::format("connections[{}].axis", c),
         fmt::format("{} comes apart as {} moves along {} off {}",
                     in_quotes(problem.connection_id(c)),
                     in_quotes(problem.part_id(problem.ends(c)[0])), kDirectionNames[fleet.axis(c)],
                     in_quotes(problem.part_id(problem.ends(c)[1])))});
  }
  ordered_json places = ordered_json::array();
  for (PlaceIndex place = 0; place < fleet.num_places(); ++place)
    places.push_back(FleetProblem::place_name(place));
  ordered_json plans = ordered_json::array();
  for (const FleetReportPlan& plan : report.plans) plans.push_back(plan_json(fleet, report, plan));
  return detail::script_text(
      {{"format", "orasp-report/1"},
       {"version", ORASP_VERSION},
       {"title", report.title},
       {"problem", std::move(described)},
       {"fleet", {{"robots", fleet.robots()}, {"places", std::move(places)}}},
       {"best", best_json(fleet, report)},
       {"plans", std::move(plans)},
       {"graph", nullptr},
       {"learning", nullptr},
       {"sample", nullptr}});
}

std::string report_html(const FleetProblem& fleet, const FleetReport& report) {
  return detail::report_page(report.title, report_data(fleet, report),
                             detail::has_positions(fleet.problem()));
}

}  // namespace orasp
