#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "orasp/model/connection_set.h"
#include "orasp/model/error.h"
#include "orasp/model/objective.h"

namespace orasp {

/// The largest problem that loads. Beyond it a plan's own text runs to hundreds of megabytes.
inline constexpr std::size_t kMaxConnections = 16'384;
inline constexpr std::size_t kMaxParts = 16'384;

/// A node of the assembly graph.
struct Part {
  std::string id{};
  std::string name{};
  double mass = 1;                    ///< kg, 0 or more
  std::optional<Vector3> position{};  ///< m
};

/// What an attempt that fails does beyond costing its reward. Nothing stated: nothing, it is tried
/// again.
struct OnFailure {
  std::vector<std::string> breaks{};  ///< ids of connections that come off too; disassembly alone
  std::optional<double> abort{};      ///< the job ends, and the attempt earns this instead

  [[nodiscard]] bool retries() const { return breaks.empty() && !abort; }
};

/// An edge of the assembly graph, as a problem file states it.
struct Connection {
  std::string id{};  ///< empty: the two part ids joined by '-'
  std::array<std::string, 2> parts{};
  double duration = 1;  ///< s, 0 or more
  double success = 1;   ///< probability that one attempt succeeds, above 0 and at most 1
  /// Fleet problems: how the first part moves off the second, "+x" ... "-z"; else empty.
  std::string axis{};
  OnFailure on_failure{};  ///< of an attempt, where success is below 1
};

/// What must come before what, stated by the way the product is taken apart, by the way it is put
/// together, or both. `connection` may be removed only after all of `after`, and at least one of
/// `after_any` (if any are listed). It may be made only after all of `made_after`, and at least one
/// of `made_after_any`: so each of `made_after` is removed only after it, and as long as it is
/// there at least one of `made_after_any` is.
struct Precedence {
  std::string connection{};
  std::vector<std::string> after{};
  std::vector<std::string> after_any{};
  std::vector<std::string> made_after{};
  std::vector<std::string> made_after_any{};
};

/// While both are present, `part` cannot leave `by` along any of `directions`.
struct Blocked {
  std::string part{};
  std::string by{};
  std::vector<std::string> directions{};
};

struct Blocking {
  std::vector<std::string> directions{};  ///< opposite pairs out of +x -x +y -y +z -z
  std::vector<Blocked> blocked{};
};

struct Limits {
  std::optional<std::size_t> max_subassemblies{};
  std::optional<std::size_t> max_moved_parts{};
  std::optional<double> max_moved_mass{};  ///< kg
};

/// Robots, depot and sites of a fleet problem (fleet/fleet.h). Kept, written and digested with the
/// problem; the planners for one robot do not use it.
struct Fleet {
  std::size_t robots = 1;
  std::array<double, 2> depot{};
  std::vector<std::array<double, 2>> sites{};
};

enum class Direction { Disassembly, Assembly };

/// What a problem file says, not yet checked. Ids are the file's own.
struct ProblemSpec {
  std::string name{};
  std::string note{};
  std::string source{};
  std::vector<Part> parts{};
  std::vector<Connection> connections{};
  std::vector<Precedence> precedence{};
  std::optional<Blocking> blocking{};
  Limits limits{};
  Objective objective = Objective::named("cubesat");
  Direction direction = Direction::Disassembly;
  std::optional<Fleet> fleet{};
};

/// Six directions as bits; opposite directions are neighbours: 0 +x, 1 -x, 2 +y, 3 -y, 4 +z, 5 -z.
using DirectionMask = unsigned char;
inline constexpr std::array<const char*, 6> kDirectionNames = {"+x", "-x", "+y", "-y", "+z", "-z"};
[[nodiscard]] constexpr std::size_t opposite(std::size_t direction) {
  return direction ^ 1U;
}

/// One clause of precedence over indices: see Precedence. `entry` is its position in
/// ProblemSpec::precedence. That "b" is made after "a" is the clause that "a" is removed after "b",
/// so an entry with `made_after` becomes several clauses.
struct PrecedenceClause {
  std::size_t entry{};
  ConnectionIndex connection{};
  std::vector<ConnectionIndex> after{};
  std::vector<ConnectionIndex> after_any{};
  std::vector<ConnectionIndex> made_after_any{};
};

/// A blocker of a part: `by` stands in the way of `part` along `directions` (closed under
/// antisymmetry).
struct Blocker {
  PartIndex by{};
  DirectionMask directions{};
};

/// An assembly problem. Immutable; the constructor checks everything, so whoever holds one may
/// trust it. Owns all its data; copying copies it (planners hold a reference; the problem must
/// outlive them).
///
///     ProblemSpec spec;
///     spec.parts = {{.id = "1"}, {.id = "2"}};
///     spec.connections = {{.parts = {"1", "2"}}};
///     const Problem problem(std::move(spec));       // throws InputError at the first fault
///     use(problem.connection_id(0));                // "1-2"
class Problem {
 public:
  /// @throws InputError with one sentence for the first fault, its place written as in a problem
  ///         file: connections[3].parts[1]: no part "17"; parts are "1" to "9"
  explicit Problem(ProblemSpec spec);

  [[nodiscard]] const ProblemSpec& spec() const { return spec_; }
  [[nodiscard]] const std::string& name() const { return spec_.name; }
  [[nodiscard]] std::size_t num_parts() const { return spec_.parts.size(); }
  [[nodiscard]] std::size_t num_connections() const { return spec_.connections.size(); }
  [[nodiscard]] const std::vector<Part>& parts() const { return spec_.parts; }
  [[nodiscard]] const std::vector<Connection>& connections() const { return spec_.connections; }
  [[nodiscard]] const Limits& limits() const { return spec_.limits; }
  [[nodiscard]] const Objective& objective() const { return spec_.objective; }
  [[nodiscard]] Direction direction() const { return spec_.direction; }

  [[nodiscard]] const std::string& part_id(PartIndex part) const { return spec_.parts[part].id; }
  [[nodiscard]] const std::string& connection_id(ConnectionIndex c) const {
    return spec_.connections[c].id;
  }
  /// The two parts that connection `c` joins (equal for a connection of a part to itself).
  [[nodiscard]] const std::array<PartIndex, 2>& ends(ConnectionIndex c) const { return ends_[c]; }
  /// The connections that come off when an attempt at `c` fails, ascending; often none.
  [[nodiscard]] const std::vector<ConnectionIndex>& breaks(ConnectionIndex c) const {
    return breaks_[c];
  }
  /// The first connection at which an attempt may fail (success below 1); empty if there is none.
  [[nodiscard]] std::optional<ConnectionIndex> first_uncertain() const;
  [[nodiscard]] bool uncertain() const { return first_uncertain().has_value(); }
  /// @throws InputError `no connection "x"; connections are ...`, with `place` in front.
  [[nodiscard]] ConnectionIndex find_connection(const std::string& id,
                                                const std::string& place) const;
  [[nodiscard]] PartIndex find_part(const std::string& id, const std::string& place) const;

  /// Ascending by entry.
  [[nodiscard]] const std::vector<PrecedenceClause>& precedence() const { return precedence_; }
  /// Blockers of each part, by ascending `by`; empty vectors where nothing blocks.
  [[nodiscard]] const std::vector<std::vector<Blocker>>& blockers() const { return blockers_; }
  /// The directions that blocking considers; 0 where the problem has no blocking.
  [[nodiscard]] DirectionMask directions() const { return directions_; }

  /// Things worth telling the user though nothing is wrong: a connection of a part to itself.
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

  /// The same problem under another objective, direction or limits. @throws InputError as the
  /// constructor.
  [[nodiscard]] Problem with_objective(Objective objective) const;
  [[nodiscard]] Problem with_direction(Direction direction) const;
  [[nodiscard]] Problem with_limits(Limits limits) const;

 private:
  void index_parts();
  void index_connections();
  void index_breaks();
  void index_precedence();
  void index_blocking();
  void check_limits() const;
  void check_fleet() const;

  ProblemSpec spec_;
  std::unordered_map<std::string, PartIndex> part_by_id_;
  std::unordered_map<std::string, ConnectionIndex> connection_by_id_;
  std::vector<std::array<PartIndex, 2>> ends_;
  std::vector<std::vector<ConnectionIndex>> breaks_;
  std::vector<PrecedenceClause> precedence_;
  std::vector<std::vector<Blocker>> blockers_;
  DirectionMask directions_ = 0;
  std::vector<std::string> warnings_;
};

}  // namespace orasp
