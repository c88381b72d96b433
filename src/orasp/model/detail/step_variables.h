#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "orasp/model/detail/checked_reward.h"
#include "orasp/model/detail/step_pieces.h"
#include "orasp/model/formula.h"
#include "orasp/model/vector3.h"

namespace orasp::detail {

/// What formulas see of a step, but the user's own numbers; `distance` is measured from `depot`.
[[nodiscard]] FormulaVariables variables_of(const StepFacts& facts, const Movement& movement,
                                            const StepPieces& pieces, const Vector3& depot);
/// Number i of ProblemTotals::own_numbers: the connection's, and the sums over the moved and over
/// the kept piece, at 3 * i in `own`.
void own_numbers_of(const StepFacts& facts, const Movement& movement, const StepPieces& pieces,
                    std::size_t i, std::span<double> own);

// The same in the check of plans, which shares nothing with the rules.

[[nodiscard]] FormulaVariables variables_of(const SeenStep& step, const Vector3& depot);
/// Of the numbers of these names, in their order.
[[nodiscard]] std::vector<double> own_numbers_of(const SeenStep& step,
                                                 std::span<const std::string> names);
/// The names of all numbers that a problem states, ascending.
[[nodiscard]] std::vector<std::string> numbers_of(const ProblemSpec& problem);

}  // namespace orasp::detail
