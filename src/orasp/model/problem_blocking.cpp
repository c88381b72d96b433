#include <algorithm>
#include <cmath>
#include <utility>

#include "orasp/model/detail/wording.h"
#include "orasp/model/problem.h"

namespace orasp {
namespace {

using detail::in_quotes;

constexpr std::size_t kAxes = kDirectionNames.size();
constexpr std::size_t kMostInMask = 32;
constexpr std::size_t kMostBytesOfSets = std::size_t{1} << 30U;

[[noreturn]] void refuse(const std::string& place, const std::string& message) {
  throw InputError(detail::at(place, message));
}

std::string entry_of(const std::string& list, std::size_t index) {
  return list + "[" + std::to_string(index) + "]";
}

std::optional<DirectionIndex> axis_called(std::string_view name) {
  const auto found = std::ranges::find(kDirectionNames, name);
  if (found == kDirectionNames.end()) return std::nullopt;
  return static_cast<DirectionIndex>(found - kDirectionNames.begin());
}

/// The vector of a named direction, made 1 long. Sums of squares neither overflow nor vanish.
Vector3 unit_vector(const Vector3& vector, const std::string& place) {
  double largest = 0;
  for (std::size_t axis = 0; axis < vector.size(); ++axis) {
    if (!std::isfinite(vector[axis])) {
      refuse(entry_of(place + ".vector", axis),
             detail::number_text(vector[axis]) + " is not a finite number");
    }
    largest = std::max(largest, std::abs(vector[axis]));
  }
  if (largest == 0) refuse(place + ".vector", "a vector of length 0 points nowhere");
  Vector3 unit{};
  double squares = 0;
  for (std::size_t axis = 0; axis < vector.size(); ++axis) {
    unit[axis] = vector[axis] / largest;
    squares += unit[axis] * unit[axis];
  }
  for (double& number : unit) number /= std::sqrt(squares);
  return unit;
}

/// The id of a direction with a vector.
void require_direction_id(const std::string& id, const std::string& place) {
  if (axis_called(id))
    refuse(place, in_quotes(id) + " is an axis and has no vector of its own; list it as \"" + id +
                      "\", without one");
  if (!id.empty() && (id.front() == '-' || id.front() == '+'))
    refuse(place, in_quotes(id) +
                      " begins with a sign; an id does not, and the opposite of \"a\" "
                      "is there with it, as \"-a\"");
  if (axis_called("-" + id))
    refuse(place, in_quotes(id) +
                      " is not the id of a direction, since its opposite would be the "
                      "axis " +
                      in_quotes("-" + id));
}

std::uint64_t hash_of(std::span<const std::uint64_t> words) {
  std::uint64_t hash = 0x9E3779B97F4A7C15U;
  for (const std::uint64_t word : words) {
    hash = (hash ^ word) * 0xBF58476D1CE4E5B9U;
    hash ^= hash >> 29U;
  }
  return hash;
}

/// Different sets of directions, each held once.
class DirectionSets {
 public:
  explicit DirectionSets(std::size_t words) : words_(words) {}

  /// The number of a set, which is held from now on.
  DirectionMask number_of(std::span<const std::uint64_t> set) {
    const std::uint64_t hash = hash_of(set);
    const auto [first, last] = by_hash_.equal_range(hash);
    for (auto found = first; found != last; ++found) {
      if (std::ranges::equal((*this)[found->second], set)) return found->second;
    }
    if ((bits_.size() + words_) * sizeof(std::uint64_t) > kMostBytesOfSets)
      refuse("blocking.blocked", "its different sets of directions take more than 1 GiB");
    const auto number = static_cast<DirectionMask>(bits_.size() / words_);
    bits_.insert(bits_.end(), set.begin(), set.end());
    by_hash_.emplace(hash, number);
    return number;
  }
  [[nodiscard]] std::span<const std::uint64_t> operator[](DirectionMask number) const {
    return {bits_.data() + number * words_, words_};
  }
  [[nodiscard]] std::vector<std::uint64_t> all() && { return std::move(bits_); }

 private:
  std::size_t words_;
  std::vector<std::uint64_t> bits_;
  std::unordered_multimap<std::uint64_t, DirectionMask> by_hash_;
};

/// The set of the opposites: neighbours change places.
std::uint64_t opposites(std::uint64_t bits) {
  constexpr std::uint64_t kEven = 0x5555555555555555U;
  return (bits & kEven) << 1U | (bits >> 1U & kEven);
}

/// The parts of an entry, and its directions by their numbers.
template <class EachDirection>
std::pair<PartIndex, PartIndex> read_blocked(
    const Problem& problem, const std::unordered_map<std::string, PartIndex>& parts, std::size_t i,
    EachDirection&& each) {
  const Blocked& entry = problem.spec().blocking->blocked[i];
  // The place is only made for a message: lists are long.
  const auto place = [i] { return entry_of("blocking.blocked", i); };
  const auto part_index = [&](const std::string& id, const char* key) {
    const auto found = parts.find(id);
    return found != parts.end() ? found->second : problem.find_part(id, place() + key);
  };
  const PartIndex part = part_index(entry.part, ".part");
  const PartIndex by = part_index(entry.by, ".by");
  if (part == by) refuse(place(), "part " + in_quotes(entry.part) + " cannot be blocked by itself");
  for (std::size_t k = 0; k < entry.directions.size(); ++k) {
    const std::string& name = entry.directions[k];
    if (const auto direction = problem.find_direction(name)) {
      each(*direction);
      continue;
    }
    std::vector<std::string_view> names;
    for (const DirectionIndex listed : problem.directions())
      names.push_back(problem.direction_name(listed));
    const std::string meant = axis_called(name) ? "" : detail::suggestion(name, names);
    refuse(entry_of(place() + ".directions", k), in_quotes(name) +
                                                     " is not in blocking.directions, which are " +
                                                     detail::listed_in_short(names) + meant);
  }
  return {part, by};
}

}  // namespace

std::optional<DirectionIndex> Problem::find_direction(std::string_view name) const {
  if (const auto axis = axis_called(name)) {
    const bool listed = !direction_bits_.empty() && (direction_bits_[0] >> *axis & 1U) != 0;
    return listed ? axis : std::nullopt;
  }
  if (direction_by_name_.empty()) return std::nullopt;
  const auto found = direction_by_name_.find(std::string(name));
  return found == direction_by_name_.end() ? std::nullopt : std::optional(found->second);
}

Vector3 Problem::direction_vector(DirectionIndex direction) const {
  const double sign = direction % 2 == 0 ? 1 : -1;
  Vector3 vector{};
  if (direction < kAxes) {
    vector[direction / 2] = sign;
    return vector;
  }
  vector = named_vectors_[(direction - kAxes) / 2];
  for (double& number : vector) number = sign * number + 0.0;
  return vector;
}

void Problem::index_blocking() {
  blockers_.resize(spec_.parts.size());
  if (!spec_.blocking) return;
  index_directions();
  has_direction_masks_ ? index_blockers_by_masks() : index_blockers_by_sets();
}

void Problem::index_directions() {
  const std::vector<BlockingDirection>& stated = spec_.blocking->directions;
  const std::string list = "blocking.directions";
  if (stated.empty())
    refuse(list, "at least one pair of directions is needed, or no part could ever leave another");
  std::vector<std::string> named;  // ids, sorted: they are numbered in this order
  for (const BlockingDirection& direction : stated) {
    if (direction.vector) named.push_back(direction.id);
  }
  if (named.size() + (stated.size() - named.size() + 1) / 2 > kMaxDirectionPairs)
    refuse(list, "more than " + std::to_string(kMaxDirectionPairs) +
                     " pairs of directions, the most a problem may have");
  std::ranges::sort(named);
  const std::size_t numbers = kAxes + 2 * named.size();
  has_direction_masks_ = numbers <= kMostInMask;
  direction_names_.assign(kDirectionNames.begin(), kDirectionNames.end());
  for (const std::string& id : named) {
    direction_names_.push_back(id);
    direction_names_.push_back("-" + id);
  }
  for (std::size_t d = kAxes; d < numbers; ++d)
    direction_by_name_.emplace(direction_names_[d], static_cast<DirectionIndex>(d));
  named_vectors_.resize(named.size());
  direction_bits_.assign((numbers + 63) / 64, 0);

  const auto take = [&](DirectionIndex direction, const std::string& place) {
    std::uint64_t& word = direction_bits_[direction / 64U];
    const std::uint64_t bit = std::uint64_t{1} << direction % 64U;
    if ((word & bit) != 0)
      refuse(place, in_quotes(direction_names_[direction]) + " is listed twice");
    word |= bit;
    directions_.push_back(direction);
  };
  for (std::size_t i = 0; i < stated.size(); ++i) {
    const std::string& id = stated[i].id;
    const std::string place = entry_of(list, i);
    const auto axis = axis_called(id);
    if (stated[i].vector) {
      require_direction_id(id, place + ".id");
      if (const auto fault = detail::id_fault(id)) refuse(place + ".id", *fault);
      const DirectionIndex direction = direction_by_name_.at(id);
      named_vectors_[(direction - kAxes) / 2] = unit_vector(*stated[i].vector, place);
      take(direction, place + ".id");
      take(opposite(direction), place + ".id");
    } else if (axis) {
      take(*axis, place);
    } else if (direction_by_name_.contains(id)) {
      refuse(place,
             in_quotes(id) + (id.starts_with('-')
                                  ? " is there already, as the opposite of " +
                                        in_quotes(std::string_view(id).substr(1)) + "; leave it out"
                                  : " is listed twice"));
    } else {
      const std::vector<std::string_view> axes(kDirectionNames.begin(), kDirectionNames.end());
      refuse(place, in_quotes(id) + " is not a direction; those without a vector are " +
                        detail::listed(axes, "and") + detail::suggestion(id, axes));
    }
  }
  for (DirectionIndex d = 0; d < kAxes; ++d) {
    if (find_direction(kDirectionNames[d]) && !find_direction(kDirectionNames[opposite(d)])) {
      refuse(list, in_quotes(kDirectionNames[d]) + " is listed without its opposite " +
                       in_quotes(kDirectionNames[opposite(d)]));
    }
  }
}

void Problem::index_blockers_by_masks() {
  for (std::size_t i = 0; i < spec_.blocking->blocked.size(); ++i) {
    DirectionMask mask = 0;
    const auto [part, by] = read_blocked(*this, part_by_id_, i, [&](DirectionIndex direction) {
      mask |= DirectionMask{1} << direction;
    });
    if (mask == 0) continue;
    blockers_[part].push_back({by, mask});
    blockers_[by].push_back({part, static_cast<DirectionMask>(opposites(mask))});
  }
  for (std::vector<Blocker>& blockers : blockers_) {
    std::ranges::sort(blockers, {}, &Blocker::by);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < blockers.size(); ++i) {
      if (kept > 0 && blockers[kept - 1].by == blockers[i].by) {
        blockers[kept - 1].directions |= blockers[i].directions;
      } else {
        blockers[kept++] = blockers[i];
      }
    }
    blockers.resize(kept);
    blockers.shrink_to_fit();
  }
}

// Entries of the same two parts add up, so their sets do, before they are given their numbers.
void Problem::index_blockers_by_sets() {
  const std::size_t words = direction_bits_.size();
  std::vector<std::uint64_t> set(words);
  DirectionSets stated(words);
  for (std::size_t i = 0; i < spec_.blocking->blocked.size(); ++i) {
    std::ranges::fill(set, 0);
    const auto [part, by] = read_blocked(*this, part_by_id_, i, [&](DirectionIndex direction) {
      set[direction / 64U] |= std::uint64_t{1} << direction % 64U;
    });
    if (std::ranges::all_of(set, [](std::uint64_t word) { return word == 0; })) continue;
    blockers_[part].push_back({by, stated.number_of(set)});
    std::ranges::transform(set, set.begin(), opposites);
    blockers_[by].push_back({part, stated.number_of(set)});
  }
  DirectionSets different(words);
  for (std::vector<Blocker>& blockers : blockers_) {
    std::ranges::sort(blockers, {}, &Blocker::by);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < blockers.size();) {
      const PartIndex by = blockers[i].by;
      std::ranges::fill(set, 0);
      for (; i < blockers.size() && blockers[i].by == by; ++i) {
        const auto more = stated[blockers[i].directions];
        for (std::size_t w = 0; w < words; ++w) set[w] |= more[w];
      }
      blockers[kept++] = {by, different.number_of(set)};
    }
    blockers.resize(kept);
    blockers.shrink_to_fit();
  }
  direction_sets_ = std::move(different).all();
  direction_sets_.shrink_to_fit();
}

}  // namespace orasp
