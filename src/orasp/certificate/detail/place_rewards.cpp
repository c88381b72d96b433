#include "orasp/certificate/detail/place_rewards.h"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <set>
#include <string>

#include "orasp/certificate/detail/attempts.h"
#include "orasp/certificate/detail/outward.h"

namespace orasp::detail {

namespace {

/// The names of a formula that more is needed for than the connection and its place.
bool sees_more(const Expression& expression, const Problem& problem) {
  std::set<std::string> numbers;
  for (const Part& part : problem.parts()) {
    for (const auto& [name, number] : part.numbers) numbers.insert(name);
  }
  for (const Connection& connection : problem.connections()) {
    for (const auto& [name, number] : connection.numbers) numbers.insert(name);
  }
  std::vector<std::string> own;
  std::vector<std::string> more = {"separates", "moved_parts", "kept_parts", "moved_mass",
                                   "kept_mass", "distance",    "elapsed",    "subassemblies"};
  for (const std::string& number : numbers) {
    const std::array<std::string, 3> names = names_in_formulas(number);
    own.insert(own.end(), names.begin(), names.end());
    more.insert(more.end(), names.begin() + 1, names.end());
  }
  const std::unique_ptr<Formula> formula =
      expression.compiler(expression.formula, expression.constants, own);
  return std::ranges::any_of(more, [&](const std::string& name) { return formula->uses(name); });
}

bool told_by_place(const Objective& objective, const Problem& problem) {
  const ObjectiveParameters& parameters = objective.parameters;
  if (std::holds_alternative<Indexed>(parameters)) return true;
  if (const auto* const expression = std::get_if<Expression>(&parameters))
    return expression->compiler && !sees_more(*expression, problem);
  const auto* const sum = std::get_if<WeightedSum>(&parameters);
  return sum != nullptr && std::ranges::all_of(sum->terms, [&](const WeightedObjective& term) {
           return told_by_place(term.objective, problem);
         });
}

}  // namespace

PlaceRewards::PlaceRewards(const Problem& problem)
    : problem_(problem),
      known_(told_by_place(problem.objective(), problem)),
      rewards_(problem),
      before_(problem.num_connections(), 0),
      behind_(problem.num_connections(), 0) {
  if (known_) count_what_waits();
}

// Counts what waits for each connection, and what it waits for, directly or not.
void PlaceRewards::count_what_waits() {
  const std::size_t connections = problem_.num_connections();
  std::vector<std::vector<ConnectionIndex>> first(connections);
  for (const PrecedenceClause& clause : problem_.precedence())
    first[clause.connection].insert(first[clause.connection].end(), clause.after.begin(),
                                    clause.after.end());
  std::vector<bool> met(connections);
  std::vector<ConnectionIndex> queue;
  for (ConnectionIndex c = 0; c < connections; ++c) {
    met.assign(connections, false);
    met[c] = true;
    queue.assign(1, c);
    for (std::size_t i = 0; i < queue.size(); ++i) {
      for (const ConnectionIndex other : first[queue[i]]) {
        if (met[other]) continue;
        met[other] = true;
        queue.push_back(other);
      }
    }
    before_[c] = queue.size() - 1;
    for (const ConnectionIndex other : queue) behind_[other] += other == c ? 0U : 1U;
  }
}

double PlaceRewards::most(ConnectionIndex connection, std::size_t place) const {
  const std::size_t connections = problem_.num_connections();
  const bool assembly = problem_.direction() == Direction::Assembly;
  const std::size_t present = connections - place;  // before it is removed
  SeenStep step;
  step.connection = connection;
  step.before = assembly ? present - 1 : present;
  step.after = assembly ? present : present - 1;
  step.completes = assembly ? present == connections : present == 1;
  step.duration = problem_.connections()[connection].duration;
  step.own_numbers = problem_.connections()[connection].numbers;
  const CheckedReward::Value value = rewards_.of(step);
  if (!value.finite) return std::numeric_limits<double>::infinity();
  const double lost = 64 * std::numeric_limits<double>::epsilon() * value.magnitude;
  const double once = add_up(value.reward, add_up(value.rounding, lost));
  return all_together(once, attempts_at(problem_, connection));
}

PlaceProof prove_by_places(const PlaceRewards& rewards, std::size_t connections) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const std::size_t n = connections;
  std::vector<double> cost(n * n, kInfinite);
  for (ConnectionIndex c = 0; c < n; ++c) {
    for (std::size_t place = 0; place < n; ++place) {
      if (rewards.possible(c, place)) cost[c * n + place] = 0.0 - rewards.most(c, place);
    }
  }
  // Rows and columns from 1; 0 is a column that holds the row to be placed.
  std::vector<double> row(n + 1, 0.0);
  std::vector<double> column(n + 1, 0.0);
  std::vector<std::size_t> held(n + 1, 0);
  std::vector<std::size_t> way(n + 1, 0);
  for (std::size_t i = 1; i <= n; ++i) {
    held[0] = i;
    std::size_t at = 0;
    std::vector<double> least(n + 1, kInfinite);
    std::vector<bool> done(n + 1, false);
    do {
      done[at] = true;
      std::size_t next = 0;
      double step = kInfinite;
      for (std::size_t j = 1; j <= n; ++j) {
        if (done[j]) continue;
        const double reduced = cost[(held[at] - 1) * n + j - 1] - row[held[at]] - column[j];
        if (reduced < least[j]) {
          least[j] = reduced;
          way[j] = at;
        }
        if (least[j] < step) {
          step = least[j];
          next = j;
        }
      }
      if (next == 0) return {};
      for (std::size_t j = 0; j <= n; ++j) {
        if (done[j]) {
          row[held[j]] += step;
          column[j] -= step;
        } else {
          least[j] -= step;
        }
      }
      at = next;
    } while (held[at] != 0);
    while (at != 0) {
      held[at] = held[way[at]];
      at = way[at];
    }
  }
  PlaceProof proof;
  for (std::size_t i = 1; i <= n; ++i) proof.connections.push_back(0.0 - row[i]);
  for (std::size_t place = 0; place < n; ++place) {
    double most = -kInfinite;
    for (ConnectionIndex c = 0; c < n; ++c) {
      if (rewards.possible(c, place))
        most = std::max(most, add_up(rewards.most(c, place), -proof.connections[c]));
    }
    proof.places.push_back(most);
  }
  return proof;
}

}  // namespace orasp::detail
