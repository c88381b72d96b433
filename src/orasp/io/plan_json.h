#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "orasp/explain/alternatives.h"
#include "orasp/model/problem.h"
#include "orasp/model/validate.h"
#include "orasp/task/result.h"
#include "orasp/task/task.h"

namespace orasp {

/// A result as a plan file, format `orasp-plan/1` (docs/format.md), of one robot or of several: the
/// steps of one robot are replayed from the sequence by evaluate() of the model, not taken from the
/// method. Where `task` is the whole job of one robot, `order` says what of the order matters
/// (explain/plan_order.h). `options` are the caller's settings that shaped the result, name to
/// value, already JSON texts. `alternatives`: what else is known of the best plans, if asked for.
/// `more`: further members, name to JSON text. Ends with a newline.
[[nodiscard]] std::string plan_text(const Task& task, const Result& result,
                                    const std::map<std::string, std::string>& options,
                                    const Alternatives* alternatives = nullptr,
                                    const std::map<std::string, std::string>& more = {});

/// The same for the whole of a problem, which need not outlive the call.
[[nodiscard]] std::string plan_text(const Problem& problem, const Result& result,
                                    const std::map<std::string, std::string>& options,
                                    const Alternatives* alternatives = nullptr);

/// A plan as read: the ids in the order of the problem's direction.
struct PlanFile {
  std::vector<std::string> sequence{};
  /// How many of them each step takes; empty: one each.
  std::vector<std::size_t> sizes{};
  /// The direction that the file states for each step, "" where it states none; empty if it states
  /// none at all. They are found by the connections of `steps`.
  std::vector<std::string> directions{};
  std::string problem_digest;  ///< empty where the file is a bare list
};

/// What each step of a plan takes, by the numbers of connections, and the direction that it states.
/// @throws InputError `step 3: no connection "x"; ...`.
[[nodiscard]] std::vector<PlanStep> plan_steps(const Problem& problem, const PlanFile& plan);

/// The replay of a plan of one robot by evaluate() of the model, whatever its steps take.
/// @throws InputError where steps take several connections and some are not those of the problem.
[[nodiscard]] Evaluation replayed(const Problem& problem, const PlanFile& plan);

/// Reads a plan file, a JSON array of connection ids, or plain text with one id a line (empty lines
/// and lines that begin with '#' are skipped). Where steps take several connections a JSON array
/// has a list for each step, and a text has their ids with tabs between them. `direction` picks the
/// list: "disassembly" or "assembly". A bare list is in the order of the problem's direction.
/// @throws InputError.
[[nodiscard]] PlanFile parse_plan(std::string_view text, Direction direction);

}  // namespace orasp
