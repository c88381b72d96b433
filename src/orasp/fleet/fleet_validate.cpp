#include "orasp/fleet/fleet_validate.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "orasp/model/detail/wording.h"

namespace orasp {
namespace {

using detail::in_quotes;
using detail::number_text;

/// The world as a plan is replayed in it.
class Replay {
 public:
  Replay(const FleetProblem& fleet, const FleetPlan& plan)
      : fleet_(fleet),
        problem_(fleet.problem()),
        plan_(plan),
        open_(problem_.num_connections(), true),
        place_(plan.start) {
    place_.resize(problem_.num_parts(), kDepot);
  }

  FleetEvaluation run() {
    group();
    check_places();
    check_number_of_subassemblies();
    for (const FleetStep& step : plan_.steps) {
      ++step_;
      take(step);
    }
    ++step_;
    for (ConnectionIndex c = 0; c < open_.size(); ++c) {
      if (open_[c])
        report(FleetRule::End, in_quotes(id(c)) + " is not cut by the end of the plan", c);
    }
    evaluation_.makespan = plan_.steps.size();
    evaluation_.valid = evaluation_.violations.empty();
    return std::move(evaluation_);
  }

 private:
  [[nodiscard]] const std::string& id(ConnectionIndex c) const { return problem_.connection_id(c); }
  [[nodiscard]] std::string part(PartIndex p) const {
    return "part " + in_quotes(problem_.part_id(p));
  }
  void report(FleetRule rule, std::string message, std::optional<ConnectionIndex> c = {}) {
    evaluation_.violations.push_back({step_, rule, c ? id(*c) : std::string(), std::move(message)});
  }

  /// Numbers the components of the parts under the open connections.
  void group() {
    group_.assign(problem_.num_parts(), problem_.num_parts());
    for (PartIndex first = 0; first < group_.size(); ++first) {
      if (group_[first] != problem_.num_parts()) continue;
      group_[first] = first;
      for (bool grows = true; grows;) {
        grows = false;
        for (ConnectionIndex c = 0; c < open_.size(); ++c) {
          const auto [i, j] = problem_.ends(c);
          if (!open_[c] || (group_[i] == first) == (group_[j] == first)) continue;
          group_[i] = group_[j] = first;
          grows = true;
        }
      }
    }
  }
  [[nodiscard]] std::size_t size_of(std::size_t group) const {
    return static_cast<std::size_t>(std::ranges::count(group_, group));
  }

  void check_places() {
    for (PartIndex i = 0; i < place_.size(); ++i) {
      const bool single = size_of(group_[i]) == 1;
      if (single && place_[i] != kDepot)
        report(FleetRule::Places, part(i) + " is single and at " +
                                      FleetProblem::place_name(place_[i]) +
                                      "; single parts go to the depot at once");
      if (!single && place_[i] == kDepot)
        report(FleetRule::Places, part(i) + " is in the depot and still part of a subassembly");
      for (PartIndex j = 0; j < i; ++j) {
        if (group_[i] == group_[j] && place_[i] != place_[j])
          report(FleetRule::Places,
                 part(j) + " and " + part(i) + " are in one subassembly and not at one site");
        if (group_[i] != group_[j] && place_[i] == place_[j] && place_[i] != kDepot)
          report(FleetRule::Places, part(j) + " and " + part(i) +
                                        " are in different subassemblies and both at " +
                                        FleetProblem::place_name(place_[i]));
      }
    }
  }

  void check_number_of_subassemblies() {
    const auto& most = problem_.limits().max_subassemblies;
    std::size_t subassemblies = 0;
    for (PartIndex i = 0; i < group_.size(); ++i) {
      if (group_[i] == i && size_of(i) > 1) ++subassemblies;
    }
    if (most && subassemblies > *most)
      report(FleetRule::MaxSubassemblies, "there are " + std::to_string(subassemblies) +
                                              " subassemblies; at most " + std::to_string(*most) +
                                              " are allowed");
  }

  void take(const FleetStep& step) {
    std::vector<Motion> motion(place_.size(), kStay);
    std::vector<PlaceIndex> to = place_;
    read_moves(step, motion, to);
    const std::vector<bool> open_before = open_;
    const std::vector<std::size_t> group_before = group_;
    cut(step, motion, open_before);
    group();

    for (PartIndex i = 0; i < place_.size(); ++i) {
      for (PartIndex j = 0; j < i; ++j) {
        if (group_[i] == group_[j] && motion[i] != motion[j])
          report(FleetRule::Motions, part(j) + " (" + std::string(motion_name(motion[j])) +
                                         ") and " + part(i) + " (" +
                                         std::string(motion_name(motion[i])) +
                                         ") move differently and stay in one subassembly");
      }
      if (motion[i] == kStay && to[i] != place_[i] && to[i] != kDepot)
        report(FleetRule::Motions,
               part(i) + " stays, so it cannot go to " + FleetProblem::place_name(to[i]));
      check_blocking(i, motion, group_before);
    }
    check_moved_blocks(motion, to);
    for (PartIndex i = 0; i < place_.size(); ++i)
      evaluation_.travel += fleet_.squared_distance(place_[i], to[i]);
    place_ = to;
    check_places();
    check_number_of_subassemblies();
  }

  void read_moves(const FleetStep& step, std::vector<Motion>& motion, std::vector<PlaceIndex>& to) {
    std::vector<bool> named(place_.size(), false);
    std::vector<bool> busy(fleet_.robots(), false);
    for (const FleetMove& move : step.moves) {
      double distance = 0;
      for (const PartIndex i : move.parts) {
        if (named[i]) report(FleetRule::Motions, part(i) + " is moved twice in one step");
        named[i] = true;
        if (move.from != place_[i])
          report(FleetRule::Places, part(i) + " is at " + FleetProblem::place_name(place_[i]) +
                                        ", not at " + FleetProblem::place_name(move.from));
        motion[i] = move.motion;
        to[i] = move.to;
        distance += fleet_.squared_distance(move.from, move.to);
      }
      if (std::abs(distance - move.distance) > 1e-9 * std::max(1.0, distance))
        report(FleetRule::Distance, "the move of " + part(move.parts.front()) + " covers " +
                                        number_text(distance) + " m^2, not " +
                                        number_text(move.distance));
      if (move.robots.size() != move.parts.size())
        report(FleetRule::Robots, "the move of " + part(move.parts.front()) + " takes " +
                                      std::to_string(move.parts.size()) +
                                      " robots, one for each part, and has " +
                                      std::to_string(move.robots.size()));
      for (const std::size_t robot : move.robots) {
        if (robot < 1 || robot > fleet_.robots()) {
          report(FleetRule::Robots, "there is no robot " + std::to_string(robot) +
                                        "; robots are 1 to " + std::to_string(fleet_.robots()));
        } else if (busy[robot - 1]) {
          report(FleetRule::Robots,
                 "robot " + std::to_string(robot) + " holds two parts in one step");
        } else {
          busy[robot - 1] = true;
        }
      }
    }
  }

  void cut(const FleetStep& step, const std::vector<Motion>& motion,
           const std::vector<bool>& open_before) {
    for (const ConnectionIndex c : step.cut) {
      if (!open_[c]) {
        report(FleetRule::Cut, in_quotes(id(c)) + " is cut already", c);
        continue;
      }
      open_[c] = false;
      const auto [i, j] = problem_.ends(c);
      const std::size_t away = fleet_.axis(c);
      const auto moves = [&](PartIndex p, std::size_t direction) {
        return motion[p] == motion_along(direction);
      };
      const bool first_leaves = moves(i, away) && (motion[j] == kStay || moves(j, opposite(away)));
      const bool second_leaves = moves(j, opposite(away)) && (motion[i] == kStay || moves(i, away));
      if (!first_leaves && !second_leaves)
        report(FleetRule::Cut,
               in_quotes(id(c)) + " comes apart when " + part(i) + " goes " +
                   kDirectionNames[away] + " off " + part(j) + ", not when they go " +
                   std::string(motion_name(motion[i])) + " and " +
                   std::string(motion_name(motion[j])),
               c);
      check_precedence(c, open_before);
    }
  }

  void check_precedence(ConnectionIndex c, const std::vector<bool>& open_before) {
    for (const PrecedenceClause& clause : problem_.precedence()) {
      if (clause.connection != c) continue;
      for (const ConnectionIndex early : clause.after) {
        if (open_before[early])
          report(FleetRule::Precedence,
                 in_quotes(id(early)) + " must be cut in an earlier step than " + in_quotes(id(c)),
                 c);
      }
      const bool none = !clause.after_any.empty() &&
                        std::ranges::all_of(clause.after_any, [&](ConnectionIndex early) {
                          return static_cast<bool>(open_before[early]);
                        });
      if (none)
        report(FleetRule::Precedence,
               "none of what " + in_quotes(id(c)) + " comes after was cut in an earlier step", c);
    }
  }

  void check_blocking(PartIndex i, const std::vector<Motion>& motion,
                      const std::vector<std::size_t>& group_before) {
    if (motion[i] == kStay) return;
    const std::size_t direction = direction_of(motion[i]);
    for (const Blocker& blocker : problem_.blockers()[i]) {
      const bool in_the_way = (blocker.directions >> direction & 1U) != 0;
      if (in_the_way && group_before[blocker.by] == group_before[i] &&
          motion[blocker.by] != motion[i])
        report(FleetRule::Blocking,
               part(blocker.by) + " blocks " + part(i) + " along " + kDirectionNames[direction]);
    }
  }

  /// A block is moved if its parts move, or leave the site.
  void check_moved_blocks(const std::vector<Motion>& motion, const std::vector<PlaceIndex>& to) {
    const Limits& limits = problem_.limits();
    for (PartIndex first = 0; first < place_.size(); ++first) {
      if (group_[first] != first || (motion[first] == kStay && to[first] == place_[first]))
        continue;
      std::size_t parts = 0;
      double mass = 0;
      for (PartIndex i = 0; i < place_.size(); ++i) {
        if (group_[i] != first) continue;
        ++parts;
        mass += problem_.parts()[i].mass;
      }
      if (limits.max_moved_parts && parts > *limits.max_moved_parts)
        report(FleetRule::MaxMovedParts,
               "the block of " + part(first) + " moves with " + std::to_string(parts) +
                   " parts; at most " + std::to_string(*limits.max_moved_parts) + " are allowed");
      if (limits.max_moved_mass && mass > *limits.max_moved_mass * (1 + 1e-9))
        report(FleetRule::MaxMovedMass,
               "the block of " + part(first) + " moves with " + number_text(mass) +
                   " kg; at most " + number_text(*limits.max_moved_mass) + " kg are allowed");
    }
  }

  const FleetProblem& fleet_;
  const Problem& problem_;
  const FleetPlan& plan_;
  std::vector<bool> open_;
  std::vector<PlaceIndex> place_;
  std::vector<std::size_t> group_;  ///< of each part: the first part of its component
  std::size_t step_ = 0;
  FleetEvaluation evaluation_;
};

}  // namespace

std::string_view rule_name(FleetRule rule) {
  switch (rule) {
    case FleetRule::Cut: return "cut";
    case FleetRule::Motions: return "motion";
    case FleetRule::Robots: return "robots";
    case FleetRule::Places: return "places";
    case FleetRule::Precedence: return "precedence";
    case FleetRule::Blocking: return "blocking";
    case FleetRule::MaxSubassemblies: return "max_subassemblies";
    case FleetRule::MaxMovedParts: return "max_moved_parts";
    case FleetRule::MaxMovedMass: return "max_moved_mass";
    case FleetRule::Distance: return "distance";
    case FleetRule::End: break;
  }
  return "end";
}

FleetEvaluation evaluate(const FleetProblem& fleet, const FleetPlan& plan) {
  return Replay(fleet, plan).run();
}

}  // namespace orasp
