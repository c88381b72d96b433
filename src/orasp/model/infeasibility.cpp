#include <algorithm>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

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

namespace {

/// Precedence alone, in disassembly order: whatever may go is removed until nothing more may. The
/// clauses are monotone, so if connections are left, each of them waits for another that stays, and
/// following these ends in a cycle, or at one that is inaccessible.
class Peeling {
 public:
  /// `first` is there at the start of the disassembly, `last` at its end.
  Peeling(const Problem& problem, const ConnectionSet& first, const ConnectionSet& last)
      : last_(last),
        stays_(problem.num_connections()),
        clauses_(problem.num_connections()),
        waiting_(problem.num_connections()) {
    for (ConnectionIndex c = 0; c < stays_.size(); ++c) stays_[c] = first.contains(c);
    for (const PrecedenceClause& clause : problem.precedence()) {
      clauses_[clause.connection].push_back(&clause);
      for (const ConnectionIndex c : clause.after) waiting_[c].push_back(clause.connection);
      for (const ConnectionIndex c : clause.after_any) waiting_[c].push_back(clause.connection);
    }
  }

  /// Removes what may go; returns how many. A clause is looked at again only when a connection that
  /// it names goes.
  std::size_t remove() {
    std::vector<ConnectionIndex> check(stays_.size());
    std::iota(check.begin(), check.end(), ConnectionIndex{0});
    std::size_t removed = 0;
    while (!check.empty()) {
      const ConnectionIndex c = check.back();
      check.pop_back();
      if (!stays_[c] || last_.contains(c) || waits_for(c)) continue;
      stays_[c] = false;
      ++removed;
      check.insert(check.end(), waiting_[c].begin(), waiting_[c].end());
    }
    return removed;
  }

  /// A connection and the entry of precedence by which it waits for the next one.
  using Link = std::pair<ConnectionIndex, std::size_t>;
  struct Chain {
    std::vector<Link> links;
    std::size_t cycle_from = 0;   ///< where the cycle begins, if it is one
    ConnectionIndex ends_at = 0;  ///< what the last link waits for
    bool is_cycle = false;
  };
  /// Follows who waits for whom, from the first connection that is left.
  [[nodiscard]] Chain chain() const {
    std::vector<std::size_t> met(stays_.size(), kUnlimited);
    Chain chain;
    ConnectionIndex c = 0;
    while (!stays_[c] || last_.contains(c)) ++c;
    while (met[c] == kUnlimited && !last_.contains(c)) {
      met[c] = chain.links.size();
      const auto next = waits_for(c);
      chain.links.emplace_back(c, next->second);
      c = next->first;
    }
    chain.ends_at = c;
    chain.is_cycle = !last_.contains(c);
    if (chain.is_cycle) chain.cycle_from = met[c];
    return chain;
  }

 private:
  /// A connection that `c` waits for and the entry that says so.
  [[nodiscard]] std::optional<Link> waits_for(ConnectionIndex c) const {
    for (const PrecedenceClause* clause : clauses_[c]) {
      for (const ConnectionIndex other : clause->after) {
        if (stays_[other]) return Link{other, clause->entry};
      }
      if (!clause->after_any.empty() &&
          std::ranges::all_of(clause->after_any,
                              [&](ConnectionIndex other) { return stays_[other]; })) {
        return Link{clause->after_any.front(), clause->entry};
      }
    }
    return std::nullopt;
  }

  const ConnectionSet& last_;
  std::vector<bool> stays_;
  std::vector<std::vector<const PrecedenceClause*>> clauses_;  ///< by connection
  std::vector<std::vector<ConnectionIndex>> waiting_;          ///< by connection: who names it
};

Violation cycle_of(const Problem& problem, const Peeling::Chain& chain) {
  Violation violation;
  violation.constraint = Constraint::Precedence;
  std::string text;
  for (std::size_t i = chain.cycle_from; i < chain.links.size(); ++i) {
    const auto& [connection, entry] = chain.links[i];
    const ConnectionIndex next =
        i + 1 < chain.links.size() ? chain.links[i + 1].first : chain.ends_at;
    violation.blocking_connections.push_back(connection);
    text += (text.empty() ? "" : ", ") + detail::in_quotes(problem.connection_id(connection)) +
            " after " + detail::in_quotes(problem.connection_id(next)) + " (precedence[" +
            std::to_string(entry) + "])";
  }
  violation.where = "precedence[" + std::to_string(chain.links[chain.cycle_from].second) + "]";
  violation.message = "precedence is a cycle: " + text;
  std::ranges::sort(violation.blocking_connections);
  return violation;
}

}  // namespace

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
  Peeling peeling(problem_, first, last);
  if (peeling.remove() == num_steps()) return std::nullopt;
  const Peeling::Chain chain = peeling.chain();
  if (chain.is_cycle) return cycle_of(problem_, chain);
  return waits_in_vain(chain.links.back().first, chain.ends_at, chain.links.back().second);
}

}  // namespace orasp
