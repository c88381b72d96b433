#include <algorithm>
#include <numeric>
#include <utility>

#include "orasp/model/detail/rules.h"
#include "orasp/model/detail/step_scratch.h"
#include "orasp/model/detail/wording.h"

namespace orasp {

using detail::kUnlimited;

// Precedence holds `connection` until `other` is gone, which stays.
Violation TransitionSystem::waits_in_vain(ConnectionIndex connection, ConnectionIndex other,
                                          std::size_t entry) const {
  const std::string id = detail::in_quotes(problem_.connection_id(connection));
  const std::string other_id = detail::in_quotes(problem_.connection_id(other));
  return {Constraint::Precedence,
          "precedence[" + std::to_string(entry) + "]",
          rules_->assembly ? id + " must be made before " + other_id + ", which is made already"
                           : id + " waits for " + other_id + ", which is inaccessible",
          {other}};
}

std::optional<Violation> TransitionSystem::infeasibility() const {
  const Rules& rules = *rules_;
  // In disassembly order: the state at which it begins (in assembly, the one that is the goal), and
  // what it ends with.
  const ConnectionSet none(num_connections());
  const ConnectionSet first = present(rules.assembly ? none.view() : start().view());
  const ConnectionSet last = present(rules.assembly ? start().view() : none.view());
  const std::size_t start_pieces = subassemblies(first.view());
  if (num_steps() > 0 && start_pieces > rules.max_subassemblies) {
    return Violation{Constraint::MaxSubassemblies,
                     "limits.max_subassemblies",
                     (rules.whole ? "the whole product is " : "the product as it stands is ") +
                         std::to_string(start_pieces) + " subassemblies; at most " +
                         std::to_string(rules.max_subassemblies) + " are allowed",
                     {}};
  }
  // Precedence alone, in disassembly order: remove whatever may go until nothing more may. The
  // clauses are monotone, so if connections are left, each of them waits for another that stays,
  // and following these ends in a cycle, or at one that is kept. Every clause is looked at again
  // only when a connection that it names goes.
  std::vector<bool> stays(num_connections());
  for (ConnectionIndex c = 0; c < num_connections(); ++c) stays[c] = first.contains(c);
  std::vector<std::vector<ConnectionIndex>> waiting(num_connections());
  for (const PrecedenceClause& clause : problem_.precedence()) {
    for (const ConnectionIndex c : clause.after) waiting[c].push_back(clause.connection);
    for (const ConnectionIndex c : clause.after_any) waiting[c].push_back(clause.connection);
  }
  std::vector<std::vector<const PrecedenceClause*>> clauses(num_connections());
  for (const PrecedenceClause& clause : problem_.precedence())
    clauses[clause.connection].push_back(&clause);
  /// A connection that `c` waits for and the entry that says so.
  const auto waits_for =
      [&](ConnectionIndex c) -> std::optional<std::pair<ConnectionIndex, std::size_t>> {
    for (const PrecedenceClause* clause : clauses[c]) {
      for (const ConnectionIndex other : clause->after) {
        if (stays[other]) return std::pair{other, clause->entry};
      }
      if (!clause->after_any.empty() &&
          std::ranges::all_of(clause->after_any,
                              [&](ConnectionIndex other) { return stays[other]; })) {
        return std::pair{clause->after_any.front(), clause->entry};
      }
    }
    return std::nullopt;
  };
  std::vector<ConnectionIndex> check(num_connections());
  std::iota(check.begin(), check.end(), ConnectionIndex{0});
  std::size_t left = num_steps();
  while (!check.empty()) {
    const ConnectionIndex c = check.back();
    check.pop_back();
    if (!stays[c] || last.contains(c) || waits_for(c)) continue;
    stays[c] = false;
    --left;
    check.insert(check.end(), waiting[c].begin(), waiting[c].end());
  }
  if (left == 0) return std::nullopt;
  // Walk from the first that is left until a connection comes up again: from there on it is the
  // cycle. Or until one that is kept comes up.
  std::vector<std::size_t> met(num_connections(), kUnlimited);
  std::vector<std::pair<ConnectionIndex, std::size_t>> path;
  ConnectionIndex c = 0;
  while (!stays[c] || last.contains(c)) ++c;
  while (met[c] == kUnlimited) {
    if (last.contains(c)) return waits_in_vain(path.back().first, c, path.back().second);
    met[c] = path.size();
    const auto next = waits_for(c);
    path.emplace_back(c, next->second);
    c = next->first;
  }
  Violation violation;
  violation.constraint = Constraint::Precedence;
  std::string chain;
  for (std::size_t i = met[c]; i < path.size(); ++i) {
    const ConnectionIndex next = i + 1 < path.size() ? path[i + 1].first : c;
    violation.blocking_connections.push_back(path[i].first);
    chain += (chain.empty() ? "" : ", ") +
             detail::in_quotes(problem_.connection_id(path[i].first)) + " after " +
             detail::in_quotes(problem_.connection_id(next)) + " (precedence[" +
             std::to_string(path[i].second) + "])";
  }
  violation.where = "precedence[" + std::to_string(path[met[c]].second) + "]";
  violation.message = "precedence is a cycle: " + chain;
  std::ranges::sort(violation.blocking_connections);
  return violation;
}

}  // namespace orasp
