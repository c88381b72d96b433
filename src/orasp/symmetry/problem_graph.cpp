#include "orasp/symmetry/problem_graph.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <memory>
#include <string_view>
#include <variant>
#include <vector>

#include "orasp/model/objective.h"

namespace orasp {
namespace {

/// A text that is the same for the same values, bit by bit.
class Key {
 public:
  Key& text(std::string_view value) {
    text_ += std::to_string(value.size());
    text_ += ':';
    text_ += value;
    return *this;
  }
  Key& number(double value) {
    value += 0.0;  // one zero
    std::array<char, sizeof(double)> bytes{};
    std::memcpy(bytes.data(), &value, bytes.size());
    text_.append(bytes.data(), bytes.size());
    return *this;
  }
  Key& numbers(const std::map<std::string, double>& values) {
    number(static_cast<double>(values.size()));
    for (const auto& [name, value] : values) text(name).number(value);
    return *this;
  }
  [[nodiscard]] const std::string& value() const { return text_; }

 private:
  std::string text_;
};

/// With more directions than these none is taken for another.
constexpr std::size_t kMostTurnedDirections = 64;

/// Of formulas: what a symmetry leaves as it is, whatever rounding does. Masses of pieces are sums
/// in some order, `index` and `distance` see what is no colour.
constexpr std::array<std::string_view, 8> kSafeVariables = {
    "before",      "after",      "separates",     "completes",
    "moved_parts", "kept_parts", "subassemblies", "duration"};

/// Judges an objective, and adds to the colour of each connection what it alone sees of it.
class ObjectiveJudge {
 public:
  ObjectiveJudge(const Problem& problem, std::vector<Key>& connections)
      : problem_(problem), connections_(connections) {}

  /// Why it stands in the way of symmetry; empty where it does not.
  [[nodiscard]] std::optional<std::string> against(const Objective& objective) {
    type_ = objective.type;
    return std::visit([this](const auto& parameters) { return judge(parameters); },
                      objective.parameters);
  }

 private:
  using Reason = std::optional<std::string>;

  // All that is known to be safe; of anything else nothing is known.
  template <class Other>
  Reason judge(const Other&) const {
    return "finds no symmetry under the objective '" + type_ +
           "', which may look at more than the shape of the product";
  }
  Reason judge(const PieceCost& cost) const {
    const auto& [operation, pieces, completion] = cost;
    static_cast<void>(operation), static_cast<void>(pieces), static_cast<void>(completion);
    return std::nullopt;  // sees sizes
  }
  Reason judge(const CubesatZone&) const { return std::nullopt; }  // sees sizes of pieces
  Reason judge(const CompletionObjective& completion) const {
    const auto& [join, step, bonus] = completion;
    static_cast<void>(join), static_cast<void>(step), static_cast<void>(bonus);
    return std::nullopt;  // sees whether a step separates
  }
  Reason judge(const TimeObjective& time) const {
    const auto& [depot, speed, transfer] = time;
    static_cast<void>(depot), static_cast<void>(speed), static_cast<void>(transfer);
    const bool positions = std::ranges::any_of(
        problem_.parts(), [](const Part& part) { return part.position.has_value(); });
    if (positions) return "finds no symmetry where the objective 'time' looks at positions";
    return std::nullopt;  // sees durations
  }
  Reason judge(const Fuel& fuel) const {
    const auto& [dry_mass, delta_v, isp] = fuel;
    static_cast<void>(dry_mass), static_cast<void>(delta_v), static_cast<void>(isp);
    return std::nullopt;  // sees masses
  }
  Reason judge(const WeightedSum& sum) {
    const auto& [terms] = sum;
    return of_all(terms);
  }
  Reason judge(const Retried& retried) {
    const auto& [attempts, once] = retried;
    for (std::size_t c = 0; c < connections_.size(); ++c) connections_[c].number(attempts[c]);
    return of_all(once);
  }
  Reason judge(const Expression& expression) const {
    const auto& [text, constants, depot, compiler] = expression;
    static_cast<void>(depot);
    std::vector<std::string> own;
    std::map<std::string, double> all;
    for (const Part& part : problem_.parts()) all.insert(part.numbers.begin(), part.numbers.end());
    for (const Connection& c : problem_.connections())
      all.insert(c.numbers.begin(), c.numbers.end());
    for (const auto& [number, value] : all) {
      for (std::string& name : names_in_formulas(number)) own.push_back(std::move(name));
    }
    const std::unique_ptr<Formula> formula = compiler(text, constants, own);
    const auto against = [](std::string_view name) {
      return "finds no symmetry where the formula looks at '" + std::string(name) + "'";
    };
    for (const FormulaVariable& variable : kFormulaVariables) {
      const bool safe = std::ranges::find(kSafeVariables, variable.name) != kSafeVariables.end();
      if (!safe && formula->uses(variable.name)) return against(variable.name);
    }
    for (std::size_t i = 0; i < own.size(); ++i) {
      // The first of three is the connection's own, which is in its colour.
      if (i % 3 != 0 && formula->uses(own[i])) return against(own[i]);
    }
    return std::nullopt;
  }

  Reason of_all(const std::vector<WeightedObjective>& terms) {
    for (const auto& [weight, objective] : terms) {
      static_cast<void>(weight);
      if (Reason reason = against(objective)) return reason;
    }
    return std::nullopt;
  }

  const Problem& problem_;
  std::vector<Key>& connections_;
  std::string type_;
};

class Builder {
 public:
  explicit Builder(const TransitionSystem& system)
      : system_(system), problem_(system.problem()), connections_(system.num_connections()) {}

  ProblemGraph build() {
    ProblemGraph result;
    result.obstacle = obstacle();
    if (result.obstacle) return result;
    add_parts();
    add_connections();
    add_precedence();
    add_blocking();
    result.graph.colours = std::move(colours_);
    std::ranges::sort(edges_);
    edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
    result.graph.edges = std::move(edges_);
    return result;
  }

 private:
  [[nodiscard]] std::optional<std::string> obstacle() {
    // Each member of the problem is named here or below: those that are not seen by any rule or
    // reward (names, notes, shapes), those of fleets, and those that colours, edges or the tests of
    // this function stand for.
    const auto& [name, note, source, parts, connections, precedence, blocking, limits, base, goal,
                 action, objective, direction, fleet, geometry] = problem_.spec();
    static_cast<void>(name), static_cast<void>(note), static_cast<void>(source);
    static_cast<void>(parts), static_cast<void>(connections), static_cast<void>(precedence);
    static_cast<void>(blocking), static_cast<void>(base), static_cast<void>(direction);
    static_cast<void>(fleet), static_cast<void>(geometry);
    // Limits look at numbers of parts and pieces, at masses and at the base.
    const auto& [max_subassemblies, max_moved_parts, max_moved_mass, grounded] = limits;
    static_cast<void>(max_subassemblies), static_cast<void>(max_moved_parts);
    static_cast<void>(max_moved_mass), static_cast<void>(grounded);
    // Open and inaccessible ones are told apart by the start and what is kept; nothing else may be
    // said.
    const auto& [open, inaccessible, not_next, late, in_force, last_place] = system_.situation();
    static_cast<void>(open), static_cast<void>(inaccessible);
    static_cast<void>(not_next), static_cast<void>(late);
    static_cast<void>(in_force), static_cast<void>(last_place);
    if (system_.ordered()) return "finds no symmetry where some connections are late or not next";
    if (goal || action != StepKind::Connection || system_.wide())
      return "finds no symmetry where there is more to a step than one connection: with a goal, "
             "with steps that take parts off, or with costs between steps";
    if (problem_.uncertain()) return "finds no symmetry where attempts may fail";
    return ObjectiveJudge(problem_, connections_).against(objective);
  }

  std::uint32_t vertex(const std::string& colour) {
    const auto [found, is_new] =
        numbers_.emplace(colour, static_cast<std::uint32_t>(numbers_.size()));
    colours_.push_back(found->second);
    return static_cast<std::uint32_t>(colours_.size() - 1);
  }
  void join(std::uint32_t a, std::uint32_t b) {
    if (a != b) edges_.push_back({std::min(a, b), std::max(a, b)});
  }
  [[nodiscard]] std::uint32_t of(ConnectionIndex c) const {
    return ProblemGraph::vertex_of_connection(problem_, c);
  }

  void add_parts() {
    for (PartIndex p = 0; p < problem_.num_parts(); ++p) {
      const auto& [id, name, mass, position, numbers, product] = problem_.parts()[p];
      static_cast<void>(id), static_cast<void>(name), static_cast<void>(position);
      // What parts are called decides nothing: two that are told apart in no other way are equal.
      static_cast<void>(product);
      Key key;
      key.text("part").number(mass).numbers(numbers).number(problem_.in_base(p) ? 1 : 0);
      vertex(key.value());
    }
  }

  void add_connections() {
    for (ConnectionIndex c = 0; c < problem_.num_connections(); ++c) {
      const auto& [id, parts, duration, success, axis, on_failure, numbers, attributes, position] =
          problem_.connections()[c];
      static_cast<void>(id), static_cast<void>(parts), static_cast<void>(position);
      // Attempts that may fail are a reason against symmetry.
      static_cast<void>(on_failure);
      Key key;
      key.text("connection").number(duration).number(success).text(axis).numbers(numbers);
      key.number(static_cast<double>(attributes.size()));
      for (const auto& [attribute, value] : attributes) key.text(attribute).text(value);
      key.number(system_.start().contains(c) ? 1 : system_.kept().contains(c) ? 2 : 0);
      key.text(connections_[c].value());  // what the objective sees
      const std::uint32_t here = vertex(key.value());
      for (const PartIndex part : problem_.ends(c)) join(here, part);
    }
  }

  void add_precedence() {
    for (const PrecedenceClause& clause : problem_.precedence()) {
      const auto& [entry, connection, after, after_any, made_after_any] = clause;
      static_cast<void>(entry);
      const auto list = [&](const std::vector<ConnectionIndex>& others, const char* colour) {
        if (others.empty()) return;
        const std::uint32_t subject = vertex(std::string(colour) + " of");
        const std::uint32_t those = vertex(colour);
        join(subject, of(connection));
        join(subject, those);
        for (const ConnectionIndex other : others) join(those, of(other));
      };
      list(after, "after");
      list(after_any, "after_any");
      list(made_after_any, "made_after_any");
    }
  }

  // Each part that another one blocks, with the directions in which it does: in both orders, since
  // what it blocks along a direction is blocked by it along the opposite. A step is legal if there
  // is some direction in which nothing is in the way, so nothing but which directions the pairs
  // have in common counts: directions are vertices, and may be exchanged, of all pairs at once.
  void add_blocking() {
    if (problem_.directions().size() > kMostTurnedDirections) return add_fixed_blocking();
    std::map<std::size_t, std::uint32_t> vertex_of_direction;
    for (const DirectionIndex d : problem_.directions())
      vertex_of_direction.emplace(d.value(), vertex("direction"));
    // By the pair, the smaller part first: the vertices of its two orders.
    std::map<std::pair<PartIndex, PartIndex>, std::uint32_t> other_order;
    for (PartIndex part = 0; part < problem_.num_parts(); ++part) {
      for (const Blocker& blocker : problem_.blockers()[part]) {
        const std::uint32_t here = vertex("blocked");
        join(here, part);
        for (const DirectionIndex d : problem_.directions()) {
          if (problem_.blocks(blocker, d.value())) join(here, vertex_of_direction.at(d.value()));
        }
        const std::pair<PartIndex, PartIndex> pair = std::minmax<PartIndex>(part, blocker.by);
        const auto [there, is_new] = other_order.emplace(pair, here);
        if (!is_new) join(here, there->second);
      }
    }
  }

  // Where there are many directions: each stays what it is. One of two parts that block each other
  // says all. It is the one whose directions come first, so that the order of the file does not
  // matter.
  void add_fixed_blocking() {
    const auto directions = [&](const Blocker& blocker, bool turned) {
      std::string text;
      for (const DirectionIndex d : problem_.directions())
        text += problem_.blocks(blocker, turned ? opposite(std::size_t{d}) : std::size_t{d}) ? '1'
                                                                                             : '0';
      return text;
    };
    for (PartIndex part = 0; part < problem_.num_parts(); ++part) {
      for (const Blocker& blocker : problem_.blockers()[part]) {
        if (blocker.by < part) continue;  // met from the other part
        const std::string here = directions(blocker, false);
        const std::string there = directions(blocker, true);
        if (here == there) {
          const std::uint32_t both = vertex("blocked " + here);
          join(both, part);
          join(both, blocker.by);
          continue;
        }
        const std::uint32_t first = vertex("blocked " + std::min(here, there));
        const std::uint32_t second = vertex("blocks");
        join(first, second);
        join(first, here < there ? part : PartIndex{blocker.by});
        join(second, here < there ? PartIndex{blocker.by} : part);
      }
    }
  }

  const TransitionSystem& system_;
  const Problem& problem_;
  std::vector<Key> connections_;
  std::map<std::string, std::uint32_t> numbers_;
  std::vector<std::uint32_t> colours_;
  std::vector<std::array<std::uint32_t, 2>> edges_;
};

}  // namespace

ProblemGraph problem_graph(const TransitionSystem& system) {
  return Builder(system).build();
}

}  // namespace orasp
