#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "orasp/model/connection_set.h"
#include "orasp/model/error.h"
#include "orasp/model/objective.h"

namespace orasp {

/// The largest problem that loads. Beyond it a plan's own text runs to hundreds of megabytes.
inline constexpr std::size_t kMaxConnections = 16'384;
inline constexpr std::size_t kMaxParts = 16'384;
/// Pairs of opposite directions that blocking may consider.
inline constexpr std::size_t kMaxDirectionPairs = 4'096;

/// A node of the assembly graph.
struct Part {
  std::string id{};
  std::string name{};
  double mass = 1;                    ///< kg, 0 or more
  std::optional<Vector3> position{};  ///< m
  /// The user's own, by name: formulas see their sums over the moved and over the kept piece.
  std::map<std::string, double> numbers{};
  /// What it is one of: parts with the same product are counted as "3 x M5 nut" where people read
  /// of them. No rule, reward or symmetry looks at it. Empty: it stands for itself.
  std::string product{};
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
  /// The user's own, by name, for formulas; 0 where a connection states none.
  std::map<std::string, double> numbers{};
  /// The user's own, by name: the tool, say. Objectives that look back compare them.
  std::map<std::string, std::string> attributes{};
  /// Where the work is done, in metres; nothing stated: in the middle between its two parts.
  std::optional<Vector3> position{};
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
  /// m; for each of `directions` how wide the region is in which they would meet; empty where that
  /// is not known. An import writes it as `x-width`. No rule looks at it, explanations do.
  std::vector<double> widths{};
};

/// A way in which a piece may leave: one of the axes +x -x +y -y +z -z, which has no vector, or a
/// direction with an id of its own, which has one. The opposite of "slant" is there with it, and is
/// named "-slant"; that of an axis is listed like the axis.
struct BlockingDirection {
  std::string id{};
  std::optional<Vector3> vector{};  ///< of any length but 0

  BlockingDirection() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): the name of an axis becomes one unasked.
  BlockingDirection(std::string axis) : id(std::move(axis)) {}
  // NOLINTNEXTLINE(google-explicit-constructor): the same.
  BlockingDirection(const char* axis) : id(axis) {}
  BlockingDirection(std::string name, const Vector3& along) : id(std::move(name)), vector(along) {}
};

struct Blocking {
  std::vector<BlockingDirection> directions{};
  std::vector<Blocked> blocked{};
  /// m; what the import that found the facts took for contact (`x-tolerance`); 0 where there was
  /// none.
  double tolerance = 0;

  /// Whether a fact so wide might be none, since it is little wider than an import can tell.
  [[nodiscard]] bool is_near_tolerance(double width) const {
    constexpr double kNearlyWide = 4;  // facts are wider than twice the tolerance
    return width < kNearlyWide * tolerance;
  }
};

struct Limits {
  std::optional<std::size_t> max_subassemblies{};
  std::optional<std::size_t> max_moved_parts{};
  std::optional<double> max_moved_mass{};  ///< kg
  /// At the start and after every step each subassembly holds a base part.
  bool grounded = false;

  /// Whether anything is limited.
  [[nodiscard]] bool any() const {
    return max_subassemblies || max_moved_parts || max_moved_mass || grounded;
  }
};

/// What is wanted of a disassembly, instead of everything: `removed` connections are gone and
/// `free` parts have no connection left.
struct Goal {
  enum class Stop {
    Reached,  ///< the plan ends at the first state in which the goal holds
    Best,     ///< it may end wherever the goal holds, and ends where that earns most
  };
  std::vector<std::string> free{};     ///< ids of parts
  std::vector<std::string> removed{};  ///< ids of connections
  Stop stop = Stop::Reached;
};

/// What one step takes.
enum class StepKind {
  Connection,  ///< one connection
  Part,        ///< a part, or several that hang together, with all connections to the rest
};

/// Robots, depot and sites of a fleet problem (fleet/fleet.h). Kept, written and digested with the
/// problem; the planners for one robot do not use it.
struct Fleet {
  std::size_t robots = 1;
  std::array<double, 2> depot{};
  std::vector<std::array<double, 2>> sites{};
};

/// Where the shapes of the parts are. Planning does not look at them; pictures do.
struct Geometry {
  /// A binary glTF file (.glb), beside the problem file unless the path says otherwise: a node for
  /// each part, named by its id, in metres.
  std::string file{};
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
  std::vector<std::string> base{};  ///< ids of the parts that are fixed
  std::optional<Goal> goal{};
  StepKind action = StepKind::Connection;
  Objective objective = Objective::named("cubesat");
  Direction direction = Direction::Disassembly;
  std::optional<Fleet> fleet{};
  std::optional<Geometry> geometry{};
};

/// The number of a direction. Opposite directions are neighbours: 0 +x, 1 -x, 2 +y, 3 -y, 4 +z, 5
/// -z; from 6 on the named ones, by name, each followed by its opposite.
using DirectionIndex = Index<struct DirectionKind, std::uint16_t>;
inline constexpr std::array<const char*, 6> kDirectionNames = {"+x", "-x", "+y", "-y", "+z", "-z"};
[[nodiscard]] constexpr std::size_t opposite(std::size_t direction) {
  return direction ^ 1U;
}
[[nodiscard]] constexpr DirectionIndex opposite(DirectionIndex direction) {
  return static_cast<DirectionIndex>(direction.value() ^ 1U);
}
/// A set of directions, a bit for each number, where numbers are below 32.
using DirectionMask = std::uint32_t;

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
/// antisymmetry). These are a mask where Problem::has_direction_masks(), else the number of a set
/// that the problem holds; Problem::blocks() and Problem::take_out() read both.
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
  /// The parts that are fixed, by part; empty where there are none.
  [[nodiscard]] const std::vector<bool>& base() const { return base_; }
  [[nodiscard]] bool in_base(PartIndex part) const { return !base_.empty() && base_[part]; }
  /// The connections that the goal asks to be gone, ascending: those listed, and those of the parts
  /// that are to be free. Empty also where there is no goal.
  [[nodiscard]] const std::vector<ConnectionIndex>& goal() const { return goal_; }
  /// Where the work on a connection is done; nothing where that is not known.
  [[nodiscard]] std::optional<Vector3> place(ConnectionIndex c) const;
  /// The first connection at which an attempt may fail (success below 1); empty if there is none.
  [[nodiscard]] std::optional<ConnectionIndex> first_uncertain() const;
  [[nodiscard]] bool uncertain() const { return first_uncertain().has_value(); }
  /// Whether some attempt may fail, and no failure does more than cost what an attempt costs.
  [[nodiscard]] bool only_retries() const;
  /// @throws InputError `no connection "x"; connections are ...`, with `place` in front.
  [[nodiscard]] ConnectionIndex find_connection(const std::string& id,
                                                const std::string& place) const;
  [[nodiscard]] PartIndex find_part(const std::string& id, const std::string& place) const;

  /// Ascending by entry.
  [[nodiscard]] const std::vector<PrecedenceClause>& precedence() const { return precedence_; }
  /// Blockers of each part, by ascending `by`; empty vectors where nothing blocks.
  [[nodiscard]] const std::vector<std::vector<Blocker>>& blockers() const { return blockers_; }
  /// The directions that blocking considers, in the order of the file, each named one followed by
  /// its opposite; empty where the problem has no blocking.
  [[nodiscard]] const std::vector<DirectionIndex>& directions() const { return directions_; }
  /// "+x", "slant", "-slant"; of one of directions().
  [[nodiscard]] const std::string& direction_name(DirectionIndex direction) const {
    return direction_names_[direction];
  }
  /// Of length 1.
  [[nodiscard]] Vector3 direction_vector(DirectionIndex direction) const;
  /// The one of directions() with that name.
  [[nodiscard]] std::optional<DirectionIndex> find_direction(std::string_view name) const;
  /// directions() as bits, 64 a word, a bit for each number; no word where there is no blocking.
  [[nodiscard]] std::span<const std::uint64_t> direction_bits() const { return direction_bits_; }
  /// Whether the numbers of directions are below 32, so that Blocker::directions is a mask.
  [[nodiscard]] bool has_direction_masks() const { return has_direction_masks_; }
  /// directions() as a mask, where has_direction_masks().
  [[nodiscard]] DirectionMask direction_mask() const {
    return direction_bits_.empty() ? 0 : static_cast<DirectionMask>(direction_bits_[0]);
  }
  /// The directions of a blocker as bits, where there are no masks.
  [[nodiscard]] std::span<const std::uint64_t> direction_set(const Blocker& blocker) const {
    const std::size_t words = direction_bits_.size();
    return {direction_sets_.data() + blocker.directions * words, words};
  }
  /// Whether it stands in the way along `direction`.
  [[nodiscard]] bool blocks(const Blocker& blocker, std::size_t direction) const {
    if (has_direction_masks_) return (blocker.directions >> direction & 1U) != 0;
    return (direction_set(blocker)[direction / 64] >> direction % 64 & 1U) != 0;
  }
  /// Takes the directions of a blocker out of `free`, which is as long as direction_bits(). Returns
  /// whether any are left.
  bool take_out(const Blocker& blocker, std::span<std::uint64_t> free) const {
    if (has_direction_masks_) return (free[0] &= ~std::uint64_t{blocker.directions}) != 0;
    const std::span<const std::uint64_t> blocked = direction_set(blocker);
    std::uint64_t left = 0;
    for (std::size_t w = 0; w < free.size(); ++w) left |= free[w] &= ~blocked[w];
    return left != 0;
  }

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
  void index_base();
  void index_goal();
  void check_action() const;
  void index_directions();
  void index_blockers_by_masks();
  void index_blockers_by_sets();
  void check_limits() const;
  void check_fleet() const;
  void check_numbers() const;

  ProblemSpec spec_;
  std::unordered_map<std::string, PartIndex> part_by_id_;
  std::unordered_map<std::string, ConnectionIndex> connection_by_id_;
  std::vector<std::array<PartIndex, 2>> ends_;
  std::vector<std::vector<ConnectionIndex>> breaks_;
  std::vector<PrecedenceClause> precedence_;
  std::vector<std::vector<Blocker>> blockers_;
  std::vector<bool> base_;
  std::vector<ConnectionIndex> goal_;
  std::vector<DirectionIndex> directions_;
  std::vector<std::string> direction_names_;  ///< by number
  std::vector<Vector3> named_vectors_;        ///< one for each named pair, of length 1
  std::unordered_map<std::string, DirectionIndex> direction_by_name_;  ///< the named ones
  std::vector<std::uint64_t> direction_bits_;
  bool has_direction_masks_ = true;
  std::vector<std::uint64_t> direction_sets_;  ///< different ones, where there are no masks
  std::vector<std::string> warnings_;
};

}  // namespace orasp
