#include "orasp/fleet/fleet_expander.h"

#include <algorithm>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "orasp/model/tolerance.h"

namespace orasp {
namespace {

constexpr std::uint8_t kNotJoined = 6;
constexpr std::uint8_t kNever = 7;

constexpr unsigned bit_of(Motion motion) {
  return 1U << motion;
}

}  // namespace

template <class Parts>
void FleetExpander<Parts>::Way::add(const Way& other) {
  for (std::size_t d = 0; d < along.size(); ++d) {
    along[d] |= other.along[d];
    blockers[d] |= other.blockers[d];
  }
}

template <class Parts>
bool FleetExpander<Parts>::Way::free(Parts within) const {
  for (std::size_t d = 0; d < along.size(); ++d) {
    if ((blockers[d] & within & ~along[d]) != 0) return false;
  }
  return true;
}

template <class Parts>
FleetExpander<Parts>::FleetExpander(const FleetProblem& fleet)
    : fleet_(&fleet), num_parts_(fleet.num_parts()) {
  const Problem& problem = fleet.problem();
  if (num_parts_ > kMostParts<Parts>)
    throw InputError("parts: an exact search for fleets takes at most " +
                     std::to_string(kMostParts<Parts>) + " parts, and there are " +
                     std::to_string(num_parts_));
  adjacent_.assign(num_parts_, 0);
  never_.assign(num_parts_, 0);
  blockers_.assign(num_parts_, {});
  axis_.assign(num_parts_ * num_parts_, kNotJoined);
  const auto join = [&](std::size_t i, std::size_t j, std::size_t axis) {
    adjacent_[i] |= only<Parts>(j);
    std::uint8_t& known = axis_[i * num_parts_ + j];
    known = known == kNotJoined || known == axis ? static_cast<std::uint8_t>(axis) : kNever;
    if (known == kNever) never_[i] |= only<Parts>(j);
  };
  for (ConnectionIndex c = 0; c < problem.num_connections(); ++c) {
    const auto [i, j] = problem.ends(c);
    join(i, j, fleet.axis(c));
    join(j, i, opposite(fleet.axis(c)));
  }
  for (std::size_t part = 0; part < num_parts_; ++part) {
    for (const Blocker& blocker : problem.blockers()[part]) {
      has_blocking_ = true;
      for (std::size_t d = 0; d < blockers_[part].size(); ++d) {
        if ((blocker.directions >> d & 1U) != 0) blockers_[part][d] |= only<Parts>(blocker.by);
      }
    }
    mass_.push_back(problem.parts()[part].mass);
  }
  const Limits& limits = problem.limits();
  most_moved_parts_ = limits.max_moved_parts.value_or(std::numeric_limits<std::size_t>::max());
  most_moved_mass_ = limits.max_moved_mass.value_or(kInfinity);
  moved_.resize(std::min(fleet.robots(), num_parts_) / 2 + 1);
  lock_sets_.emplace_back();
  lock_numbers_.emplace(lock_sets_[0], 0);

  Parts seen = 0;
  for (std::size_t part = 0; part < num_parts_; ++part) {
    if (holds(seen, part) || adjacent_[part] == 0) continue;
    start_.push_back(reached(only<Parts>(part), ~Parts{}));
    seen |= start_.back();
  }
}

template <class Parts>
Parts FleetExpander<Parts>::reached(Parts from, Parts within) const {
  Parts found = from;
  for (Parts frontier = from; frontier != 0;) {
    const std::size_t part = first_of(frontier);
    const Parts fresh = adjacent_[part] & within & ~found;
    found |= fresh;
    frontier = without_first(frontier) | fresh;
  }
  return found;
}

template <class Parts>
std::optional<std::size_t> FleetExpander<Parts>::axis_between(std::size_t part,
                                                              std::size_t other) const {
  const std::uint8_t axis = axis_[part * num_parts_ + other];
  if (axis >= kNotJoined) return std::nullopt;
  return axis;
}

template <class Parts>
unsigned FleetExpander<Parts>::allowed_beside(std::size_t i, std::size_t j, Motion motion,
                                              const std::vector<Parts>& rigid) const {
  unsigned allowed = bit_of(motion);
  if (holds(rigid[i], j)) return allowed;
  const std::size_t axis = axis_[i * num_parts_ + j];
  if (motion == kStay) return allowed | bit_of(motion_along(axis));
  if (motion == motion_along(opposite(axis))) allowed |= bit_of(kStay) | bit_of(motion_along(axis));
  return allowed;
}

template <class Parts>
bool FleetExpander<Parts>::liftable(Parts block) const {
  if (size_of(block) > most_moved_parts_) return false;
  if (most_moved_mass_ == kInfinity) return true;
  double sum = 0;
  for_each_part(block, [&](std::size_t part) { sum += mass_[part]; });
  return sum <= most_moved_mass_ * (1 + kRelativeTolerance);
}

template <class Parts>
std::vector<Parts> FleetExpander<Parts>::rigid(Locks locks) const {
  std::vector<Parts> rigid = never_;
  for (const ConnectionIndex c : lock_sets_[locks]) {
    const auto [i, j] = fleet_->problem().ends(c);
    rigid[i] |= only<Parts>(j);
    rigid[j] |= only<Parts>(i);
  }
  return rigid;
}

template <class Parts>
typename FleetExpander<Parts>::Locks FleetExpander<Parts>::locks_under_precedence(
    std::span<const Parts> all, Parts subassembly) {
  const Problem& problem = fleet_->problem();
  const auto open = [&](ConnectionIndex c) {
    const auto [i, j] = problem.ends(c);
    const Parts both = only<Parts>(i) | only<Parts>(j);
    return std::ranges::any_of(all, [both](Parts piece) { return (piece & both) == both; });
  };
  std::vector<ConnectionIndex> locked;
  for (const PrecedenceClause& clause : problem.precedence()) {
    const auto [i, j] = problem.ends(clause.connection);
    const Parts both = only<Parts>(i) | only<Parts>(j);
    if ((subassembly & both) != both) continue;
    const bool waits = std::ranges::any_of(clause.after, open) ||
                       (!clause.after_any.empty() && std::ranges::all_of(clause.after_any, open));
    if (waits) locked.push_back(clause.connection);
  }
  std::ranges::sort(locked);
  locked.erase(std::unique(locked.begin(), locked.end()), locked.end());
  const auto [entry, is_new] =
      lock_numbers_.try_emplace(std::move(locked), static_cast<Locks>(lock_sets_.size()));
  if (is_new) lock_sets_.push_back(entry->first);
  return entry->second;
}

/// Lists clusters of one subassembly and the ways in which they move.
template <class Parts>
class FleetExpander<Parts>::Lister {
 public:
  Lister(const FleetExpander<Parts>& expander, Parts subassembly, Locks locks, std::size_t cluster)
      : expander_(expander),
        subassembly_(subassembly),
        rigid_(expander.rigid(locks)),
        most_(std::min(cluster, size_of(subassembly))) {}

  [[nodiscard]] bool interrupted() const { return interrupted_; }

  Known list() {
    for_each_part(subassembly_, [this](std::size_t root) {
      const Parts later = subassembly_ & after<Parts>(root);
      grow(only<Parts>(root), expander_.adjacent_[root] & later, later);
    });
    std::ranges::stable_sort(known_.clusters, {},
                             [](const Cluster& cluster) { return size_of(cluster.parts); });
    std::size_t ends = 0;
    for_each_part(subassembly_, [&](std::size_t part) {
      ends += size_of(expander_.adjacent_[part] & subassembly_);
    });
    known_.is_tree = ends == 2 * (size_of(subassembly_) - 1);
    if (size_of(subassembly_) <= most_) {
      known_.whole = ways_of(subassembly_);
      if (expander_.has_blocking_) {
        std::erase_if(known_.whole, [this](const Option& option) {
          return !known_.ways[option.way].free(subassembly_);
        });
      }
    }
    return std::move(known_);
  }

 private:
  bool is_interrupted() {
    constexpr std::uint32_t kWorkBetweenPolls = 8192;
    if (++work_ % kWorkBetweenPolls == 0 && expander_.interrupted_ && expander_.interrupted_())
      interrupted_ = true;
    return interrupted_;
  }
  /// Every connected set that holds its first part and, beyond it, later ones: `reach` are the
  /// parts that may join next, `allowed` those that may join at all.
  void grow(Parts cluster, Parts reach, Parts allowed) {
    const Parts rest = subassembly_ & ~cluster;
    if (rest == 0 || is_interrupted() || is_stuck(cluster, allowed)) return;
    // What stays lies in one piece of the rest, so all others would have to be held too.
    Parts widest = 0;
    bool connected = true;
    for (Parts left = rest; left != 0;) {
      const Parts piece = expander_.reached(lowest(left), left);
      connected = connected && piece == rest;
      if (size_of(piece) > size_of(widest)) widest = piece;
      left &= ~piece;
    }
    if (size_of(subassembly_) - size_of(widest) > most_ || size_of(widest) < 2) return;
    if (connected) add_cluster(cluster);
    if (size_of(cluster) == most_) return;
    while (reach != 0) {
      const Parts next = lowest(reach);
      reach &= ~next;
      allowed &= ~next;
      const std::size_t part = first_of(next);
      grow(cluster | next, reach | (expander_.adjacent_[part] & allowed), allowed);
    }
  }

  /// Whether no motions part the cluster from what is beside it and may not join it any more: that
  /// stays, so it forces the motions of the parts that it is joined to.
  bool is_stuck(const Parts& cluster, const Parts& allowed) {
    const Parts outside = subassembly_ & ~cluster & ~allowed;
    std::array<Motion, kMostParts<Parts>>& forced = motion_;
    Parts seen = 0;
    bool stuck = false;
    for_each_part(cluster, [&](std::size_t part) {
      const Parts beside = expander_.adjacent_[part] & outside;
      if (stuck || beside == 0) return;
      stuck = (beside & rigid_[part]) != 0;
      if (stuck) return;
      const std::size_t axis = expander_.axis_[part * expander_.num_parts_ + first_of(beside)];
      for_each_part(beside, [&](std::size_t other) {
        stuck = stuck || expander_.axis_[part * expander_.num_parts_ + other] != axis;
      });
      forced[part] = motion_along(axis);
      for_each_part(expander_.adjacent_[part] & seen, [&](std::size_t other) {
        stuck = stuck || (expander_.allowed_beside(part, other, forced[other], rigid_) &
                          bit_of(forced[part])) == 0;
      });
      seen |= only<Parts>(part);
    });
    return stuck;
  }

  void add_cluster(Parts parts) {
    const std::vector<Option> options = ways_of(parts);
    if (options.empty()) return;
    Parts near = parts;
    for_each_part(parts, [&](std::size_t part) { near |= expander_.adjacent_[part]; });
    known_.clusters.push_back({.parts = parts,
                               .near = near & subassembly_,
                               .first_option = static_cast<std::uint32_t>(known_.options.size()),
                               .num_options = static_cast<std::uint32_t>(options.size())});
    known_.options.insert(known_.options.end(), options.begin(), options.end());
  }

  /// The ways in which `held` comes off what is left of the subassembly, few held in blocks first.
  std::vector<Option> ways_of(Parts held) {
    held_ = held;
    options_.clear();
    met_.clear();
    order_.clear();
    motion_.fill(kStay);
    const Parts stays = subassembly_ & ~held;
    Parts left = held;
    // Parts beside the block that stays first: their motions are forced.
    for_each_part(held, [&](std::size_t part) {
      if ((expander_.adjacent_[part] & stays) == 0) return;
      order_.push_back(part);
      left &= ~only<Parts>(part);
    });
    while (left != 0) {
      Parts beside = left;
      for_each_part(left, [&](std::size_t part) {
        if ((expander_.adjacent_[part] & held & ~left) == 0) beside &= ~only<Parts>(part);
      });
      if (beside == 0) beside = lowest(left);
      for_each_part(beside, [&](std::size_t part) { order_.push_back(part); });
      left &= ~beside;
    }
    assign(0, stays);
    std::ranges::stable_sort(options_, {}, &Option::held);
    return options_;
  }

  void assign(std::size_t position, Parts assigned) {
    if (is_interrupted()) return;
    if (position == order_.size()) {
      add_option();
      return;
    }
    const std::size_t part = order_[position];
    const Parts stays = subassembly_ & ~held_;
    unsigned allowed = (1U << kNumMotions) - 1;
    for_each_part(expander_.adjacent_[part] & assigned, [&](std::size_t other) {
      allowed &= expander_.allowed_beside(part, other, motion_[other], rigid_);
    });
    if ((expander_.adjacent_[part] & stays) != 0)
      allowed &= ~bit_of(kStay);  // it would not be held
    for (; allowed != 0; allowed &= allowed - 1) {
      motion_[part] = static_cast<Motion>(std::countr_zero(allowed));
      assign(position + 1, assigned | only<Parts>(part));
    }
    motion_[part] = kStay;
  }

  void add_option() {
    std::array<Parts, kNumMotions> moving{};
    for_each_part(held_, [&](std::size_t part) { moving[motion_[part]] |= only<Parts>(part); });
    Option option;
    std::vector<Parts> key;
    for (std::size_t motion = 0; motion < moving.size(); ++motion) {
      for (Parts left = moving[motion]; left != 0;) {
        const Parts block = expander_.reached(lowest(left), left);
        left &= ~block;
        if (!expander_.liftable(block)) return;
        if (size_of(block) == 1) {
          option.freed |= block;
        } else {
          if (motion == kStay) return;  // nobody would hold it
          key.push_back(block);
          option.held = static_cast<std::uint16_t>(option.held + size_of(block));
        }
      }
    }
    std::ranges::sort(key);
    option.num_moved = static_cast<std::uint16_t>(key.size());
    option.first_moved = static_cast<std::uint32_t>(known_.moved.size());
    if (expander_.has_blocking_) {
      Way way;
      for (std::size_t d = 0; d < way.along.size(); ++d) {
        way.along[d] = moving[motion_along(d)];
        for_each_part(way.along[d],
                      [&](std::size_t part) { way.blockers[d] |= expander_.blockers_[part][d]; });
      }
      std::vector<Parts> full = key;
      full.insert(full.end(), way.along.begin(), way.along.end());
      if (!met_.insert(std::move(full)).second) return;
      option.way = static_cast<std::uint32_t>(known_.ways.size());
      known_.ways.push_back(way);
    } else if (!met_.insert(key).second) {
      return;
    }
    known_.moved.insert(known_.moved.end(), key.begin(), key.end());
    options_.push_back(option);
  }

  const FleetExpander<Parts>& expander_;
  const Parts subassembly_;
  const std::vector<Parts> rigid_;
  const std::size_t most_;
  Known known_;
  Parts held_ = 0;
  std::vector<std::size_t> order_;
  std::array<Motion, kMostParts<Parts>> motion_{};
  std::vector<Option> options_;
  std::set<std::vector<Parts>> met_;
  std::uint32_t work_ = 0;
  bool interrupted_ = false;
};

template <class Parts>
const typename FleetExpander<Parts>::Known& FleetExpander<Parts>::known(Parts subassembly,
                                                                        Locks locks,
                                                                        std::size_t cluster) {
  const auto [entry, is_new] =
      known_.try_emplace({subassembly, locks, static_cast<std::uint32_t>(cluster)});
  if (is_new) {
    Known& known = entry->second;
    Lister lister(*this, subassembly, locks, cluster);
    known = lister.list();
    if (lister.interrupted()) {
      interrupted_listing_ = std::move(known);
      known_.erase(entry);
      return interrupted_listing_;
    }
    bytes_ += sizeof(Key) + sizeof(Known) + known.clusters.size() * sizeof(Cluster) +
              (known.options.size() + known.whole.size()) * sizeof(Option) +
              known.moved.size() * sizeof(Parts) + known.ways.size() * sizeof(Way);
  }
  return entry->second;
}

template <class Parts>
bool FleetExpander<Parts>::motions(Parts subassembly, Locks locks, const FleetSplit<Parts>& split,
                                   std::span<Motion> motions) const {
  const auto too_heavy = [this](Parts block) { return !liftable(block); };
  bool liftable_singles = true;
  for_each_part(split.freed,
                [&](std::size_t part) { liftable_singles &= liftable(only<Parts>(part)); });
  if (!liftable_singles || std::ranges::any_of(split.moved, too_heavy)) return false;
  struct Block {
    Parts parts;
    unsigned allowed;  ///< motions
  };
  constexpr unsigned kAny = (1U << kNumMotions) - 1;
  std::vector<Block> left;
  if (split.stays != 0) left.push_back({split.stays, bit_of(kStay)});
  for (const Parts& block : split.moved) left.push_back({block, kAny & ~bit_of(kStay)});
  for_each_part(split.freed, [&](std::size_t part) { left.push_back({only<Parts>(part), kAny}); });
  // Each block beside one before it.
  std::vector<Block> blocks;
  Parts near = 0;
  while (!left.empty()) {
    auto next = std::ranges::find_if(left, [&](const Block& b) { return (b.parts & near) != 0; });
    if (next == left.end()) next = left.begin();
    for_each_part(next->parts, [&](std::size_t part) { near |= adjacent_[part]; });
    blocks.push_back(*next);
    left.erase(next);
  }

  const std::vector<Parts> stiff = rigid(locks);
  Parts assigned = 0;
  const auto unblocked = [&] {
    Way way;
    for_each_part(subassembly, [&](std::size_t part) {
      if (motions[part] == kStay) return;
      const std::size_t d = direction_of(motions[part]);
      way.along[d] |= only<Parts>(part);
      way.blockers[d] |= blockers_[part][d];
    });
    return way.free(subassembly);
  };
  const auto assign = [&](auto& self, std::size_t position) -> bool {
    if (position == blocks.size()) return unblocked();
    const Block& block = blocks[position];
    unsigned allowed = block.allowed;
    for_each_part(block.parts, [&](std::size_t part) {
      for_each_part(adjacent_[part] & assigned, [&](std::size_t other) {
        allowed &= allowed_beside(part, other, motions[other], stiff) & ~bit_of(motions[other]);
      });
    });
    for (; allowed != 0; allowed &= allowed - 1) {
      const auto motion = static_cast<Motion>(std::countr_zero(allowed));
      for_each_part(block.parts, [&](std::size_t part) { motions[part] = motion; });
      assigned |= block.parts;
      if (self(self, position + 1)) return true;
      assigned &= ~block.parts;
    }
    return false;
  };
  return assign(assign, 0);
}

ORASP_FOR_EVERY_PART_SET(FleetExpander);

}  // namespace orasp
