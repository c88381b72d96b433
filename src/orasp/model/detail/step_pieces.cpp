#include "orasp/model/detail/step_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "orasp/model/detail/reward_size.h"
#include "orasp/model/detail/wording.h"

namespace orasp::detail {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

bool nearly_equal(double a, double b) {
  return std::abs(a - b) <= kRelativeTolerance * std::max(std::abs(a), std::abs(b));
}

}  // namespace

double StepPieces::mass(const Side& side) const {
  if (totals.uniform_mass) return static_cast<double>(side.parts()) * totals.part_mass;
  double sum = 0;
  side.for_each([&](PartIndex part) { sum += totals.problem.parts()[part].mass; });
  return sum;
}

// The side with fewer parts moves; where both have as many, the lighter one; where both weigh the
// same, the one that does not hold the earliest listed of their parts.
Movement StepPieces::movement(const StepFacts& facts) const {
  Movement result;
  const double mass_a = mass(a);
  const double mass_b = mass(b);
  if (facts.a_parts != facts.b_parts) {
    result.a_moves = facts.a_parts < facts.b_parts;
  } else if (!nearly_equal(mass_a, mass_b)) {
    result.a_moves = mass_a < mass_b;
  } else {
    PartIndex first_a = kNone;
    PartIndex first_b = kNone;
    a.for_each([&](PartIndex part) { first_a = std::min(first_a, part); });
    b.for_each([&](PartIndex part) { first_b = std::min(first_b, part); });
    result.a_moves = first_b < first_a;
  }
  result.moved_mass = result.a_moves ? mass_a : mass_b;
  result.kept_mass = result.a_moves ? mass_b : mass_a;
  return result;
}

std::optional<double> StepPieces::distance(bool a_moves, const Vector3& depot) const {
  const Side& moved = a_moves ? a : b;
  Vector3 sum{};
  bool known = true;
  moved.for_each([&](PartIndex part) {
    const auto& position_of_part = totals.problem.parts()[part].position;
    if (!position_of_part) {
      known = false;
      return;
    }
    for (std::size_t i = 0; i < 3; ++i) sum[i] += (*position_of_part)[i];
  });
  if (!known) return std::nullopt;
  const auto n = static_cast<double>(moved.parts());
  return std::hypot(sum[0] / n - depot[0], sum[1] / n - depot[1], sum[2] / n - depot[2]);
}

Step StepPieces::full_step(const StepFacts& facts) const {
  Step step;
  step.connection = facts.connection;
  step.before = facts.before;
  step.after = facts.after;
  step.separates = facts.separates;
  step.completes = facts.completes;
  step.subassemblies = totals.assembly ? facts.subassemblies_joined : facts.subassemblies_apart;
  if (!facts.separates) return step;
  const Movement moved = movement(facts);
  step.a_moves = moved.a_moves;
  step.moved_mass = moved.moved_mass;
  step.kept_mass = moved.kept_mass;
  a.for_each([&](PartIndex part) { step.a.push_back(part); });
  b.for_each([&](PartIndex part) { step.b.push_back(part); });
  std::ranges::sort(step.a);
  std::ranges::sort(step.b);
  return step;
}

double StepPieces::checked(double reward, const StepFacts& facts) const {
  if (std::abs(reward) <= largest_reward(totals.problem.num_connections())) return reward;
  throw InputError(
      "objective: the reward of " + std::string(totals.assembly ? "making " : "removing ") +
      in_quotes(totals.problem.connection_id(facts.connection)) + " with " +
      std::to_string(facts.before) + " connections present is " + unfit_reward_text(reward));
}

}  // namespace orasp::detail
