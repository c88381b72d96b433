#include "orasp/model/detail/checked_reward.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "orasp/model/detail/reward_size.h"
#include "orasp/model/objectives/objective_kind.h"

namespace orasp::detail {

namespace {

double largest_coordinate(const Vector3& point) {
  return std::max({std::abs(point[0]), std::abs(point[1]), std::abs(point[2])});
}

std::vector<std::size_t> starting_pieces(const Problem& problem) {
  std::vector<PartIndex> leader(problem.num_parts());
  std::iota(leader.begin(), leader.end(), PartIndex{0});
  const auto leader_of = [&](PartIndex part) {
    while (leader[part] != part) part = leader[part] = leader[leader[part]];
    return part;
  };
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const auto& ends = problem.ends(c);
    leader[leader_of(ends[0])] = leader_of(ends[1]);
  }
  std::vector<std::size_t> parts(leader.size(), 0);
  for (PartIndex part = 0; part < leader.size(); ++part) ++parts[leader_of(part)];
  std::vector<std::size_t> starting_piece(leader.size());
  for (PartIndex part = 0; part < leader.size(); ++part)
    starting_piece[part] = parts[leader_of(part)];
  return starting_piece;
}

}  // namespace

double metres_between(const Vector3& point, const Vector3& depot) {
  return std::hypot(point[0] - depot[0], point[1] - depot[1], point[2] - depot[2]);
}

CheckedProblem::CheckedProblem(const Problem& problem)
    : problem_(problem), starting_piece_(starting_pieces(problem)) {
  for (const Part& part : problem.parts()) {
    if (part.position)
      farthest_coordinate_ = std::max(farthest_coordinate_, largest_coordinate(*part.position));
  }
}

double CheckedProblem::distance_error(const SeenStep& step, const Vector3& depot) const {
  constexpr double kRounding = std::numeric_limits<double>::epsilon();
  const double reach = std::max(farthest_coordinate_, largest_coordinate(depot));
  return 4 * kRounding * static_cast<double>(step.moved_parts + 1) * reach;
}

CheckedReward::CheckedReward(const Problem& problem)
    : problem_(problem), largest_(largest_reward(problem.num_connections())) {
  const Objective& objective = problem.objective();
  kind_of(objective).add_checked_terms(objective.parameters, 1, problem_, terms_);
  needs_step_ = std::ranges::any_of(terms_, &CheckedTerm::needs_step);
  looks_back_ = std::ranges::any_of(terms_, &CheckedTerm::looks_back);
}

CheckedReward::Value CheckedReward::of(const SeenStep& step) const {
  const auto fits = [this](double reward) { return std::abs(reward) <= largest_; };
  Value sum;
  for (const CheckedTerm& term : terms_) {
    const CheckedValue found = term.value(step);
    const double earned = term.weight * found.reward;
    if (term.calls_out && sum.finite && !(fits(found.reward) && fits(earned))) {
      sum.finite = false;
      sum.unfit = fits(found.reward) ? earned : found.reward;
    }
    sum.reward += earned;
    sum.magnitude += std::abs(earned);
    sum.rounding += std::abs(term.weight) * found.rounding;
  }
  return sum;
}

}  // namespace orasp::detail
