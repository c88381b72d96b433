#pragma once

#include <string>
#include <utility>
#include <vector>

#include "orasp/model/problem.h"

/// Tiny assemblies with a drawing and what is known of them, worked out by hand. Objective
/// `cubesat` (a single part carried costs 0.0967, two 0.1248, three 0.1368, more nothing; the last
/// step earns 1), disassembly.
namespace orasp::instances {

/// Parts "1" to "N" and connections "i-j" of the pairs given.
[[nodiscard]] inline ProblemSpec assembly(std::size_t parts,
                                          const std::vector<std::pair<int, int>>& pairs) {
  ProblemSpec spec;
  for (std::size_t p = 1; p <= parts; ++p) {
    Part part;
    part.id = std::to_string(p);
    spec.parts.push_back(part);
  }
  for (const auto& [first, second] : pairs) {
    Connection connection;
    connection.parts = {std::to_string(first), std::to_string(second)};
    spec.connections.push_back(connection);
  }
  return spec;
}

///   (nothing)            the empty plan, reward 0
[[nodiscard]] inline ProblemSpec nothing() {
  return assembly(0, {});
}

///   1                    the empty plan, reward 0
[[nodiscard]] inline ProblemSpec one_part() {
  return assembly(1, {});
}

///   1 - 2                one step, which completes: 1
[[nodiscard]] inline ProblemSpec one_connection() {
  return assembly(2, {{1, 2}});
}

///   1 )                  a part joined to itself: one step that separates nothing and completes: 1
[[nodiscard]] inline ProblemSpec self_connection() {
  return assembly(1, {{1, 1}});
}

///   1 - 2 - 3 either end first: -(0.0967 + 0.1248) + 1 = 0.7785, the only reward there is
[[nodiscard]] inline ProblemSpec chain_of_three() {
  return assembly(3, {{1, 2}, {2, 3}});
}

///   1 - 2   3 - 4        two products: -(0.0967 + 0.0967) + 1 = 0.8066
[[nodiscard]] inline ProblemSpec two_pieces() {
  return assembly(4, {{1, 2}, {3, 4}});
}

///   1 - 2 - 3 - 4
///
/// Greedy must fail here. In the middle first: -(0.1248 + 0.1248) - (0.0967 + 0.0967) + 1 = 0.5570,
/// the optimum. At an end first: -(0.0967 + 0.1368) - (0.0967 + 0.1248) + 1 = 0.5450; but its first
/// step costs 0.2335 and not 0.2496, so greedy takes it.
[[nodiscard]] inline ProblemSpec greedy_trap() {
  return assembly(4, {{1, 2}, {2, 3}, {3, 4}});
}

///   1 - 2 1-2 after 2-3, 2-3 after 1-3, 1-3 after 1-2: a cycle of precedence, so no plan.
///    \ /
///     3
[[nodiscard]] inline ProblemSpec locked_ring() {
  ProblemSpec spec = assembly(3, {{1, 2}, {2, 3}, {1, 3}});
  spec.precedence = {{"1-2", {"2-3"}, {}}, {"2-3", {"1-3"}, {}}, {"1-3", {"1-2"}, {}}};
  return spec;
}

///   [1 > 2 < 1] 2 lies in a slot of 1, closed on both sides; no direction is free, so no plan.
[[nodiscard]] inline ProblemSpec boxed_in() {
  ProblemSpec spec = assembly(2, {{1, 2}});
  spec.blocking = Blocking{{"+x", "-x"}, {{"2", "1", {"+x", "-x"}}}};
  return spec;
}

///   3 | 1 | 2 All three touch; 1 is between 3 (on its -x side) and 2 (on its +x side), so 1 cannot
///   leave the
///                        two others while they hang together. 2-3 may go only after 1-2.
/// The only plan is 1-2, 2-3, 1-3: 0 - (0.0967 + 0.1248) + 1 = 0.7785. To begin with 1-3 is a dead
/// end: then 1-2 would pull 1 out of the middle and 2-3 waits for 1-2. H has 5 states and 4
/// actions: {1-3, 1-2, 2-3}, {1-2, 2-3} (dead), {1-3, 2-3}, {1-3}, {}. 1-3 is listed first, so that
/// whoever breaks ties by position walks into the dead end.
[[nodiscard]] inline ProblemSpec sandwich() {
  ProblemSpec spec = assembly(3, {{1, 3}, {1, 2}, {2, 3}});
  spec.precedence = {{"2-3", {"1-2"}, {}}};
  spec.blocking = Blocking{{"+x", "-x"}, {{"1", "2", {"+x"}}, {"1", "3", {"-x"}}}};
  return spec;
}

/// Twelve connections of part 1 to itself, free to go in any order, and 1-2 and 2-3, which never
/// can, since each part is held by the other two: 4,096 states, none of which leads anywhere, and
/// 12! = 479,001,600 ways to find that out. No two of the parts lock each other.
[[nodiscard]] inline ProblemSpec hopeless() {
  ProblemSpec spec = assembly(3, {{1, 2}, {2, 3}});
  spec.blocking =
      Blocking{{"+x", "-x"}, {{"2", "1", {"+x"}}, {"2", "3", {"-x"}}, {"1", "3", {"+x"}}}};
  for (int i = 0; i < 12; ++i) {
    Connection connection;
    connection.id = "loop" + std::to_string(i);
    connection.parts = {"1", "1"};
    spec.connections.push_back(connection);
  }
  return spec;
}

}  // namespace orasp::instances
