#include "orasp/model/plan_check.h"

#include <cmath>

#include "orasp/model/detail/plan_replay.h"
#include "orasp/model/detail/wording.h"

namespace orasp {

namespace {

using detail::in_quotes;
using detail::number_text;
using detail::PlanDirectionFault;
using detail::PlanFault;

std::string sentence(const Problem& problem, const PlanDirectionFault& fault) {
  return "step " + std::to_string(fault.step) +
         (problem.direction() == Direction::Assembly ? " makes " : " removes ") +
         in_quotes(problem.connection_id(fault.connection)) + " and states the direction " +
         problem.direction_name(fault.direction) + ", in which " +
         in_quotes(problem.part_id(fault.by)) + " is in the way of " +
         in_quotes(problem.part_id(fault.part));
}

PlanCheck check_of(const Problem& problem, detail::PlanReplay replay, std::size_t steps) {
  PlanCheck check;
  check.legal = replay.faults.empty() && replay.direction_faults.empty();
  check.reward = replay.reward;
  check.rewards = std::move(replay.rewards);
  check.tolerance = replay.tolerance;
  if (check.legal) return check;
  const bool rule_first = replay.direction_faults.empty() ||
                          (!replay.faults.empty() &&
                           replay.faults.front().step <= replay.direction_faults.front().step);
  if (rule_first) {
    check.step = replay.faults.front().step;
    check.fault = detail::fault_sentence(problem, replay.faults.front(), steps);
  } else {
    check.step = replay.direction_faults.front().step;
    check.fault = sentence(problem, replay.direction_faults.front());
  }
  return check;
}

}  // namespace

std::string detail::fault_sentence(const Problem& problem, const PlanFault& fault,
                                   std::size_t steps) {
  const bool assembly = problem.direction() == Direction::Assembly;
  const Limits& limits = problem.limits();
  const auto subassemblies = [&] {
    return std::to_string(fault.amount) +
           " subassemblies; limits.max_subassemblies allows at most " +
           std::to_string(limits.max_subassemblies.value_or(0));
  };
  if (fault.step == 0 && fault.constraint == Constraint::MaxSubassemblies)
    return (assembly ? "the finished product is " : "the product at the start is ") +
           subassemblies();
  if (fault.step == 0 && fault.constraint == Constraint::Grounded)
    return std::string(assembly ? "where the work begins, " : "at the start, ") +
           in_quotes(problem.part_id(fault.part)) +
           " is in a subassembly without a base part, against limits.grounded";
  const std::string step = "step " + std::to_string(fault.step);
  if (fault.connection >= problem.num_connections()) {
    return step + " handles connection number " + std::to_string(fault.connection) +
           ", counted from 0; the problem has " + std::to_string(problem.num_connections());
  }
  const std::string id = in_quotes(problem.connection_id(fault.connection));
  const std::string clause = "precedence[" + std::to_string(fault.entry) + "]";
  if (fault.step == 0) return id + " can no longer be handled as " + clause + " asks";
  if (fault.step > steps) return "the plan ends and " + id + " is missing";
  const std::string does = step + (assembly ? " makes " : " removes ") + id;
  const std::string other = in_quotes(problem.connection_id(fault.other));
  const std::string cut = step + ", which " + (assembly ? "makes " : "removes ") + id + ", ";
  switch (fault.constraint) {
    case Constraint::Precedence:
      if (fault.other == fault.connection)
        return does + ", which by " + clause + " waits for itself";
      return does + " before " + other + ", against " + clause;
    case Constraint::PrecedenceAny:
      return does +
             (assembly ? ", after which " + other + " could no longer be made, against "
                       : " while all of after_any are there, against ") +
             clause;
    case Constraint::PrecedenceMadeAny:
      return does +
             (assembly ? " while none of made_after_any is there, against "
                       : ", after which " + other + " would lack what it needs, against ") +
             clause;
    case Constraint::MaxSubassemblies:
      return cut + (assembly ? "starts from " : "leaves ") + subassemblies();
    case Constraint::MaxMovedParts:
      return cut + "moves " + std::to_string(fault.amount) +
             " parts; limits.max_moved_parts allows at most " +
             std::to_string(limits.max_moved_parts.value_or(0));
    case Constraint::MaxMovedMass:
      return cut + "moves " + number_text(fault.mass) +
             " kg; limits.max_moved_mass allows at most " +
             number_text(limits.max_moved_mass.value_or(0)) + " kg";
    case Constraint::Grounded:
      return cut + (assembly ? "makes" : "leaves") +
             " a subassembly without a base part, against limits.grounded";
    case Constraint::Goal: return does + ", after the goal was reached, at which the plan ends";
    case Constraint::NotOneStep:
      return step +
             " takes connections that are not all of those between some parts and the rest "
             "of a piece, against \"action\": \"part\"";
    case Constraint::Blocking: return does + ", but blocking leaves no direction free for it";
    case Constraint::NotOpen:
      return does + (assembly ? ", which was made before" : ", which was removed before");
    case Constraint::Inaccessible: return does + ", which is inaccessible";
    case Constraint::NotNext: return does + ", which cannot be the next step";
    case Constraint::Late:
      return does + ", which is late, while " + other + " can be " +
             (assembly ? "made" : "removed");
  }
  return does;
}

PlanCheck check_plan(const Problem& problem, const Situation& situation,
                     std::span<const ConnectionIndex> sequence,
                     std::span<const std::optional<DirectionIndex>> directions) {
  return check_of(problem, detail::replay(problem, situation, sequence, false, directions),
                  sequence.size());
}

PlanCheck check_plan(const Problem& problem, const Situation& situation,
                     std::span<const PlanStep> steps) {
  return check_of(problem, detail::replay(problem, situation, steps, false), steps.size());
}

bool same_reward(double claimed, const PlanCheck& check) {
  if (std::isnan(claimed) || std::isnan(check.reward))
    return std::isnan(claimed) && std::isnan(check.reward);
  return claimed == check.reward || std::abs(claimed - check.reward) <= check.tolerance;
}

}  // namespace orasp
