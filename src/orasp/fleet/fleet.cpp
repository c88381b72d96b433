#include "orasp/fleet/fleet.h"

#include <algorithm>
#include <numeric>

#include "orasp/model/detail/wording.h"

namespace orasp {
namespace {

using detail::in_quotes;

/// Names each part's piece by its first part.
std::vector<PartIndex> pieces(const FleetProblem& fleet, const ConnectionSet& open) {
  std::vector<PartIndex> piece(fleet.num_parts());
  std::iota(piece.begin(), piece.end(), PartIndex{0});
  const auto first_of = [&piece](PartIndex part) {
    while (piece[part] != part) part = piece[part] = piece[piece[part]];
    return part;
  };
  for_each_connection(open.view(), [&](ConnectionIndex c) {
    const auto [i, j] = fleet.problem().ends(c);
    const PartIndex a = first_of(i);
    const PartIndex b = first_of(j);
    piece[std::max(a, b)] = std::min(a, b);
  });
  for (PartIndex part = 0; part < piece.size(); ++part) piece[part] = first_of(part);
  return piece;
}

}  // namespace

FleetProblem::FleetProblem(const Problem& problem) : problem_(&problem) {
  const ProblemSpec& spec = problem.spec();
  if (!spec.fleet)
    throw InputError(
        "fleet: the problem has no \"fleet\", which a method for several robots needs: the number "
        "of robots, the "
        "depot and the sites");
  if (spec.fleet->sites.empty())
    throw InputError("fleet.sites: there is no site; the product needs at least one to stand on");
  if (problem.direction() == Direction::Assembly)
    throw InputError(
        "direction: \"assembly\" is not allowed in a fleet problem, which is stated for "
        "disassembly; its plan read "
        "backwards assembles");
  if (std::holds_alternative<FleetTravel>(problem.objective().parameters))
    objective_ = FleetObjective::Travel;
  axis_.reserve(problem.num_connections());
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const Connection& connection = problem.connections()[c];
    const std::string place = "connections[" + std::to_string(c) + "]";
    if (problem.ends(c)[0] == problem.ends(c)[1])
      throw InputError(place + ": connection " + in_quotes(connection.id) + " joins part " +
                       in_quotes(connection.parts[0]) + " to itself; no robots can pull it apart");
    if (connection.axis.empty())
      throw InputError(place + ".axis: connection " + in_quotes(connection.id) +
                       " has no axis; in a fleet problem each needs the direction in which its "
                       "first part comes off "
                       "its second, +x, -x, +y, -y, +z or -z");
    if (connection.success < 1)
      throw InputError(place + ".success: an attempt at connection " + in_quotes(connection.id) +
                       " may fail; methods for fleets plan for attempts that always succeed");
    const auto* const name = std::ranges::find(kDirectionNames, std::string_view(connection.axis));
    axis_.push_back(static_cast<std::size_t>(name - kDirectionNames.begin()));
    dimensions_ = std::max(dimensions_, axis_.back() / 2 + 1);
  }
  most_subassemblies_ = num_sites();
  if (spec.limits.max_subassemblies)
    most_subassemblies_ = std::min(most_subassemblies_, *spec.limits.max_subassemblies);
}

double FleetProblem::reward(const FleetPlan& plan) const {
  return objective_ == FleetObjective::Makespan ? 0.0 - static_cast<double>(plan.makespan())
                                                : 0.0 - plan.travel();
}

std::string FleetProblem::place_name(PlaceIndex place) {
  return place == kDepot ? "depot" : "site " + std::to_string(place);
}

double FleetProblem::squared_distance(PlaceIndex a, PlaceIndex b) const {
  const double x = place(a)[0] - place(b)[0];
  const double y = place(a)[1] - place(b)[1];
  return x * x + y * y;
}

std::optional<std::string> FleetProblem::infeasibility() const {
  const std::vector<PartIndex> piece =
      pieces(*this, ConnectionSet::all(problem_->num_connections()));
  std::vector<std::size_t> size(num_parts(), 0);
  for (const PartIndex first : piece) ++size[first];
  const auto subassemblies = static_cast<std::size_t>(
      std::ranges::count_if(size, [](std::size_t parts) { return parts > 1; }));
  if (subassemblies > most_subassemblies_)
    return "the product starts as " + std::to_string(subassemblies) +
           " subassemblies, and there may be at most " + std::to_string(most_subassemblies_) +
           ": a site for each, and limits.max_subassemblies";
  if (subassemblies > 0 && robots() < 2)
    return "the last connection takes two robots, one for each of its parts, and there is one";
  return std::nullopt;
}

FleetState fleet_start(const FleetProblem& fleet, std::span<const PlaceIndex> places) {
  return {.open = ConnectionSet::all(fleet.num_connections()),
          .places = {places.begin(), places.end()}};
}

FleetStep fleet_step(const FleetProblem& fleet, FleetState& state, std::span<const Motion> motions,
                     std::span<const PlaceIndex> places) {
  FleetStep step;
  for_each_connection(state.open.view(), [&](ConnectionIndex c) {
    const auto [i, j] = fleet.problem().ends(c);
    if (motions[i] != motions[j]) step.cut.push_back(c);
  });
  for (const ConnectionIndex c : step.cut) state.open.erase(c);

  const std::vector<PartIndex> piece = pieces(fleet, state.open);
  std::vector<std::size_t> move_of(fleet.num_parts(), fleet.num_parts());
  for (PartIndex part = 0; part < fleet.num_parts(); ++part) {
    if (motions[part] == kStay && places[part] == state.places[part]) continue;
    std::size_t& move = move_of[piece[part]];
    if (move == fleet.num_parts()) {
      move = step.moves.size();
      step.moves.push_back({.parts = {},
                            .robots = {},
                            .from = state.places[part],
                            .to = places[part],
                            .motion = motions[part],
                            .distance = 0});
    }
    step.moves[move].parts.push_back(part);
  }
  for (FleetMove& move : step.moves) {
    for (std::size_t k = 0; k < move.parts.size(); ++k) move.robots.push_back(++step.robots_used);
    move.distance =
        static_cast<double>(move.parts.size()) * fleet.squared_distance(move.from, move.to);
    step.distance += move.distance;
  }
  state.places.assign(places.begin(), places.end());
  return step;
}

}  // namespace orasp
