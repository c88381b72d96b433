#pragma once

#include <vector>

namespace orasp {

class ObjectiveKind;
class Problem;
struct WeightedObjective;  // model/objective.h

/// What a step earns that is tried until it succeeds: what one attempt earns, times the attempts
/// that it takes on average. No file names it; attempts_paid() makes it.
struct Retried {
  std::vector<double> attempts;              ///< for each connection, 1 or more
  std::vector<WeightedObjective> objective;  ///< what one attempt earns: one, of weight 1
};

[[nodiscard]] const ObjectiveKind& retried_kind();

/// The problem as one without failures, whose steps earn what their attempts earn together on
/// average: r / p where an attempt earns r and succeeds with probability p.
///
/// Idea.      A failed attempt leaves the state as it is, so that what was best to attempt still
///            is: a policy is a sequence, and Bellman's V = p (r + V') + (1 - p) (r + V) solves to
///            V = r / p + V'. So every method for problems without failures, every bound and the
///            check of plans hold for these as well.
/// Guarantee. The same plans are legal, and a plan earns what the policy that follows it earns in
///            expectation.
/// Limit.     Holds for problems of Problem::only_retries(), with steps that take one connection
///            and earn what they earn whatever came before. Of others it is a relaxation for
///            bounds: attempts that may break something are made again until they succeed, and
///            those that may end the job succeed at once.
/// @throws InputError where rewards so large add up to no finite number.
[[nodiscard]] Problem attempts_paid(const Problem& problem);

}  // namespace orasp
