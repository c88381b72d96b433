#include "orasp/model/detail/problem_totals.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace orasp::detail {

ProblemTotals::ProblemTotals(const Problem& the_problem, const AssemblyGraph& the_graph)
    : problem(the_problem),
      graph(the_graph),
      assembly(the_problem.direction() == Direction::Assembly) {
  if (!problem.parts().empty()) part_mass = problem.parts().front().mass;
  for (const Part& part : problem.parts()) {
    total_mass += part.mass;
    heaviest.push_back(part.mass);
    if (part.mass != part_mass) uniform_mass = false;
    if (part.position) no_positions = false;
  }
  std::ranges::sort(heaviest);
  lightest = heaviest;
  std::ranges::reverse(heaviest);
  for (std::vector<double>* masses : {&lightest, &heaviest}) {
    masses->insert(masses->begin(), 0.0);
    std::partial_sum(masses->begin(), masses->end(), masses->begin());
  }
}

double ProblemTotals::farthest(const Vector3& depot) const {
  double distance = 0;
  for (const Part& part : problem.parts()) {
    if (!part.position) continue;
    const Vector3& x = *part.position;
    distance = std::max(distance, std::hypot(x[0] - depot[0], x[1] - depot[1], x[2] - depot[2]));
  }
  return distance;
}

}  // namespace orasp::detail
