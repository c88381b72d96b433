#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "orasp/fleet/fleet.h"
#include "orasp/fleet/part_set.h"

namespace orasp {

/// How a subassembly comes out of a step.
template <class Parts>
struct FleetSplit {
  Parts stays = 0;               ///< the block that no robot holds; 0: none
  Parts freed = 0;               ///< single parts, each held, bound for the depot
  std::span<const Parts> moved;  ///< blocks of two or more parts, held and moving
  std::size_t held = 0;          ///< parts of all moved blocks

  [[nodiscard]] std::size_t robots() const { return held + size_of(freed); }
};

/// The ways in which subassemblies can come out of a step: the rules of fleets, arranged for
/// search.
///
/// Idea.  The parts of a subassembly that no robot holds form one connected block, since they have
///        the same motion, none, and one site. So the held parts are few, and fall into clusters
///        (connected sets of held parts) that do not touch: each leaves a connected rest, has
///        motions of its own, and is worked out once. A split is a choice of clusters. If no block
///        stays, all parts are held, and the subassembly has at most as many parts as there are
///        robots. What motions a split needs is only asked for a plan (motions()): other steps do
///        not depend on them.
/// Cost.  Splits are listed without motions, each once. Subassemblies are remembered with their
///        clusters.
/// Owns its memory; refers to the problem. For one thread. `Parts` is a PartsIn for the product:
/// sets of parts as long as it needs.
template <class Parts>
class FleetExpander {
 public:
  /// @throws InputError above kMostParts<Parts> parts.
  explicit FleetExpander(const FleetProblem& fleet);
  // A fleet that goes out of scope at once.
  explicit FleetExpander(const FleetProblem&&) = delete;

  [[nodiscard]] const FleetProblem& fleet() const { return *fleet_; }
  /// The subassemblies of the start, by their first part.
  [[nodiscard]] const std::vector<Parts>& start() const { return start_; }
  /// The parts that `part` is joined to at the start.
  [[nodiscard]] Parts neighbours(std::size_t part) const { return adjacent_[part]; }

  /// The direction in which `part` comes off `other`, which it is joined to; empty if it cannot.
  [[nodiscard]] std::optional<std::size_t> axis_between(std::size_t part, std::size_t other) const;
  [[nodiscard]] bool has_blocking() const { return has_blocking_; }
  /// The parts that block `part` along each direction.
  [[nodiscard]] const std::array<Parts, 6>& blockers(std::size_t part) const {
    return blockers_[part];
  }

  /// The connections of one subassembly that precedence forbids to cut now, as a number: 0 for
  /// none.
  using Locks = std::uint32_t;
  /// `all` are the subassemblies that there are, `subassembly` is one of them.
  [[nodiscard]] Locks locks(std::span<const Parts> all, Parts subassembly) {
    return has_precedence() ? locks_under_precedence(all, subassembly) : 0;
  }
  [[nodiscard]] bool has_precedence() const { return !fleet_->problem().precedence().empty(); }

  /// How much of a step may be made use of.
  struct Means {
    std::size_t robots = 0;
    std::size_t held = 0;  ///< robots on moved blocks
    std::size_t cluster = kMostParts<
        Parts>;  ///< parts of a cluster; fewer than the robots: not every split is listed
  };
  /// Calls `visit(const FleetSplit&)`, which says whether to go on, for every way in which
  /// `subassembly` can come out of a step. Waiting is one of them, and so is moving the whole.
  /// @returns false if it was told to end.
  template <class Visit>
  bool for_each_split(Parts subassembly, Locks locks, const Means& means, Visit&& visit);

  /// `interrupted` is asked now and then while the clusters of a large subassembly are worked out;
  /// once it says yes, splits are missing.
  void set_interrupt(std::function<bool()> interrupted) { interrupted_ = std::move(interrupted); }

  /// Motions that make the split happen, written to the entries of its parts. @returns whether
  /// there are any: so it is for every split that for_each_split lists, and for no other, but for
  /// the number of robots.
  [[nodiscard]] bool motions(Parts subassembly, Locks locks, const FleetSplit<Parts>& split,
                             std::span<Motion> motions) const;

  /// Memory of what is remembered.
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  /// Parts that move along each direction, and what stands in their way there; only where the
  /// problem has blocking.
  struct Way {
    std::array<Parts, 6> along{};
    std::array<Parts, 6> blockers{};

    void add(const Way& other);
    [[nodiscard]] bool free(Parts within) const;
  };
  /// One way in which a cluster, or a whole subassembly, moves.
  struct Option {
    Parts freed = 0;
    std::uint32_t first_moved = 0;
    std::uint16_t num_moved = 0;
    std::uint16_t held = 0;
    std::uint32_t way = 0;
  };
  struct Cluster {
    Parts parts = 0;
    Parts near = 0;  ///< parts and their neighbours
    std::uint32_t first_option = 0;
    std::uint32_t num_options = 0;
  };
  /// What is remembered of a subassembly.
  struct Known {
    std::vector<Cluster> clusters;  ///< that leave a block behind, small ones first
    std::vector<Option> options;    ///< of the clusters, few held first
    std::vector<Option> whole;      ///< ways in which every part is held
    std::vector<Parts> moved;
    std::vector<Way> ways;
    bool is_tree = false;  ///< so clusters that do not touch leave one block behind
  };
  struct Key {
    Parts parts;
    Locks locks;
    std::uint32_t cluster;  ///< the most parts of one
    friend bool operator==(const Key&, const Key&) = default;
  };
  struct KeyHash {
    std::size_t operator()(const Key& key) const noexcept {
      return static_cast<std::size_t>(mixed(
          hash_of(key.parts) + (key.locks * std::uint64_t{kMostParts<Parts> + 1} + key.cluster) *
                                   0x9e3779b97f4a7c15ULL));
    }
  };
  class Lister;

  [[nodiscard]] Locks locks_under_precedence(std::span<const Parts> all, Parts subassembly);
  const Known& known(Parts subassembly, Locks locks, std::size_t cluster);
  [[nodiscard]] Parts reached(Parts from, Parts within) const;
  /// Motions that part i may have next to a part j that moves by `motion`; 0 if they are not
  /// joined.
  [[nodiscard]] unsigned allowed_beside(std::size_t i, std::size_t j, Motion motion,
                                        const std::vector<Parts>& rigid) const;
  [[nodiscard]] bool liftable(Parts block) const;
  [[nodiscard]] std::vector<Parts> rigid(Locks locks) const;

  const FleetProblem* fleet_;
  std::size_t num_parts_;
  std::vector<Parts> start_;
  std::vector<Parts> adjacent_;
  std::vector<std::uint8_t>
      axis_;  ///< of part i off part j, at i * parts + j; kNever if they cannot be parted
  std::vector<Parts> never_;  ///< neighbours that cannot be pulled off
  std::vector<std::array<Parts, 6>> blockers_;
  bool has_blocking_ = false;
  std::size_t most_moved_parts_;
  double most_moved_mass_;
  std::vector<double> mass_;
  std::vector<std::vector<ConnectionIndex>> lock_sets_;  ///< by their number
  std::map<std::vector<ConnectionIndex>, Locks> lock_numbers_;
  std::unordered_map<Key, Known, KeyHash> known_;
  Known interrupted_listing_;  ///< not complete, so not remembered
  std::function<bool()> interrupted_;
  std::vector<Parts> moved_;   ///< blocks of the splits that are being visited
  std::size_t num_moved_ = 0;  ///< of the outer ones
  std::uint64_t bytes_ = 0;
};

template <class Parts>
template <class Visit>
bool FleetExpander<Parts>::for_each_split(Parts subassembly, Locks locks, const Means& means,
                                          Visit&& visit) {
  const Known& ways = known(subassembly, locks, std::min(means.cluster, fleet_->robots()));
  // Those of the splits that are being visited come first.
  const std::span<Parts> moved = std::span(moved_).subspan(num_moved_);

  struct Chosen {
    Parts held_parts = 0;
    Parts near = 0;
    Parts freed = 0;
    std::size_t robots;
    std::size_t held;
    std::size_t num_moved = 0;
  };
  const auto visited = [&](const FleetSplit<Parts>& split) {
    num_moved_ += split.stays != 0 ? split.moved.size() : 0;
    const bool goes_on = visit(split);
    num_moved_ -= split.stays != 0 ? split.moved.size() : 0;
    return goes_on;
  };
  const auto descend = [&](auto& self, std::size_t next, const Chosen& chosen,
                           const Way& way) -> bool {
    const Parts stays = subassembly & ~chosen.held_parts;
    if (without_first(stays) == 0) return true;  // the rest is no block of two parts or more
    if (!ways.is_tree && chosen.held_parts != 0 && reached(lowest(stays), stays) != stays)
      return true;
    if ((!has_blocking_ || way.free(subassembly)) &&
        !visited({.stays = stays,
                  .freed = chosen.freed,
                  .moved = moved.first(chosen.num_moved),
                  .held = means.held - chosen.held}))
      return false;
    for (std::size_t c = next; c < ways.clusters.size(); ++c) {
      const Cluster& cluster = ways.clusters[c];
      const auto size = size_of(cluster.parts);
      if (size > chosen.robots) break;
      if ((cluster.parts & chosen.near) != 0) continue;
      for (std::uint32_t o = 0; o < cluster.num_options; ++o) {
        const Option& option = ways.options[cluster.first_option + o];
        if (option.held > chosen.held) break;
        Chosen more{.held_parts = chosen.held_parts | cluster.parts,
                    .near = chosen.near | cluster.near,
                    .freed = chosen.freed | option.freed,
                    .robots = chosen.robots - size,
                    .held = chosen.held - option.held,
                    .num_moved = chosen.num_moved + option.num_moved};
        for (std::size_t m = 0; m < option.num_moved; ++m)
          moved[chosen.num_moved + m] = ways.moved[option.first_moved + m];
        if (has_blocking_) {
          Way joint = way;
          joint.add(ways.ways[option.way]);
          if (!self(self, c + 1, more, joint)) return false;
        } else if (!self(self, c + 1, more, way)) {
          return false;
        }
      }
    }
    return true;
  };
  if (!descend(descend, 0, Chosen{.robots = means.robots, .held = means.held}, Way{})) return false;

  if (size_of(subassembly) > means.robots) return true;
  for (const Option& option : ways.whole) {
    if (option.held > means.held) break;
    if (!visited({.stays = 0,
                  .freed = option.freed,
                  .moved = {ways.moved.data() + option.first_moved, option.num_moved},
                  .held = option.held}))
      return false;
  }
  return true;
}

}  // namespace orasp
