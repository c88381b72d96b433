#include "tests/random_problems.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "orasp/io/formula_parser.h"
#include "orasp/model/random.h"
#include "orasp/model/transition_system.h"

namespace orasp {
namespace {

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}

  [[nodiscard]] bool chance(double probability) { return random_.uniform() < probability; }
  /// Uniform in least .. greatest.
  [[nodiscard]] std::size_t between(std::size_t least, std::size_t greatest) {
    return least + static_cast<std::size_t>(random_.below(greatest - least + 1));
  }
  template <class Item>
  [[nodiscard]] Item one_of(const std::vector<Item>& items) {
    return items[between(0, items.size() - 1)];
  }
  [[nodiscard]] double real(double least, double greatest) {
    return least + (greatest - least) * random_.uniform();
  }
  [[nodiscard]] Vector3 point() {  // a small raster, so that distances tie
    return {real_step(), real_step(), real_step()};
  }
  template <class Item>
  void shuffle(std::vector<Item>& items) {
    for (std::size_t i = items.size(); i > 1; --i)
      std::swap(items[i - 1], items[between(0, i - 1)]);
  }
  [[nodiscard]] std::uint64_t seed() { return random_.next(); }

 private:
  [[nodiscard]] double real_step() { return static_cast<double>(between(0, 2)) * 0.5; }

  SplitMix64 random_;
};

std::string random_formula(Draw& draw) {
  const std::vector<std::string> names = {"before",        "after",      "separates",  "completes",
                                          "moved_parts",   "kept_parts", "moved_mass", "kept_mass",
                                          "subassemblies", "duration",   "index",      "distance",
                                          "alpha",         "beta"};
  const std::vector<std::string> numbers = {"1", "2", "0.25", "1.5", "3", "0.1"};
  const auto factor = [&]() -> std::string {
    if (draw.chance(0.3)) return "(" + draw.one_of(names) + " - " + draw.one_of(numbers) + ")";
    return draw.one_of(names);
  };
  std::string formula = draw.chance(0.5) ? "-" : "";
  const std::size_t terms = draw.between(1, 4);
  for (std::size_t t = 0; t < terms; ++t) {
    if (t > 0) formula += draw.chance(0.5) ? " + " : " - ";
    formula += draw.one_of(numbers) + "*" + factor();
    if (draw.chance(0.4)) formula += "*" + factor();
    if (draw.chance(0.3))
      formula +=
          "/(1 + " + draw.one_of(std::vector<std::string>(names.begin(), names.end() - 2)) + ")";
  }
  return formula;
}

/// Between -2 and 3: a function of most of what a step holds.
double step_score(const Step& step) {
  double score = step.separates ? 1.0 : -0.5;
  score += 0.25 * static_cast<double>(step.connection % 3);
  score -= 0.125 * static_cast<double>(step.subassemblies % 4);
  if (step.separates && step.moved().front() % 2 == 0) score += 0.5;
  if (step.separates && step.kept().size() > 2) score -= 0.75;
  if (step.completes) score += 0.75;
  return score;
}

Objective random_objective(std::string_view type, Draw& draw, int depth) {
  Objective objective;
  objective.type = std::string(type);
  if (type == "piece_cost") {
    PieceCost cost{.operation = draw.real(-0.5, 1), .pieces = {}, .completion = draw.real(-3, 3)};
    for (std::size_t size = 1; size <= 5; ++size) {
      if (draw.chance(0.6)) cost.pieces[size] = draw.chance(0.3) ? 0.5 : draw.real(-1, 2);
    }
    objective.parameters = cost;
  } else if (type == "time") {
    objective.parameters = TimeObjective{
        .depot = draw.point(), .speed = draw.real(0.2, 3), .transfer = draw.real(0, 2)};
  } else if (type == "travel") {
    objective.parameters = Travel{.depot = draw.point()};
  } else if (type == "fuel") {
    objective.parameters = Fuel{
        .dry_mass = draw.real(1, 10), .delta_v = draw.real(0, 200), .isp = draw.real(100, 1000)};
  } else if (type == "completion") {
    objective.parameters = CompletionObjective{
        .join = draw.real(-5, 10), .step = draw.real(-1, 2), .bonus = draw.real(-20, 20)};
  } else if (type == "expression") {
    objective.parameters =
        Expression{.formula = random_formula(draw),
                   .constants = {{"alpha", draw.real(-2, 2)}, {"beta", draw.real(-2, 2)}},
                   .depot = draw.point(),
                   .compiler = compile_formula};
  } else if (type == "callable") {
    Callable callable{.name = "step_score", .reward = step_score};
    if (draw.chance(0.5)) {
      callable.least = -2;
      callable.greatest = 3;
    }
    objective.parameters = callable;
  } else if (type == "sum") {
    WeightedSum sum;
    const std::size_t terms = draw.between(1, 3);
    for (std::size_t t = 0; t < terms; ++t) {
      const double weight = draw.one_of<double>({1, -1, 0.5, -2, 0, 0.1});
      std::string_view inner = draw.one_of(
          std::vector<std::string_view>(kPlainObjectiveTypes.begin(), kPlainObjectiveTypes.end()));
      if (inner == "sum" && depth >= 2) inner = "indexed";
      if (inner == "expression" && draw.chance(0.5)) inner = "cubesat_zone";
      sum.terms.push_back({weight, random_objective(inner, draw, depth + 1)});
    }
    objective.parameters = sum;
  } else {
    objective = Objective::named(type);
  }
  return objective;
}

bool needs_positions(const Objective& objective) {
  if (objective.type == "travel") return true;
  const auto* sum = std::get_if<WeightedSum>(&objective.parameters);
  return sum != nullptr &&
         std::any_of(sum->terms.begin(), sum->terms.end(),
                     [](const WeightedObjective& term) { return needs_positions(term.objective); });
}

void add_parts(ProblemSpec& spec, Draw& draw, std::size_t parts) {
  const std::size_t mass_kind = draw.between(0, 2);
  const double positioned =
      needs_positions(spec.objective) ? 1.0 : draw.one_of<double>({0.0, 1.0, 0.8});
  for (std::size_t p = 0; p < parts; ++p) {
    Part part;
    part.id = "p" + std::to_string(p);
    if (mass_kind == 1) part.mass = draw.one_of<double>({0.1, 0.2, 0.3, 0.1, 0.2, 0});
    if (mass_kind == 2) part.mass = draw.real(0, 3);
    if (draw.chance(positioned)) part.position = draw.point();
    spec.parts.push_back(part);
  }
}

void add_connections(ProblemSpec& spec, Draw& draw, std::size_t most, double joined) {
  const std::size_t parts = spec.parts.size();
  if (parts == 0) return;
  std::vector<std::pair<std::size_t, std::size_t>> ends;
  for (std::size_t p = 1; p < parts; ++p) {
    if (draw.chance(joined)) ends.emplace_back(p, draw.between(0, p - 1));
  }
  const std::size_t extra = draw.between(0, 3);
  for (std::size_t e = 0; e < extra && ends.size() < most; ++e) {
    const std::size_t first = draw.between(0, parts - 1);
    const std::size_t second = draw.chance(0.15) ? first : draw.between(0, parts - 1);
    if (first == second && draw.chance(0.5)) continue;
    ends.emplace_back(first, second);
  }
  if (!ends.empty() && ends.size() < most && draw.chance(0.15))
    ends.push_back(draw.one_of(ends));  // parallel
  draw.shuffle(ends);
  const bool named = draw.chance(0.3);
  std::set<std::string> taken;
  for (const auto& [x, y] : ends) {
    const bool swap = draw.chance(0.5);
    const std::size_t first = swap ? y : x;
    const std::size_t second = swap ? x : y;
    Connection connection;
    connection.parts = {spec.parts[first].id, spec.parts[second].id};
    const bool is_new = taken.insert(connection.parts[0] + "-" + connection.parts[1]).second;
    if (named || !is_new) connection.id = "c" + std::to_string(spec.connections.size());
    if (draw.chance(0.4)) connection.duration = draw.one_of<double>({0, 0.5, 2, 3.25});
    static_cast<void>(draw.chance(0.2));  // make_uncertain() decides; old seeds keep their problems
    spec.connections.push_back(connection);
  }
}

std::string id_of(const Connection& connection) {
  return connection.id.empty() ? connection.parts[0] + "-" + connection.parts[1] : connection.id;
}

void add_precedence(ProblemSpec& spec, Draw& draw) {
  const std::size_t connections = spec.connections.size();
  if (connections < 2) return;
  const bool may_cycle = draw.chance(0.12);
  std::vector<std::size_t> order(connections);
  std::iota(order.begin(), order.end(), 0);
  draw.shuffle(order);
  const auto some_before = [&](std::size_t place, std::size_t most) {
    std::vector<std::size_t> candidates;
    for (std::size_t i = 0; i < connections; ++i) {
      if (i < place || may_cycle) candidates.push_back(order[i]);
    }
    draw.shuffle(candidates);
    candidates.resize(std::min(candidates.size(), draw.between(1, most)));
    std::vector<std::string> ids;
    for (const std::size_t c : candidates) ids.push_back(id_of(spec.connections[c]));
    return ids;
  };
  // Draws of its own, so that the rest of a problem does not depend on them.
  std::uint64_t seed = connections;
  for (const std::size_t place : order) seed = seed * 31 + place;
  Draw made(seed);
  const auto some_behind = [&](std::size_t place, std::size_t most) {
    std::vector<std::string> ids;
    for (std::size_t i = place + 1; i < connections && ids.size() < most; ++i) {
      if (made.chance(0.6)) ids.push_back(id_of(spec.connections[order[i]]));
    }
    if (ids.empty()) ids.push_back(id_of(spec.connections[order[(place + 1) % connections]]));
    return ids;
  };
  const std::size_t entries = draw.between(1, 4);
  for (std::size_t e = 0; e < entries; ++e) {
    const std::size_t place = draw.between(1, connections - 1);
    Precedence entry;
    entry.connection = id_of(spec.connections[order[place]]);
    const std::size_t kind = draw.between(0, 4);
    if (kind != 1) entry.after = some_before(place, 2);
    if (kind == 1 || kind == 2) entry.after_any = some_before(place, 3);
    if (made.chance(0.3)) {
      // The same by the way it is made: what comes later in the order is removed later, so it is
      // made earlier.
      const std::size_t which = made.between(0, 2);
      if (which == 0) entry.after.clear();
      if (which != 1) entry.made_after = some_behind(place, 2);
      if (which != 0) entry.made_after_any = some_behind(place, 3);
    }
    spec.precedence.push_back(entry);
  }
}

void add_limits(ProblemSpec& spec, Draw& draw) {
  const double likely = draw.one_of<double>({0.0, 0.0, 0.4, 0.8});
  if (draw.chance(likely))
    spec.limits.max_subassemblies = draw.between(0, 9) == 0 ? 0 : draw.between(1, 3);
  if (draw.chance(likely))
    spec.limits.max_moved_parts = draw.between(0, 9) == 0 ? 0 : draw.between(1, 2);
  if (draw.chance(likely)) spec.limits.max_moved_mass = draw.one_of<double>({0.3, 0.6, 1, 2, 2.5});
}

void add_blocking(ProblemSpec& spec, Draw& draw, const std::vector<double>& densities) {
  std::vector<std::array<std::string, 2>> axes = {{"+x", "-x"}, {"+y", "-y"}, {"+z", "-z"}};
  draw.shuffle(axes);
  axes.resize(draw.between(1, 3));
  Blocking blocking;
  for (const auto& axis : axes) {
    blocking.directions.push_back(axis[0]);
    blocking.directions.push_back(axis[1]);
  }
  const bool in_space = draw.chance(0.3);  // parts on a raster stand in each other's way along rows
  const double density = draw.one_of(densities);
  std::vector<std::array<std::size_t, 3>> cells;
  for (std::size_t p = 0; p < spec.parts.size(); ++p) {
    cells.push_back({draw.between(0, 2), draw.between(0, 2), draw.between(0, 1)});
  }
  for (std::size_t i = 0; i < spec.parts.size(); ++i) {
    for (std::size_t j = 0; j < spec.parts.size(); ++j) {
      if (i == j) continue;
      Blocked blocked{.part = spec.parts[i].id, .by = spec.parts[j].id, .directions = {}};
      for (const auto& [direction, vector] : blocking.directions) {
        if (in_space) {
          const auto axis = static_cast<std::size_t>(direction[1] - 'x');
          bool same_row = true;
          for (std::size_t other = 0; other < 3; ++other)
            same_row &= other == axis || cells[i][other] == cells[j][other];
          const bool in_front = direction[0] == '+' ? cells[j][axis] > cells[i][axis]
                                                    : cells[j][axis] < cells[i][axis];
          if (same_row && in_front) blocked.directions.push_back(direction);
        } else if (i < j && draw.chance(density)) {
          blocked.directions.push_back(direction);
        }
      }
      if (!blocked.directions.empty()) blocking.blocked.push_back(blocked);
    }
  }
  spec.blocking = blocking;
}

/// Of some problems the last pair of axes has a name of its own; of fewer it is there many times
/// over, so that its directions do not fit a mask. The plans are the same.
void name_directions(ProblemSpec& spec, std::uint64_t seed) {
  if (!spec.blocking) return;
  if (seed % 4 == 1) spec = with_named_directions(std::move(spec), 1);
  if (seed % 16 == 3) spec = with_named_directions(std::move(spec), 14);
}

}  // namespace

ProblemSpec with_named_directions(ProblemSpec spec, std::size_t copies) {
  Blocking& blocking = *spec.blocking;
  const std::string minus = blocking.directions.back().id;
  const std::string plus = "+" + minus.substr(1);
  blocking.directions.resize(blocking.directions.size() - 2);
  const auto name = [](std::size_t i) { return "slant " + std::to_string(i); };
  for (std::size_t i = 0; i < copies; ++i)
    blocking.directions.push_back({name(i), Vector3{1, static_cast<double>(i), 1}});
  for (Blocked& entry : blocking.blocked) {
    std::vector<std::string> directions;
    for (const std::string& direction : entry.directions) {
      if (direction != plus && direction != minus) {
        directions.push_back(direction);
        continue;
      }
      for (std::size_t i = 0; i < copies; ++i)
        directions.push_back((direction == minus ? "-" : "") + name(i));
    }
    entry.directions = directions;
  }
  return spec;
}

Objective random_objective(std::string_view type, std::uint64_t seed) {
  Draw draw(seed);
  return random_objective(type, draw, 0);
}

ProblemSpec random_problem(std::uint64_t seed) {
  Draw draw(mixed(seed + 1));
  ProblemSpec spec;
  spec.name = "random problem " + std::to_string(seed);
  std::vector<std::string_view> types(kPlainObjectiveTypes.begin(), kPlainObjectiveTypes.end());
  types.push_back("callable");
  spec.objective =
      random_objective(types[seed % types.size()], draw, 0);  // every type equally often
  if (draw.chance(0.4)) spec.direction = Direction::Assembly;
  add_parts(spec, draw, draw.chance(0.02) ? 0 : draw.between(1, 7));
  if (!spec.parts.empty()) add_connections(spec, draw, 8, draw.one_of<double>({1.0, 0.9, 0.6}));
  if (draw.chance(0.5)) add_precedence(spec, draw);
  add_limits(spec, draw);
  if (!spec.parts.empty() && draw.chance(0.35)) add_blocking(spec, draw, {0.1, 0.25, 0.5, 0.7});
  name_directions(spec, seed);
  return spec;
}

ProblemSpec make_uncertain(ProblemSpec spec, std::uint64_t seed) {
  Draw draw(mixed(seed + 0x5eed));
  std::vector<std::string> ids;
  for (const Connection& connection : spec.connections) ids.push_back(id_of(connection));
  for (Connection& connection : spec.connections) {
    if (draw.chance(0.7)) connection.success = draw.one_of<double>({0.3, 0.5, 0.8, 0.95});
    if (draw.chance(0.2)) {
      connection.on_failure.abort = draw.one_of<double>({-50, 0, 2.5});
    } else if (spec.direction == Direction::Disassembly && draw.chance(0.5)) {
      std::vector<std::string> shuffled = ids;
      draw.shuffle(shuffled);
      shuffled.resize(std::min(shuffled.size(), draw.between(1, 3)));
      connection.on_failure.breaks = shuffled;
    }
  }
  return spec;
}

ProblemSpec larger_random_problem(std::uint64_t seed) {
  Draw draw(mixed(seed + 1));
  ProblemSpec spec;
  spec.name = "larger random problem " + std::to_string(seed);
  spec.objective =
      random_objective(kPlainObjectiveTypes[seed % kPlainObjectiveTypes.size()], draw, 0);
  add_parts(spec, draw, draw.between(8, 11));
  add_connections(spec, draw, 12, draw.one_of<double>({1.0, 0.95}));
  if (draw.chance(0.5)) add_precedence(spec, draw);
  add_limits(spec, draw);
  if (draw.chance(0.35)) add_blocking(spec, draw, {0.05, 0.1});
  name_directions(spec, seed);
  return spec;
}

}  // namespace orasp
