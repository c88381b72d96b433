#include "orasp/model/detail/problem_totals.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "orasp/model/objectives/objective_kind.h"

namespace orasp::detail {

namespace {

AttributeValues values_of(const Problem& problem, const std::string& name) {
  AttributeValues all{.name = name, .values = {}, .of_connection = {}};
  if (name == kDirectionAttribute) {
    for (const DirectionIndex d : problem.directions())
      all.values.push_back(problem.direction_name(d));
    return all;
  }
  std::map<std::string, std::uint32_t> number;
  for (const Connection& connection : problem.connections()) {
    const auto stated = connection.attributes.find(name);
    std::uint32_t value = 0;
    if (stated != connection.attributes.end()) {
      const auto [place, is_new] =
          number.try_emplace(stated->second, static_cast<std::uint32_t>(all.values.size() + 1));
      if (is_new) all.values.push_back(stated->second);
      value = place->second;
    }
    all.of_connection.push_back(value);
  }
  return all;
}

}  // namespace

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
  moves_by_size = problem.base().empty() && problem.spec().action == StepKind::Connection;
  std::set<std::string> names;
  for (const Part& part : problem.parts()) {
    for (const auto& [name, value] : part.numbers) names.insert(name);
  }
  for (const Connection& connection : problem.connections()) {
    for (const auto& [name, value] : connection.numbers) names.insert(name);
  }
  own_numbers.assign(names.begin(), names.end());
  LookBack look_back;
  kind_of(problem.objective()).add_look_back(problem.objective().parameters, look_back);
  for (const std::string& name : look_back.attributes)
    attributes.push_back(values_of(problem, name));
  looks_at_places = look_back.place;
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

std::size_t ProblemTotals::attribute(const std::string& name) const {
  const auto found = std::ranges::find(attributes, name, &AttributeValues::name);
  return static_cast<std::size_t>(found - attributes.begin());
}

}  // namespace orasp::detail
