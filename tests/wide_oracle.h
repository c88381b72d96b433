#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "orasp/model/problem.h"
#include "tests/oracle.h"

/// Brute force for problems that use all there is: a base, grounded pieces, goals, numbers and
/// attributes, costs between consecutive steps, steps that take parts off, precedence stated either
/// way, in both directions. Written from the sentences of the contract and as slowly as they read.
/// It takes a ProblemSpec and nothing else of the library; objectives of the type "callable" and
/// attempts that may fail are not its business. For up to 9 connections or so, and at most 64.
///
/// How it reads what could be read in two ways:
/// * In assembly a step is legal where its reverse is, and where precedence, limits and `grounded`
///   hold; it may lead into a dead end, and then the best reward to go is minus infinity there.
/// * In a part step, what precedence asks to be removed before may go in the same step. As long as
///   a connection is there after the step, one of its `made_after_any` other than itself must be.
/// * The attribute of a part step is the one value among those of its connections that state one;
///   where they state several, the step has none.
/// * A connection of a part to itself is never between M and the rest: part steps leave it alone.
/// * With `grounded`, M is a single part (it holds no base part, and so can be no subassembly), and
///   each piece of the rest, a single part too, holds a base part.
namespace orasp::oracle {

struct WideStep {
  std::vector<std::size_t> connections{};  ///< by position in the file, ascending
  /// How the moved piece leaves; empty where nothing moves or the problem has no blocking.
  std::string direction{};

  friend bool operator==(const WideStep&, const WideStep&) = default;
};

/// What the steps before left behind, as far as the objective looks back.
struct WideContext {
  std::map<std::string, std::string> in_force{};  ///< the last value of each attribute, if any
  std::optional<Vector3> place{};                 ///< of the last step

  friend bool operator<(const WideContext& x, const WideContext& y) {
    return x.in_force != y.in_force ? x.in_force < y.in_force : x.place < y.place;
  }
  friend bool operator==(const WideContext&, const WideContext&) = default;
};

struct WideResult {
  std::optional<double> best{};  ///< greatest reward of a plan; nothing if there is none
  /// Legal plans; two that differ in directions alone are one. At most 2^64 - 1 are counted. With a
  /// goal that may be stopped at anywhere, each place to stop is a plan.
  std::uint64_t plans = 0;
  /// Of each state that legal steps reach, dead ends among them: -infinity where no plan goes on.
  std::map<std::pair<State, WideContext>, double> best_to_go{};
  std::vector<WideStep> best_plan{};
};

[[nodiscard]] WideResult wide_brute_force(const ProblemSpec& spec);

/// As WideResult::best_plan; empty if there is no plan.
[[nodiscard]] std::vector<WideStep> wide_best_plan(const ProblemSpec& spec);

/// The reward of a plan, in the order of the problem's direction; nothing if it breaks a rule, ends
/// where it must not or goes on where it must end. A step that moves something may leave its
/// direction out, if the objective does not look at directions and some direction is free.
[[nodiscard]] std::optional<double> wide_reward_of(const ProblemSpec& spec,
                                                   const std::vector<WideStep>& plan);

/// A legal step and what it does.
struct WideChoice {
  std::vector<std::size_t> connections{};
  std::vector<std::string> free_directions{};  ///< of the moved piece; empty where nothing moves
  bool separates = false;
  bool completes = false;
  Parts moved{};
};
/// The legal steps in a state, one for each set of connections; none where a plan must end.
[[nodiscard]] std::vector<WideChoice> wide_choices(const ProblemSpec& spec, const State& open);

}  // namespace orasp::oracle
