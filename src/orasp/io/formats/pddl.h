#pragma once

#include "orasp/io/formats/conversion.h"

namespace orasp {

/// PDDL for classical planners (McDermott and others (1998), PDDL, the planning domain definition
/// language): a domain with one action for each connection, which removes it or, in assembly, makes
/// it, and a problem that wants all of them done, or the goal. The plans of the two together are
/// the legal orders of the problem: precedence becomes preconditions. What a step earns is left
/// out, so a planner finds a legal plan, not the best one.
/// Actions and constants are called after the connections where their ids are names of PDDL, else
/// c1, c2, ... by their place; a comment has the id.
/// @throws InputError where steps are judged by what moves (limits, blocking, steps that take parts
/// off), for several robots, and where failures change the state.
[[nodiscard]] Written write_pddl_domain(const WriteRequest& request);
[[nodiscard]] Written write_pddl_problem(const WriteRequest& request);

}  // namespace orasp
