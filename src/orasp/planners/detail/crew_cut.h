#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

#include "orasp/planners/detail/crew.h"

namespace orasp::detail {

/// A stretch of the keys that all members of a crew hold, by place in their common order and among
/// this member's own.
struct CrewCut {
  std::uint64_t below = 0;  ///< so many keys of all members come before it
  std::uint64_t up_to = 0;  ///< so many come before it or are in it
  std::size_t begin = 0;    ///< the same of this member's own
  std::size_t end = 0;
};

/// Where the `wanted` least of all members' keys end: below < wanted <= up_to, and where wanted is
/// not up_to, all the keys of the stretch are equal. Each member holds key_of(0) <=
/// key_of(1) <= ... <= key_of(size - 1); there are `wanted` of them or more, and at least one is
/// wanted. The same on every member, however the keys lie on them.
///
/// Idea.   The range of the keys is split into 256 parts; all count together how many keys each
///         part holds, and the part in which the cut lies is split again.
/// Cost.   At most 9 exchanges of 2 KiB, each with 256 binary searches; the fewer, the closer the
///         keys lie together.
template <class KeyOf>
[[nodiscard]] CrewCut cut_of_all(Crew& crew, std::size_t size, KeyOf&& key_of,
                                 std::uint64_t wanted) {
  constexpr std::size_t kParts = 256;
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  std::array<std::uint64_t, 2> range = {kMost, 0};
  if (size > 0) range = {key_of(0), key_of(size - 1)};
  std::string mine(sizeof range, '\0');
  std::memcpy(mine.data(), range.data(), sizeof range);
  range = {kMost, 0};
  for (const std::string& told : crew.told_by_all(mine)) {
    std::array<std::uint64_t, 2> of_one{};
    std::memcpy(of_one.data(), told.data(), sizeof of_one);
    range = {std::min(range[0], of_one[0]), std::max(range[1], of_one[1])};
  }
  auto [least, greatest] = range;
  const auto first_above = [&](std::uint64_t key) {
    std::size_t begin = 0;
    std::size_t end = size;
    while (begin < end) {
      const std::size_t middle = begin + (end - begin) / 2;
      if (key_of(middle) <= key) {
        begin = middle + 1;
      } else {
        end = middle;
      }
    }
    return begin;
  };
  CrewCut cut;
  while (true) {
    const std::uint64_t step = (greatest - least) / kParts + 1;
    const std::size_t parts = static_cast<std::size_t>((greatest - least) / step) + 1;
    std::array<std::size_t, kParts + 1> ends{cut.begin};
    std::array<std::uint64_t, kParts> counts{};
    const auto last_of = [&](std::size_t part) {
      return part + 1 == parts ? greatest : least + part * step + (step - 1);
    };
    for (std::size_t part = 0; part < parts; ++part) {
      ends[part + 1] = first_above(last_of(part));
      counts[part] = ends[part + 1] - ends[part];
    }
    crew.take_sums(counts);
    std::size_t part = 0;
    while (cut.below + counts[part] < wanted) cut.below += counts[part++];
    cut.up_to = cut.below + counts[part];
    cut.begin = ends[part];
    cut.end = ends[part + 1];
    if (step == 1 || cut.up_to == wanted) return cut;
    greatest = last_of(part);
    least += part * step;
  }
}

}  // namespace orasp::detail
