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

constexpr PartMask bit_of_part(std::size_t part) {
  return PartMask{1} << part;
}

constexpr PartMask lowest(PartMask parts) {
  return parts & (~parts + 1);
}

}  // namespace

void FleetExpander::Way::add(const Way& other) {
  for (std::size_t d = 0; d < along.size(); ++d) {
    along[d] |= other.along[d];
    blockers[d] |= other.blockers[d];
  }
}

bool FleetExpander::Way::free(PartMask within) const {
  for (std::size_t d = 0; d < along.size(); ++d) {
    if ((blockers[d] & within & ~along[d]) != 0) return false;
  }
  return true;
}

FleetExpander::FleetExpander(const FleetProblem& fleet)
    : fleet_(&fleet), num_parts_(fleet.num_parts()) {
  const Problem& problem = fleet.problem();
  if (num_parts_ > kFleetMaxParts)
    throw InputError("parts: an exact search for fleets takes at most " +
                     std::to_string(kFleetMaxParts) + " parts, and there are " +
                     std::to_string(num_parts_));
  adjacent_.assign(num_parts_, 0);
  never_.assign(num_parts_, 0);
  blockers_.assign(num_parts_, {});
  axis_.assign(num_parts_ * num_parts_, kNotJoined);
  const auto join = [&](std::size_t i, std::size_t j, std::size_t axis) {
    adjacent_[i] |= bit_of_part(j);
    std::uint8_t& known = axis_[i * num_parts_ + j];
    known = known == kNotJoined || known == axis ? static_cast<std::uint8_t>(axis) : kNever;
    if (known == kNever) never_[i] |= bit_of_part(j);
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
        if ((blocker.directions >> d & 1U) != 0) blockers_[part][d] |= bit_of_part(blocker.by);
      }
    }
    mass_.push_back(problem.parts()[part].mass);
  }
  const Limits& limits = problem.limits();
  most_moved_parts_ = limits.max_moved_parts.value_or(std::numeric_limits<std::size_t>::max());
  most_moved_mass_ = limits.max_moved_mass.value_or(kInfinity);
  lock_sets_.emplace_back();
  lock_numbers_.emplace(lock_sets_[0], 0);

  PartMask seen = 0;
  for (std::size_t part = 0; part < num_parts_; ++part) {
    if ((seen >> part & 1U) != 0 || adjacent_[part] == 0) continue;
    start_.push_back(reached(bit_of_part(part), ~PartMask{0}));
    seen |= start_.back();
  }
}

PartMask FleetExpander::reached(PartMask from, PartMask within) const {
  PartMask found = from;
  for (PartMask frontier = from; frontier != 0;) {
    const auto part = static_cast<std::size_t>(std::countr_zero(frontier));
    const PartMask fresh = adjacent_[part] & within & ~found;
    found |= fresh;
    frontier = (frontier & (frontier - 1)) | fresh;
  }
  return found;
}

unsigned FleetExpander::allowed_beside(std::size_t i, std::size_t j, Motion motion,
                                       const std::vector<PartMask>& rigid) const {
  unsigned allowed = bit_of(motion);
  if ((rigid[i] >> j & 1U) != 0) return allowed;
  const std::size_t axis = axis_[i * num_parts_ + j];
  if (motion == kStay) return allowed | bit_of(motion_along(axis));
  if (motion == motion_along(opposite(axis))) allowed |= bit_of(kStay) | bit_of(motion_along(axis));
  return allowed;
}

bool FleetExpander::liftable(PartMask block) const {
  if (size_of(block) > most_moved_parts_) return false;
  if (most_moved_mass_ == kInfinity) return true;
  double sum = 0;
  for_each_part(block, [&](std::size_t part) { sum += mass_[part]; });
  return sum <= most_moved_mass_ * (1 + kRelativeTolerance);
}

std::vector<PartMask> FleetExpander::rigid(Locks locks) const {
  std::vector<PartMask> rigid = never_;
  for (const ConnectionIndex c : lock_sets_[locks]) {
    const auto [i, j] = fleet_->problem().ends(c);
    rigid[i] |= bit_of_part(j);
    rigid[j] |= bit_of_part(i);
  }
  return rigid;
}

FleetExpander::Locks FleetExpander::locks_under_precedence(std::span<const PartMask> all,
                                                           PartMask subassembly) {
  const Problem& problem = fleet_->problem();
  const auto open = [&](ConnectionIndex c) {
    const auto [i, j] = problem.ends(c);
    const PartMask both = bit_of_part(i) | bit_of_part(j);
    return std::ranges::any_of(all, [both](PartMask piece) { return (piece & both) == both; });
  };
  std::vector<ConnectionIndex> locked;
  for (const PrecedenceClause& clause : problem.precedence()) {
    const auto [i, j] = problem.ends(clause.connection);
    const PartMask both = bit_of_part(i) | bit_of_part(j);
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
class FleetExpander::Lister {
 public:
  Lister(const FleetExpander& expander, PartMask subassembly, Locks locks, std::size_t cluster)
      : expander_(expander),
        subassembly_(subassembly),
        rigid_(expander.rigid(locks)),
        most_(std::min(cluster, size_of(subassembly))) {}

  [[nodiscard]] bool interrupted() const { return interrupted_; }

  Known list() {
    for_each_part(subassembly_, [this](std::size_t root) {
      const PartMask later = subassembly_ & ~(bit_of_part(root) | (bit_of_part(root) - 1));
      grow(bit_of_part(root), expander_.adjacent_[root] & later, later);
    });
    std::ranges::stable_sort(known_.clusters, {},
                             [](const Cluster& cluster) { return size_of(cluster.parts); });
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
  void grow(PartMask cluster, PartMask reach, PartMask allowed) {
    const PartMask rest = subassembly_ & ~cluster;
    if (rest == 0 || is_interrupted()) return;
    // What stays lies in one piece of the rest, so all others would have to be held too.
    PartMask widest = 0;
    bool connected = true;
    for (PartMask left = rest; left != 0;) {
      const PartMask piece = expander_.reached(lowest(left), left);
      connected = connected && piece == rest;
      if (size_of(piece) > size_of(widest)) widest = piece;
      left &= ~piece;
    }
    if (size_of(subassembly_) - size_of(widest) > most_ || size_of(widest) < 2) return;
    if (connected) add_cluster(cluster);
    if (size_of(cluster) == most_) return;
    while (reach != 0) {
      const PartMask next = lowest(reach);
      reach &= ~next;
      allowed &= ~next;
      const auto part = static_cast<std::size_t>(std::countr_zero(next));
      grow(cluster | next, reach | (expander_.adjacent_[part] & allowed), allowed);
    }
  }

  void add_cluster(PartMask parts) {
    const std::vector<Option> options = ways_of(parts);
    if (options.empty()) return;
    PartMask near = parts;
    for_each_part(parts, [&](std::size_t part) { near |= expander_.adjacent_[part]; });
    known_.clusters.push_back({.parts = parts,
                               .near = near & subassembly_,
                               .first_option = static_cast<std::uint32_t>(known_.options.size()),
                               .num_options = static_cast<std::uint32_t>(options.size())});
    known_.options.insert(known_.options.end(), options.begin(), options.end());
  }

  /// The ways in which `held` comes off what is left of the subassembly, few held in blocks first.
  std::vector<Option> ways_of(PartMask held) {
    held_ = held;
    options_.clear();
    met_.clear();
    order_.clear();
    motion_.fill(kStay);
    const PartMask stays = subassembly_ & ~held;
    PartMask left = held;
    // Parts beside the block that stays first: their motions are forced.
    for_each_part(held, [&](std::size_t part) {
      if ((expander_.adjacent_[part] & stays) == 0) return;
      order_.push_back(part);
      left &= ~bit_of_part(part);
    });
    while (left != 0) {
      PartMask beside = left;
      for_each_part(left, [&](std::size_t part) {
        if ((expander_.adjacent_[part] & held & ~left) == 0) beside &= ~bit_of_part(part);
      });
      if (beside == 0) beside = lowest(left);
      for_each_part(beside, [&](std::size_t part) { order_.push_back(part); });
      left &= ~beside;
    }
    assign(0, stays);
    std::ranges::stable_sort(options_, {}, &Option::held);
    return options_;
  }

  void assign(std::size_t position, PartMask assigned) {
    if (is_interrupted()) return;
    if (position == order_.size()) {
      add_option();
      return;
    }
    const std::size_t part = order_[position];
    const PartMask stays = subassembly_ & ~held_;
    unsigned allowed = (1U << kNumMotions) - 1;
    for_each_part(expander_.adjacent_[part] & assigned, [&](std::size_t other) {
      allowed &= expander_.allowed_beside(part, other, motion_[other], rigid_);
    });
    if ((expander_.adjacent_[part] & stays) != 0)
      allowed &= ~bit_of(kStay);  // it would not be held
    for (; allowed != 0; allowed &= allowed - 1) {
      motion_[part] = static_cast<Motion>(std::countr_zero(allowed));
      assign(position + 1, assigned | bit_of_part(part));
    }
    motion_[part] = kStay;
  }

  void add_option() {
    std::array<PartMask, kNumMotions> moving{};
    for_each_part(held_, [&](std::size_t part) { moving[motion_[part]] |= bit_of_part(part); });
    Option option;
    std::vector<PartMask> key;
    for (std::size_t motion = 0; motion < moving.size(); ++motion) {
      for (PartMask left = moving[motion]; left != 0;) {
        const PartMask block = expander_.reached(lowest(left), left);
        left &= ~block;
        if (!expander_.liftable(block)) return;
        if (size_of(block) == 1) {
          option.freed |= block;
        } else {
          if (motion == kStay) return;  // nobody would hold it
          key.push_back(block);
          option.held = static_cast<std::uint8_t>(option.held + size_of(block));
        }
      }
    }
    std::ranges::sort(key);
    option.num_moved = static_cast<std::uint8_t>(key.size());
    option.first_moved = static_cast<std::uint32_t>(known_.moved.size());
    if (expander_.has_blocking_) {
      Way way;
      for (std::size_t d = 0; d < way.along.size(); ++d) {
        way.along[d] = moving[motion_along(d)];
        for_each_part(way.along[d],
                      [&](std::size_t part) { way.blockers[d] |= expander_.blockers_[part][d]; });
      }
      std::vector<PartMask> full = key;
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

  const FleetExpander& expander_;
  const PartMask subassembly_;
  const std::vector<PartMask> rigid_;
  const std::size_t most_;
  Known known_;
  PartMask held_ = 0;
  std::vector<std::size_t> order_;
  std::array<Motion, kFleetMaxParts> motion_{};
  std::vector<Option> options_;
  std::set<std::vector<PartMask>> met_;
  std::uint32_t work_ = 0;
  bool interrupted_ = false;
};

const FleetExpander::Known& FleetExpander::known(PartMask subassembly, Locks locks,
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
              known.moved.size() * sizeof(PartMask) + known.ways.size() * sizeof(Way);
  }
  return entry->second;
}

bool FleetExpander::motions(PartMask subassembly, Locks locks, const FleetSplit& split,
                            std::span<Motion> motions) const {
  const auto too_heavy = [this](PartMask block) { return !liftable(block); };
  bool liftable_singles = true;
  for_each_part(split.freed,
                [&](std::size_t part) { liftable_singles &= liftable(bit_of_part(part)); });
  if (!liftable_singles || std::ranges::any_of(split.moved, too_heavy)) return false;
  struct Block {
    PartMask parts;
    unsigned allowed;  ///< motions
  };
  constexpr unsigned kAny = (1U << kNumMotions) - 1;
  std::vector<Block> left;
  if (split.stays != 0) left.push_back({split.stays, bit_of(kStay)});
  for (const PartMask block : split.moved) left.push_back({block, kAny & ~bit_of(kStay)});
  for_each_part(split.freed, [&](std::size_t part) { left.push_back({bit_of_part(part), kAny}); });
  // Each block beside one before it.
  std::vector<Block> blocks;
  PartMask near = 0;
  while (!left.empty()) {
    auto next = std::ranges::find_if(left, [&](const Block& b) { return (b.parts & near) != 0; });
    if (next == left.end()) next = left.begin();
    for_each_part(next->parts, [&](std::size_t part) { near |= adjacent_[part]; });
    blocks.push_back(*next);
    left.erase(next);
  }

  const std::vector<PartMask> stiff = rigid(locks);
  PartMask assigned = 0;
  const auto unblocked = [&] {
    Way way;
    for_each_part(subassembly, [&](std::size_t part) {
      if (motions[part] == kStay) return;
      const std::size_t d = direction_of(motions[part]);
      way.along[d] |= bit_of_part(part);
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

}  // namespace orasp
