#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "orasp/model/detail/step_scratch.h"
#include "orasp/model/detail/wording.h"

namespace orasp {

using detail::kUnlimited;

// Precedence holds `connection` until `other` is handled, which never is.
Violation TransitionSystem::waits_in_vain(ConnectionIndex connection, ConnectionIndex other,
                                          std::size_t entry, bool to_be_made) const {
  const std::string id = detail::in_quotes(problem_.connection_id(connection));
  const std::string other_id = detail::in_quotes(problem_.connection_id(other));
  std::string message;
  if (to_be_made) {
    message = id + (rules_->assembly
                        ? " may be made only after " + other_id + ", which is never made"
                        : " would be left without any of the connections of which it needs one, " +
                              other_id + " among them");
  } else {
    message = rules_->assembly ? id + " must be made before " + other_id + ", which is made already"
                               : id + " waits for " + other_id + ", which is inaccessible";
  }
  return {to_be_made ? Constraint::PrecedenceMadeAny : Constraint::Precedence,
          "precedence[" + std::to_string(entry) + "]",
          std::move(message),
          {other}};
}

namespace {

/// Precedence alone, gone through from one end: whatever may go is removed until nothing more may,
/// or whatever may be made is made. The clauses are monotone, so if connections are left, each of
/// them waits for another that is left, and following these ends in a cycle, or at one that is
/// never handled.
class Peeling {
 public:
  enum class Kind { Removing, Making };

  /// Removing: `first` is there at the start of the disassembly, `last` at its end. Making: `last`
  /// is there at the start, `first` at the end.
  Peeling(Kind kind, const Problem& problem, const ConnectionSet& first, const ConnectionSet& last)
      : kind_(kind),
        first_(first),
        last_(last),
        stays_(problem.num_connections()),
        clauses_(problem.num_connections()),
        waiting_(problem.num_connections()) {
    for (ConnectionIndex c = 0; c < stays_.size(); ++c)
      stays_[c] = first.contains(c) && (kind == Kind::Removing || !last.contains(c));
    const auto waits = [this](ConnectionIndex c, ConnectionIndex other) {
      waiting_[other].push_back(c);
    };
    for (const PrecedenceClause& clause : problem.precedence()) {
      const ConnectionIndex c = clause.connection;
      clauses_[c].push_back(&clause);
      if (kind == Kind::Removing) {
        for (const ConnectionIndex other : clause.after) waits(c, other);
        for (const ConnectionIndex other : clause.after_any) waits(c, other);
      } else {
        for (const ConnectionIndex other : clause.after) {
          if (other != c) clauses_[other].push_back(&clause);
          waits(other, c);
        }
        for (const ConnectionIndex other : clause.made_after_any) waits(c, other);
      }
    }
  }

  /// Handles what may be handled; returns how many. A clause is looked at again only when a
  /// connection that it names is handled.
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
  [[nodiscard]] bool is_left(ConnectionIndex c) const { return stays_[c] && !last_.contains(c); }

  /// Follows who waits for whom, from the first connection that is left, not before `c`.
  [[nodiscard]] Chain chain(ConnectionIndex c = 0) const {
    std::vector<std::size_t> met(stays_.size(), kUnlimited);
    Chain chain;
    while (!is_left(c)) ++c;
    while (met[c] == kUnlimited && is_left(c)) {
      met[c] = chain.links.size();
      const auto next = waits_for(c);
      chain.links.emplace_back(c, next->second);
      c = next->first;
    }
    chain.ends_at = c;
    chain.is_cycle = is_left(c);
    if (chain.is_cycle) chain.cycle_from = met[c];
    return chain;
  }

 private:
  /// A connection that `c` waits for and the entry that says so.
  [[nodiscard]] std::optional<Link> waits_for(ConnectionIndex c) const {
    for (const PrecedenceClause* clause : clauses_[c]) {
      const auto found =
          kind_ == Kind::Removing ? removal_waits_for(*clause) : making_waits_for(c, *clause);
      if (found) return Link{*found, clause->entry};
    }
    return std::nullopt;
  }
  [[nodiscard]] std::optional<ConnectionIndex> removal_waits_for(
      const PrecedenceClause& clause) const {
    const auto stays = [this](ConnectionIndex other) { return bool{stays_[other]}; };
    const auto found = std::ranges::find_if(clause.after, stays);
    if (found != clause.after.end()) return *found;
    if (clause.after_any.empty() || !std::ranges::all_of(clause.after_any, stays))
      return std::nullopt;
    return clause.after_any.front();
  }
  [[nodiscard]] std::optional<ConnectionIndex> making_waits_for(
      ConnectionIndex c, const PrecedenceClause& clause) const {
    if (std::ranges::find(clause.after, c) != clause.after.end() && stays_[clause.connection])
      return clause.connection;
    if (clause.connection != c || clause.made_after_any.empty()) return std::nullopt;
    const auto made = [&](ConnectionIndex other) {
      return other != c && !stays_[other] && (first_.contains(other) || last_.contains(other));
    };
    if (std::ranges::any_of(clause.made_after_any, made)) return std::nullopt;
    const auto to_come = std::ranges::find_if(
        clause.made_after_any, [this](ConnectionIndex other) { return is_left(other); });
    return to_come != clause.made_after_any.end() ? *to_come : clause.made_after_any.front();
  }

  Kind kind_;
  const ConnectionSet& first_;
  const ConnectionSet& last_;
  std::vector<bool> stays_;
  std::vector<std::vector<const PrecedenceClause*>> clauses_;  ///< by connection
  std::vector<std::vector<ConnectionIndex>> waiting_;          ///< by connection: who names it
};

/// The cycle in words: of removals, or, where an assembly is planned, of what is made.
Violation cycle_of(const Problem& problem, const Peeling::Chain& chain, Peeling::Kind kind) {
  Violation violation;
  violation.constraint =
      kind == Peeling::Kind::Making ? Constraint::PrecedenceMadeAny : Constraint::Precedence;
  const bool assembly = problem.direction() == Direction::Assembly;
  std::string text;
  for (std::size_t i = chain.cycle_from; i < chain.links.size(); ++i) {
    const auto& [connection, entry] = chain.links[i];
    const ConnectionIndex next =
        i + 1 < chain.links.size() ? chain.links[i + 1].first : chain.ends_at;
    violation.blocking_connections.push_back(connection);
    // What is removed after another is made before it.
    const bool turned = (kind == Peeling::Kind::Making) != assembly;
    const std::string first = detail::in_quotes(problem.connection_id(turned ? next : connection));
    const std::string other = detail::in_quotes(problem.connection_id(turned ? connection : next));
    text += (text.empty() ? "" : ", ") + first + (assembly ? " made after " : " after ") + other +
            " (precedence[" + std::to_string(entry) + "])";
  }
  violation.where = "precedence[" + std::to_string(chain.links[chain.cycle_from].second) + "]";
  violation.message = "precedence is a cycle: " + text;
  std::ranges::sort(violation.blocking_connections);
  return violation;
}

}  // namespace

// The first subassembly without a base part, if there is one.
std::optional<Violation> TransitionSystem::ungrounded(SetView present) const {
  std::optional<Violation> found;
  rules_->graph.for_each_piece(present, [&](std::span<const PartIndex> piece) {
    const auto is_base = [this](PartIndex part) { return problem_.in_base(part); };
    if (found || piece.size() < 2 || std::ranges::any_of(piece, is_base)) return;
    found = {Constraint::Grounded,
             "limits.grounded",
             std::string(rules_->whole ? "the whole product has" : "the product as it stands has") +
                 " a subassembly without a base part, with " +
                 detail::in_quotes(problem_.part_id(piece.front())) + "; each must hold one",
             {}};
  });
  return found;
}

// Two parts are in one piece until one step moves one of them off the other. A step on one
// connection cuts a piece in two, so any two parts of a piece that come apart count; a step that
// takes a part off may leave the rest in several pieces that nothing moved, so there only parts
// that a connection joins do. Pieces that both hold base parts come apart without a motion, and so
// do those that a failed attempt breaks.
std::optional<std::array<PartIndex, 2>> TransitionSystem::locked_pair() const {
  const Rules& rules = *rules_;
  if (!rules.blocking || rules.has_goal || problem_.uncertain() || problem_.spec().base.size() > 1)
    return std::nullopt;
  const auto bits = problem_.direction_bits();
  std::vector<std::uint64_t> free;
  // Directions come with their opposites, so what holds one of two parts holds the other.
  std::vector<std::array<PartIndex, 2>> pairs;
  for (PartIndex part = 0; part < problem_.num_parts(); ++part) {
    for (const Blocker& blocker : problem_.blockers()[part]) {
      if (blocker.by < part) continue;
      free.assign(bits.begin(), bits.end());
      if (!problem_.take_out(blocker, free)) pairs.push_back({part, blocker.by});
    }
  }
  if (pairs.empty()) return std::nullopt;

  const auto [first, last] = both_ends();
  if (rules.by_part) {
    std::optional<std::array<PartIndex, 2>> joined;
    for (ConnectionIndex c = 0; c < num_connections(); ++c) {
      if (!first.contains(c) || last.contains(c)) continue;
      auto ends = problem_.ends(c);
      std::ranges::sort(ends);
      // Pairs ascend, as they were found.
      if ((!joined || ends < *joined) && std::ranges::binary_search(pairs, ends)) joined = ends;
    }
    return joined;
  }
  const auto pieces_of = [&](const ConnectionSet& there) {
    std::vector<PartIndex> piece_of(problem_.num_parts());
    rules.graph.for_each_piece(there.view(), [&](std::span<const PartIndex> piece) {
      for (const PartIndex part : piece) piece_of[part] = piece.front();
    });
    return piece_of;
  };
  const std::vector<PartIndex> before = pieces_of(first);
  const std::vector<PartIndex> after = pieces_of(last);
  const auto parted = std::ranges::find_if(pairs, [&](const std::array<PartIndex, 2>& pair) {
    return before[pair[0]] == before[pair[1]] && after[pair[0]] != after[pair[1]];
  });
  return parted == pairs.end() ? std::nullopt : std::optional{*parted};
}

// In disassembly order: the state at which it begins (in assembly, the one that is the goal), and
// what it ends with.
std::array<ConnectionSet, 2> TransitionSystem::both_ends() const {
  const ConnectionSet none(num_connections());
  return {present(rules_->making ? none.view() : start().view()),
          present(rules_->making ? start().view() : none.view())};
}

Violation TransitionSystem::locked(const std::array<PartIndex, 2>& pair) const {
  const auto& [a, b] = pair;
  return {Constraint::Blocking,
          "blocking",
          "parts " + detail::in_quotes(problem_.part_id(a)) + " and " +
              detail::in_quotes(problem_.part_id(b)) +
              " block each other in every direction of blocking.directions, so that no straight "
              "motion parts them",
          {}};
}

std::optional<Violation> TransitionSystem::infeasibility() const {
  const Rules& rules = *rules_;
  const auto [first, last] = both_ends();
  const std::size_t start_pieces = subassemblies(first.view());
  if (num_steps() > 0 && start_pieces > rules.max_subassemblies) {
    return Violation{Constraint::MaxSubassemblies,
                     "limits.max_subassemblies",
                     (rules.whole ? "the whole product is " : "the product as it stands is ") +
                         std::to_string(start_pieces) + " subassemblies; at most " +
                         std::to_string(rules.max_subassemblies) + " are allowed",
                     {}};
  }
  if (rules.grounded && num_steps() > 0) {
    if (auto found = ungrounded(first.view())) return found;
    // The state from which an assembly begins.
    if (rules.assembly) {
      if (auto found = ungrounded(last.view())) return found;
    }
  }
  if (rules.has_goal) {
    for (const ConnectionIndex c : problem_.goal()) {
      if (situation_.open.contains(c) && situation_.inaccessible.contains(c))
        return Violation{Constraint::Inaccessible,
                         "goal",
                         detail::in_quotes(problem_.connection_id(c)) +
                             " is inaccessible, and the goal asks that it is removed",
                         {}};
    }
  }
  if (const auto pair = locked_pair()) return locked(*pair);
  // Several connections may go in one step, each at the same time as what it waits for.
  if (rules.by_part) return std::nullopt;
  if (rules.has_goal) {
    Peeling peeling(Peeling::Kind::Removing, problem_, first, last);
    peeling.remove();
    for (const ConnectionIndex c : problem_.goal()) {
      if (!peeling.is_left(c)) continue;
      const Peeling::Chain chain = peeling.chain(c);
      if (chain.is_cycle) return cycle_of(problem_, chain, Peeling::Kind::Removing);
      return waits_in_vain(chain.links.back().first, chain.ends_at, chain.links.back().second,
                           false);
    }
    return std::nullopt;
  }
  const auto reason = [&](Peeling::Kind kind) -> std::optional<Violation> {
    Peeling peeling(kind, problem_, first, last);
    if (peeling.remove() == num_steps()) return std::nullopt;
    const Peeling::Chain chain = peeling.chain();
    if (chain.is_cycle) return cycle_of(problem_, chain, kind);
    return waits_in_vain(chain.links.back().first, chain.ends_at, chain.links.back().second,
                         kind == Peeling::Kind::Making);
  };
  if (auto found = reason(Peeling::Kind::Removing)) return found;
  if (rules.made_any.empty() || num_steps() == 0) return std::nullopt;
  if (auto found = reason(Peeling::Kind::Making)) return found;
  if (rules.assembly) return std::nullopt;
  // What stays in a disassembly goes on to need one of its list.
  for (const PrecedenceClause& clause : problem_.precedence()) {
    const bool stays = last.contains(clause.connection) && !clause.made_after_any.empty();
    if (stays && std::ranges::none_of(clause.made_after_any, [&](ConnectionIndex other) {
          return other != clause.connection && last.contains(other);
        }))
      return waits_in_vain(clause.connection, clause.made_after_any.front(), clause.entry, true);
  }
  return std::nullopt;
}

}  // namespace orasp
