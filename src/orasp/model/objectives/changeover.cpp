#include "orasp/model/objectives/changeover.h"

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "orasp/model/detail/wording.h"
#include "orasp/model/objectives/objective_kind.h"

namespace orasp {
namespace {

using detail::in_quotes;

class ChangeoverTerm : public ObjectiveTerm {
 public:
  ChangeoverTerm(const Changeover& changeover, const detail::ProblemTotals& totals)
      : slot_(totals.attribute(changeover.attribute)),
        values_(totals.attributes[slot_].values.size()),
        of_connection_(totals.attributes[slot_].of_connection),
        cost_(changeover.cost) {
    sees.looks_back = true;
    const std::vector<std::string>& values = totals.attributes[slot_].values;
    const auto number = [&values](const std::string& value) -> std::size_t {
      return static_cast<std::size_t>(std::ranges::find(values, value) - values.begin()) + 1;
    };
    // A start that no step has is a value of its own, from which every value is a change.
    if (changeover.start) start_ = number(*changeover.start);
    for (const ChangeCost& change : changeover.costs) {
      const bool from_start = changeover.start && change.from == *changeover.start;
      const std::size_t from = number(change.from);
      const std::size_t to = number(change.to);
      if ((from <= values_ || from_start) && to <= values_) costs_[{from, to}] = change.cost;
    }
    least_ = greatest_ = cost_;
    for (const auto& [change, cost] : costs_) {
      least_ = std::min(least_, cost);
      greatest_ = std::max(greatest_, cost);
    }
  }

  [[nodiscard]] double reward(const detail::StepFacts& facts, const detail::Movement& movement,
                              const detail::StepPieces& pieces) const override {
    static_cast<void>(facts);
    static_cast<void>(movement);
    if (pieces.memory == nullptr) return 0;
    return 0.0 - cost(pieces.memory->in_force[slot_], pieces.memory->here[slot_]);
  }
  [[nodiscard]] RewardRange range(const RangeQuestion& question) const override {
    const bool changes = of_connection_.empty() || of_connection_[question.connection] != 0;
    if (!changes) return {0, 0};
    return {0.0 - std::max(0.0, greatest_), 0.0 - std::min(0.0, least_)};
  }
  [[nodiscard]] std::optional<LookBackCosts> look_back_costs() const override {
    return LookBackCosts{.attribute = slot_, .change = [this](std::size_t from, std::size_t to) {
                           return cost(from, to);
                         }};
  }

 private:
  /// What coming to the value `to` costs; 0 stands for no value yet, and for a step without one.
  [[nodiscard]] double cost(std::size_t from, std::size_t to) const {
    if (from == 0) from = start_;
    if (from == 0 || to == 0 || from == to) return 0;
    if (costs_.empty()) return cost_;
    const auto listed = costs_.find({from, to});
    return listed == costs_.end() ? cost_ : listed->second;
  }

  std::size_t slot_;
  std::size_t values_;
  const std::vector<std::uint32_t>& of_connection_;
  double cost_;
  std::size_t start_ = 0;
  std::map<std::pair<std::size_t, std::size_t>, double> costs_;
  double least_ = 0;
  double greatest_ = 0;
};

class ChangeoverKind : public ObjectiveKindOf<Changeover> {
  void list(Changeover& changeover, ParameterVisitor& visitor) const override {
    visitor.name("attribute", changeover.attribute);
    visitor.number("cost", changeover.cost);
    visitor.changes("costs", changeover.costs);
    visitor.optional_name("start", changeover.start);
  }
  void check_whole(const Changeover& changeover, const std::string& place) const override {
    std::set<std::pair<std::string, std::string>> listed;
    for (std::size_t i = 0; i < changeover.costs.size(); ++i) {
      const ChangeCost& change = changeover.costs[i];
      const std::string entry = place + ".costs[" + std::to_string(i) + "]";
      if (change.from == change.to)
        throw InputError(detail::at(
            entry, "from " + in_quotes(change.from) + " to itself is no change and costs nothing"));
      if (!listed.emplace(change.from, change.to).second)
        throw InputError(detail::at(entry, "the change from " + in_quotes(change.from) + " to " +
                                               in_quotes(change.to) + " is listed twice"));
    }
  }
  void require_of_problem(const Changeover& changeover, const ProblemSpec& problem,
                          const std::string& place) const override {
    if (changeover.attribute == kDirectionAttribute) {
      if (!problem.blocking)
        throw InputError(detail::at(place + ".attribute",
                                    "the direction in which a piece leaves is known by "
                                    "\"blocking\" only, and the problem has none"));
      require_directions(changeover, *problem.blocking, place);
      return;
    }
    std::set<std::string> known;
    for (const Connection& connection : problem.connections) {
      for (const auto& attribute : connection.attributes) known.insert(attribute.first);
    }
    if (known.contains(changeover.attribute) || problem.connections.empty()) return;
    std::string message = "no connection has the attribute " + in_quotes(changeover.attribute);
    const std::vector<std::string_view> names(known.begin(), known.end());
    if (!names.empty())
      message += "; attributes are " + detail::listed(names) +
                 detail::suggestion(changeover.attribute, names);
    throw InputError(detail::at(place + ".attribute", message));
  }
  /// What is said of directions names those of the problem.
  static void require_directions(const Changeover& changeover, const Blocking& blocking,
                                 const std::string& place) {
    std::vector<std::string> names;
    for (const BlockingDirection& direction : blocking.directions) {
      names.push_back(direction.id);
      if (direction.vector) names.push_back("-" + direction.id);
    }
    const std::vector<std::string_view> known(names.begin(), names.end());
    const auto require = [&](const std::string& name, const std::string& where) {
      if (std::ranges::find(names, name) != names.end()) return;
      throw InputError(
          detail::at(where, in_quotes(name) + " is not in blocking.directions, which are " +
                                detail::listed_in_short(known) + detail::suggestion(name, known)));
    };
    if (changeover.start) require(*changeover.start, place + ".start");
    for (std::size_t i = 0; i < changeover.costs.size(); ++i) {
      const std::string entry = place + ".costs[" + std::to_string(i) + "]";
      require(changeover.costs[i].from, entry + ".from");
      require(changeover.costs[i].to, entry + ".to");
    }
  }
  void look_back_at(const Changeover& changeover, LookBack& look_back) const override {
    look_back.add_attribute(changeover.attribute);
  }
  [[nodiscard]] std::unique_ptr<const ObjectiveTerm> term(
      const Changeover& changeover, const detail::ProblemTotals& totals) const override {
    return std::make_unique<ChangeoverTerm>(changeover, totals);
  }
  [[nodiscard]] detail::CheckedTerm checked(const Changeover& changeover,
                                            const detail::CheckedProblem& problem) const override {
    static_cast<void>(problem);
    detail::CheckedTerm term;
    term.looks_back = true;
    term.value = [&changeover](const detail::SeenStep& step) -> detail::CheckedValue {
      const auto here = step.attributes.find(changeover.attribute);
      if (here == step.attributes.end()) return {0};
      const auto last = step.in_force.find(changeover.attribute);
      if (last == step.in_force.end() && !changeover.start) return {0};
      const std::string& from = last == step.in_force.end() ? *changeover.start : last->second;
      if (from == here->second) return {0};
      for (const ChangeCost& change : changeover.costs) {
        if (change.from == from && change.to == here->second) return {0.0 - change.cost};
      }
      return {0.0 - changeover.cost};
    };
    return term;
  }
};

}  // namespace

const ObjectiveKind& changeover_kind() {
  static const ChangeoverKind kind;
  return kind;
}

}  // namespace orasp
