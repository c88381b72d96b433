#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "orasp/model/problem.h"
#include "orasp/model/transition_system.h"

/// The contract of docs/format.md once more, written straight from its sentences and as slowly as
/// it reads: the other side of every comparison in the tests. It takes a problem's data and nothing
/// else of the library: connectivity, legality, moved piece, masses and rewards are worked out here
/// from the ids and numbers of the ProblemSpec.
namespace orasp::oracle {

/// The open connections, by position in the file: those still to be handled, in either direction.
using State = std::vector<bool>;
using Parts = std::set<std::size_t>;

[[nodiscard]] inline State state_of(SetView open, std::size_t connections) {
  State state(connections);
  for (std::size_t c = 0; c < connections; ++c) state[c] = (open[c / 64] >> (c % 64) & 1U) != 0;
  return state;
}
[[nodiscard]] inline ConnectionSet set_of(const State& open) {
  ConnectionSet set(open.size());
  for (std::size_t c = 0; c < open.size(); ++c) {
    if (open[c]) set.insert(static_cast<ConnectionIndex>(c));
  }
  return set;
}

enum class Rule {
  Precedence,
  PrecedenceAny,
  PrecedenceMadeAny,
  MaxSubassemblies,
  MaxMovedParts,
  MaxMovedMass,
  Blocking
};

/// Everything about handling one connection, legal or not.
struct Facts {
  std::size_t connection = 0;
  std::size_t before = 0;
  std::size_t after = 0;
  bool separates = false;
  bool completes = false;
  Parts
      /// The piece of the connection's first part; empty unless it separates, as all that follows.
      a;
  Parts b;
  Parts moved;
  double moved_mass = 0;
  double kept_mass = 0;
  std::size_t subassemblies = 0;  ///< after the step, whether it separates or not
  double reward = 0;
  std::set<std::string> free_directions;  ///< in which the moved piece can leave
  std::set<Rule> broken;                  ///< the constraints that forbid it
  /// Those of them that earlier steps have broken already, and this step does not: it is too late.
  std::set<Rule> too_late;

  [[nodiscard]] bool legal() const { return broken.empty(); }
};

class World {
 public:
  explicit World(const ProblemSpec& spec);

  [[nodiscard]] std::size_t num_connections() const { return ends_.size(); }
  [[nodiscard]] State start() const { return State(num_connections(), true); }
  /// Connections that are open and never handled: in assembly they are never there.
  void give_up(const State& connections) { given_up_ = connections; }
  /// The rules of precedence that are broken where the work stands, whatever is done from there.
  [[nodiscard]] std::set<Rule> broken_at_start(const State& open) const;
  /// The whole product already has more subassemblies than allowed.
  [[nodiscard]] bool start_infeasible() const;
  /// `kept`: how many of the open connections are never handled.
  [[nodiscard]] Facts facts(const State& open, std::size_t connection, std::size_t kept = 0) const;
  /// Pieces of two or more parts that the connections of `present` hold together.
  [[nodiscard]] std::size_t subassemblies(const State& present) const;
  /// The legal ones among facts(open, c) for all open c, ascending.
  [[nodiscard]] std::vector<Facts> legal_facts(const State& open) const;

 private:
  struct Clause {
    std::size_t connection;
    std::set<std::size_t> after;
    std::set<std::size_t> after_any;
    std::set<std::size_t> made_after_any;
  };
  using Block = std::pair<std::size_t, std::size_t>;  ///< part, blocked by part

  [[nodiscard]] Parts piece_of(std::size_t part, const State& present) const;
  [[nodiscard]] double mass_of(const Parts& piece) const;
  [[nodiscard]] bool first_moves(const Parts& a, const Parts& b) const;
  void judge_removal(const State& present, Facts& facts) const;
  void judge_making(const State& open, Facts& facts) const;
  void judge_precedence(const State& open, Facts& facts) const;
  /// Of `present`, what could have been put on in some order, as made_after_any asks.
  [[nodiscard]] State can_be_put_on(const State& present) const;
  /// What is taken off the product with all connections but `never`, or never there, when of
  /// `missing` everything goes that may go, as after and after_any ask.
  [[nodiscard]] State can_be_taken_off(const State& missing, const State& never) const;
  void judge_cut(const State& smaller, Facts& facts) const;
  [[nodiscard]] double reward(const Objective& objective, const Facts& facts) const;
  [[nodiscard]] double distance(const Parts& piece, const Vector3& depot) const;
  [[nodiscard]] bool positions_known(const Parts& piece) const;

  ProblemSpec spec_;
  std::vector<std::pair<std::size_t, std::size_t>> ends_;
  std::vector<std::vector<std::size_t>> touching_;  ///< connections of each part
  std::vector<Clause> clauses_;
  State given_up_;
  std::map<std::string, std::set<Block>> blocks_;  ///< by direction, closed under antisymmetry
};

/// What is true of a problem's H and H~, by visiting every state.
struct OracleResult {
  bool feasible = false;
  double best = -std::numeric_limits<double>::infinity();  ///< greatest reward of a plan
  double worst = std::numeric_limits<double>::infinity();  ///< least reward of a plan
  std::uint64_t states = 0;
  std::uint64_t actions = 0;
  std::uint64_t dead_ends = 0;
  std::uint64_t tree_nodes = 0;
  std::uint64_t sequences = 0;
  std::vector<std::pair<std::uint64_t, std::uint64_t>>
      layers;                          ///< states and actions by connections handled
  std::map<State, double> best_to_go;  ///< -infinity where the goal cannot be reached
  std::map<State, double> best_from_start;
};

[[nodiscard]] OracleResult brute_force(const ProblemSpec& spec);

/// The same figures (no maps, layers, states or actions) from the tree of all sequences, nothing
/// remembered: checks brute_force itself. For at most 6 connections or so.
[[nodiscard]] OracleResult enumerate(const ProblemSpec& spec);

struct OracleReplay {
  bool valid = false;
  double reward = 0;
  std::vector<Facts>
      steps;  ///< up to the first one that cannot be made at all (out of range, or handled before)
};

[[nodiscard]] OracleReplay replay(const ProblemSpec& spec,
                                  const std::vector<ConnectionIndex>& sequence);

/// Value of a formula made of + - * / ( ), numbers and the names given.
[[nodiscard]] double formula_value(const std::string& text,
                                   const std::map<std::string, double>& names);

}  // namespace orasp::oracle
