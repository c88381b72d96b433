// Fuzz target: the bytes are a problem file.
//
// Whatever they are, parse_problem accepts them or refuses them in one sentence. A problem that it
// accepts is written and read back with the same digest and the same text. If it is small, two
// exact methods agree on it, and the independent check finds their plans legal and their rewards
// right.
#include <algorithm>

#include "fuzz/property.h"
#include "orasp/catalogue.h"
#include "orasp/io/problem_json.h"
#include "orasp/model/validate.h"

namespace orasp::fuzz {
namespace {

constexpr std::size_t kMostConnections = 6;
constexpr std::size_t kMostParts = 10;
constexpr std::uint64_t kMostExpansions = 5'000;

std::optional<Result> answer(const Problem& problem, std::string_view method) {
  Budget budget;
  budget.max_expansions = kMostExpansions;
  return accepted([&] { return solve(problem, method, {}, budget); });
}

/// The greatest that a step of a plan earns until it succeeds, by size: the measure of what
/// rounding may do.
double check_plan(const Problem& problem, const Result& result) {
  if (!result.has_plan()) return 0;
  const Evaluation replay = evaluate(problem, result.sequence);
  require(replay.valid, "a plan is legal");
  double greatest = 0;
  for (const Step& step : replay.steps) {
    const double attempts = 1 / problem.connections()[step.connection].success;
    greatest = std::max(greatest, std::abs(step.reward) * attempts);
  }
  require(
      problem.uncertain() || same_sum(replay.reward, result.reward, greatest, replay.steps.size()),
      "a plan earns what its method says");
  return greatest;
}

void check_agreement(const Problem& problem) {
  const std::optional<Result> one = answer(problem, "exhaustive");
  const std::optional<Result> other = answer(problem, "value-iteration");
  if (!one || !other) return;
  const double greatest = std::max(check_plan(problem, *one), check_plan(problem, *other));
  if (one->stop != Stop::None || other->stop != Stop::None) return;
  require(one->status == other->status, "exact methods agree on whether there is a plan");
  require(
      !one->has_plan() || same_sum(one->reward, other->reward, greatest, problem.num_connections()),
      "exact methods agree on the best reward");
}

}  // namespace
}  // namespace orasp::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace orasp;
  using namespace orasp::fuzz;
  const std::optional<Problem> problem =
      accepted([&] { return parse_problem(text_of(data, size)); });
  if (!problem) return 0;
  const std::string text = problem_text(*problem);
  const Problem again = parse_problem(text);
  require(problem_digest(again) == problem_digest(*problem), "writing a problem keeps its digest");
  require(problem_text(again) == text, "what was written is written the same again");
  if (problem->num_connections() <= kMostConnections && problem->num_parts() <= kMostParts)
    check_agreement(*problem);
  return 0;
}
