#include "tests/wide_problems.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "orasp/io/formula_parser.h"
#include "orasp/model/random.h"

namespace orasp {
namespace wide_problems {
namespace {

using Names = std::vector<std::string>;

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
  [[nodiscard]] double number(const std::vector<double>& numbers) { return one_of(numbers); }
  /// One of a raster, so that distances tie.
  [[nodiscard]] Vector3 point() {
    Vector3 point{};
    for (double& coordinate : point) coordinate = static_cast<double>(between(0, 3)) * 0.5;
    return point;
  }
  template <class Item>
  void shuffle(std::vector<Item>& items) {
    for (std::size_t i = items.size(); i > 1; --i)
      std::swap(items[i - 1], items[between(0, i - 1)]);
  }
  /// At least one of the items and at most so many, in any order.
  template <class Item>
  [[nodiscard]] std::vector<Item> some_of(std::vector<Item> items, std::size_t most) {
    shuffle(items);
    items.resize(std::min(items.size(), between(1, most)));
    return items;
  }

 private:
  SplitMix64 random_;
};

/// Makes one problem, key by key; what is drawn first limits what may follow.
class Maker {
 public:
  explicit Maker(std::uint64_t seed) : draw_(seed) {}

  ProblemSpec make(std::uint64_t seed) {
    spec_.name = "wide random problem " + std::to_string(seed);
    if (draw_.chance(0.4)) spec_.direction = Direction::Assembly;
    if (draw_.chance(0.35)) spec_.action = StepKind::Part;
    add_parts();
    add_connections();
    add_base();
    if (draw_.chance(0.4)) add_blocking();
    if (draw_.chance(0.55)) add_precedence();
    add_limits();
    if (spec_.direction == Direction::Disassembly && draw_.chance(0.45)) add_goal();
    spec_.objective = objective();
    return spec_;
  }

 private:
  [[nodiscard]] bool by_part() const { return spec_.action == StepKind::Part; }

  [[nodiscard]] static std::string id_of(const Connection& connection) {
    return connection.id.empty() ? connection.parts[0] + "-" + connection.parts[1] : connection.id;
  }
  [[nodiscard]] std::size_t place_of(const std::string& part) const {
    for (std::size_t p = 0; p < spec_.parts.size(); ++p) {
      if (spec_.parts[p].id == part) return p;
    }
    return spec_.parts.size();
  }

  void add_parts() {
    const std::size_t masses = draw_.between(0, 2);
    const double positioned = draw_.number({0, 0.8, 1, 1, 1});
    const double valued = draw_.number({0, 0.5, 1});
    const std::size_t parts = draw_.chance(0.1) ? draw_.between(1, 2) : draw_.between(3, 7);
    for (std::size_t p = 0; p < parts; ++p) {
      Part part;
      part.id = "p" + std::to_string(p);
      if (masses == 1) part.mass = draw_.number({0.1, 0.2, 0.3, 0.1, 0.2, 0});
      if (masses == 2) part.mass = draw_.number({0.5, 1.25, 2, 3.5, 4.75});
      if (draw_.chance(positioned)) part.position = draw_.point();
      if (draw_.chance(valued)) part.numbers["value"] = draw_.number({1, 2.5, 4, 7, -3});
      if (valued > 0 && draw_.chance(0.2)) part.numbers["scrap"] = draw_.number({0.5, -1});
      spec_.parts.push_back(part);
    }
  }

  void add_connections() {
    const std::size_t parts = spec_.parts.size();
    const double joined = draw_.number({1, 1, 0.85});
    std::vector<std::pair<std::size_t, std::size_t>> ends;
    for (std::size_t p = 1; p < parts; ++p) {
      if (draw_.chance(joined)) ends.emplace_back(p, draw_.between(0, p - 1));
    }
    const std::size_t extra = draw_.between(0, 3);
    for (std::size_t e = 0; e < extra && ends.size() < 7; ++e) {
      const std::size_t first = draw_.between(0, parts - 1);
      const std::size_t second = draw_.between(0, parts - 1);
      // Part steps leave a connection of a part to itself alone, so that mostly there is no plan.
      if (first == second && !draw_.chance(by_part() ? 0.03 : 0.3)) continue;
      ends.emplace_back(first, second);
    }
    draw_.shuffle(ends);
    const double tooled = draw_.number({0, 0.6, 0.9});
    const double valued = draw_.number({0, 0.6});
    const double placed = draw_.number({0, 0.3, 1});
    std::set<std::string> taken;
    for (const auto& [x, y] : ends) {
      Connection connection;
      connection.parts = {spec_.parts[x].id, spec_.parts[y].id};
      const bool is_new = taken.insert(id_of(connection)).second;
      if (!is_new || draw_.chance(0.3))
        connection.id = "c" + std::to_string(spec_.connections.size());
      if (draw_.chance(0.5)) connection.duration = draw_.number({0, 0.5, 2, 3.25});
      if (draw_.chance(tooled)) {
        connection.attributes["tool"] = draw_.one_of(Names{"A", "B", "C"});
        if (draw_.chance(0.5)) connection.attributes["grip"] = draw_.one_of(Names{"wide", "thin"});
      }
      if (draw_.chance(valued)) connection.numbers["value"] = draw_.number({1, 3, 5.5, -2});
      if (draw_.chance(placed)) connection.position = draw_.point();
      spec_.connections.push_back(connection);
    }
  }

  void add_base() {
    if (!draw_.chance(0.5)) return;
    Names ids;
    for (const Part& part : spec_.parts) ids.push_back(part.id);
    // Two base parts that hang together are never parted by part steps.
    spec_.base = draw_.some_of(ids, by_part() && !draw_.chance(0.2) ? 1 : 3);
    spec_.limits.grounded = draw_.chance(0.4);
  }

  void add_blocking() {
    std::vector<std::array<std::string, 2>> axes = {{"+x", "-x"}, {"+y", "-y"}, {"+z", "-z"}};
    draw_.shuffle(axes);
    axes.resize(draw_.between(1, 3));
    Blocking blocking;
    Names names;
    for (const auto& axis : axes) {
      for (const std::string& direction : axis) {
        blocking.directions.push_back(direction);
        names.push_back(direction);
      }
    }
    if (draw_.chance(0.3)) {
      blocking.directions.push_back({"slant", Vector3{0.6, 0, 0.8}});
      names.insert(names.end(), {"slant", "-slant"});
    }
    const double density = draw_.number({0.1, 0.2, 0.35});
    for (std::size_t i = 0; i < spec_.parts.size(); ++i) {
      for (std::size_t j = i + 1; j < spec_.parts.size(); ++j) {
        Blocked blocked{.part = spec_.parts[i].id, .by = spec_.parts[j].id, .directions = {}};
        if (draw_.chance(0.5)) std::swap(blocked.part, blocked.by);
        for (const std::string& direction : names) {
          if (draw_.chance(density)) blocked.directions.push_back(direction);
        }
        if (!blocked.directions.empty()) blocking.blocked.push_back(blocked);
      }
    }
    spec_.blocking = blocking;
    directions_ = names;
  }

  /// The connections in an order in which some plan might take them off: whatever this order keeps
  /// is not what leaves a problem without a plan.
  Names some_order() {
    std::vector<std::size_t> parts(spec_.parts.size());
    std::iota(parts.begin(), parts.end(), 0);
    draw_.shuffle(parts);
    std::vector<std::size_t> connections(spec_.connections.size());
    std::iota(connections.begin(), connections.end(), 0);
    draw_.shuffle(connections);
    if (by_part()) {
      // Part after part goes, each with the connections that it still has.
      const auto goes = [&](std::size_t c) {
        std::size_t first = parts.size();
        for (const std::string& end : spec_.connections[c].parts) {
          const auto at = std::find(parts.begin(), parts.end(), place_of(end));
          first = std::min(first, static_cast<std::size_t>(at - parts.begin()));
        }
        return first;
      };
      std::stable_sort(connections.begin(), connections.end(),
                       [&](std::size_t x, std::size_t y) { return goes(x) < goes(y); });
    }
    Names ids;
    for (const std::size_t c : connections) ids.push_back(id_of(spec_.connections[c]));
    return ids;
  }

  void add_precedence() {
    if (spec_.connections.size() < 2) return;
    const Names order = some_order();
    const bool may_cycle = draw_.chance(0.1);
    const std::size_t entries = draw_.between(1, 4);
    for (std::size_t e = 0; e < entries; ++e) {
      const std::size_t at = draw_.between(0, order.size() - 1);
      Precedence entry;
      entry.connection = order[at];
      Names sooner(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(at));
      Names later(order.begin() + static_cast<std::ptrdiff_t>(at) + 1, order.end());
      if (may_cycle) {
        sooner.insert(sooner.end(), later.begin(), later.end());
        later = sooner;
      }
      // What is made before is removed later.
      if (!sooner.empty() && draw_.chance(0.45)) entry.after = draw_.some_of(sooner, 2);
      if (!sooner.empty() && draw_.chance(0.35)) entry.after_any = draw_.some_of(sooner, 3);
      if (!later.empty() && draw_.chance(0.35)) entry.made_after = draw_.some_of(later, 2);
      if (!later.empty() && draw_.chance(0.35)) entry.made_after_any = draw_.some_of(later, 3);
      const bool says_something = !entry.after.empty() || !entry.after_any.empty() ||
                                  !entry.made_after.empty() || !entry.made_after_any.empty();
      if (says_something) spec_.precedence.push_back(entry);
    }
  }

  void add_limits() {
    const double likely = draw_.number({0, 0.25, 0.5});
    if (draw_.chance(likely)) spec_.limits.max_subassemblies = draw_.between(1, 3);
    if (draw_.chance(likely)) spec_.limits.max_moved_parts = draw_.between(1, 3);
    if (draw_.chance(likely)) spec_.limits.max_moved_mass = draw_.number({0.3, 0.6, 2, 4, 8});
  }

  void add_goal() {
    Names parts;
    for (const Part& part : spec_.parts) parts.push_back(part.id);
    Names connections;
    for (const Connection& connection : spec_.connections) connections.push_back(id_of(connection));
    Goal goal;
    const std::size_t kind = draw_.between(0, 9);
    if (kind < 5) goal.free = draw_.some_of(parts, 2);
    if (kind >= 4 && kind < 8 && !connections.empty()) goal.removed = draw_.some_of(connections, 2);
    if (kind >= 8 || draw_.chance(0.4)) goal.stop = Goal::Stop::Best;
    spec_.goal = goal;
  }

  // ---- objectives

  [[nodiscard]] bool positions_known() const {
    return std::all_of(spec_.parts.begin(), spec_.parts.end(),
                       [](const Part& part) { return part.position.has_value(); });
  }
  [[nodiscard]] bool places_known() const {
    return std::all_of(
        spec_.connections.begin(), spec_.connections.end(), [this](const Connection& connection) {
          return connection.position || (spec_.parts[place_of(connection.parts[0])].position &&
                                         spec_.parts[place_of(connection.parts[1])].position);
        });
  }
  /// The attributes over which there may be a changeover.
  [[nodiscard]] Names attributes() const {
    std::set<std::string> known;
    for (const Connection& connection : spec_.connections) {
      for (const auto& attribute : connection.attributes) known.insert(attribute.first);
    }
    if (spec_.blocking) known.insert("direction");
    return {known.begin(), known.end()};
  }
  [[nodiscard]] Names numbers() const {
    std::set<std::string> known;
    for (const Part& part : spec_.parts) {
      for (const auto& number : part.numbers) known.insert(number.first);
    }
    for (const Connection& connection : spec_.connections) {
      for (const auto& number : connection.numbers) known.insert(number.first);
    }
    return {known.begin(), known.end()};
  }

  /// Those that fit what is stated; more than once what is to come up more often.
  [[nodiscard]] Names types() const {
    Names types = {"piece_cost", "cubesat",    "cubesat_zone", "custom",    "time",
                   "fuel",       "completion", "expression",   "expression"};
    if (!by_part()) types.push_back("indexed");
    if (positions_known()) types.push_back("travel");
    if (places_known()) types.insert(types.end(), {"route", "route", "route"});
    if (!attributes().empty()) types.insert(types.end(), 5, "changeover");
    return types;
  }

  Objective objective() {
    if (draw_.chance(0.25)) return objective(draw_.one_of(types()));
    return sum(0);
  }

  Objective sum(std::size_t depth) {
    WeightedSum sum;
    const std::size_t terms = draw_.between(1, 4);
    for (std::size_t t = 0; t < terms; ++t) {
      const double weight = draw_.number({1, 1, 1, 0.5, 2, 0.1, 0, -1, -0.5});
      const bool nested = depth < 2 && draw_.chance(0.1);
      sum.terms.push_back(
          {weight, nested ? this->sum(depth + 1) : objective(draw_.one_of(types()))});
    }
    return {"sum", sum};
  }

  Objective objective(const std::string& type) {
    if (type == "piece_cost") {
      PieceCost cost{.operation = draw_.number({0, 0.25, 1, -0.5}),
                     .pieces = {},
                     .completion = draw_.number({0, 1, 3, -2})};
      for (std::size_t size = 1; size <= 5; ++size) {
        if (draw_.chance(0.6)) cost.pieces[size] = draw_.number({0.5, 0.5, 1.75, -1, 0.125});
      }
      return {type, cost};
    }
    if (type == "time") {
      return {type, TimeObjective{.depot = draw_.point(),
                                  .speed = draw_.number({0.25, 1, 3}),
                                  .transfer = draw_.number({0, 0.5, 2})}};
    }
    if (type == "travel") return {type, Travel{.depot = draw_.point()}};
    if (type == "fuel") {
      return {type, Fuel{.dry_mass = draw_.number({1, 6, 10}),
                         .delta_v = draw_.number({0, 30, 150}),
                         .isp = draw_.number({100, 200, 900})}};
    }
    if (type == "completion") {
      return {type, CompletionObjective{.join = draw_.number({-5, 0, 10}),
                                        .step = draw_.number({-1, 1, 2}),
                                        .bonus = draw_.number({-20, 0, 20})}};
    }
    if (type == "changeover") return {type, changeover()};
    if (type == "route") {
      Route route{.start = {}, .per_metre = draw_.number({0.5, 1, 2, 3.5})};
      if (draw_.chance(0.5)) route.start = draw_.point();
      return {type, route};
    }
    if (type == "expression") {
      return {type, Expression{.formula = formula(),
                               .constants = {{"alpha", draw_.number({-1.5, 0.75, 2})}},
                               .depot = draw_.point(),
                               .compiler = compile_formula}};
    }
    return Objective::named(type);
  }

  Changeover changeover() {
    Changeover changeover;
    changeover.attribute = draw_.one_of(attributes());
    changeover.cost = draw_.number({0.5, 1, 1, 2.5, 4});
    // "X" is a value that no step has.
    Names values = {"A", "B", "C", "X"};
    if (changeover.attribute == "grip") values = {"wide", "thin", "X"};
    if (changeover.attribute == "direction") values = directions_;
    if (draw_.chance(0.5)) changeover.start = draw_.one_of(values);
    for (const std::string& from : values) {
      for (const std::string& to : values) {
        if (from != to && draw_.chance(0.15))
          changeover.costs.push_back({from, to, draw_.number({0, 0.25, 3, -0.5})});
      }
    }
    return changeover;
  }

  std::string formula() {
    Names names = {"before",     "after",   "separates", "completes", "moved_parts",
                   "kept_parts", "elapsed", "elapsed",   "distance",  "moved_mass",
                   "kept_mass",  "alpha",   "duration",  "duration",  "subassemblies"};
    if (!by_part()) names.emplace_back("index");
    for (const std::string& number : numbers()) {
      for (const char* const piece : {"", "moved_", "kept_"}) {
        names.push_back(piece + number);
        names.push_back(piece + number);
      }
    }
    const Names factors = {"1", "2", "0.25", "1.5", "0.1"};
    const auto factor = [&]() -> std::string {
      if (draw_.chance(0.25))
        return "(" + draw_.one_of(names) + " - " + draw_.one_of(factors) + ")";
      return draw_.one_of(names);
    };
    std::string formula = draw_.chance(0.5) ? "-" : "";
    const std::size_t terms = draw_.between(1, 3);
    for (std::size_t t = 0; t < terms; ++t) {
      if (t > 0) formula += draw_.chance(0.5) ? " + " : " - ";
      formula += draw_.one_of(factors) + "*" + factor();
      if (draw_.chance(0.4)) formula += "*" + factor();
      if (draw_.chance(0.2))
        formula += "/(1 + " + draw_.one_of(Names{"before", "elapsed", "distance"}) + ")";
    }
    return formula;
  }

  Draw draw_;
  Names directions_;  ///< of blocking
  ProblemSpec spec_{};
};

}  // namespace
}  // namespace wide_problems

ProblemSpec wide_random_problem(std::uint64_t seed) {
  return wide_problems::Maker(SplitMix64(seed + 1).next()).make(seed);
}

}  // namespace orasp
