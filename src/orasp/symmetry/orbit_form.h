#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "orasp/symmetry/automorphisms.h"

namespace orasp {

/// Takes sets to one set of their orbit under a group of permutations, always the same.
///
/// Idea.       Generators that move points in common belong together; the others act on their own.
///             Where some of them exchange whole blocks of points, pair by pair, and all others
///             stay within a block, the group is that of the blocks in any order, each with a group
///             of its own inside: each block is brought to its form first, and then the blocks are
///             sorted. Of a small group of another kind (turns and reflections of a ring or a grid)
///             all elements are listed, and the least image is taken. Where every generator of one
///             kind commutes with every generator of the other (rows and columns that may each be
///             put in any order), the least is taken of what sorting makes of the images. What is
///             none of these is left out, generator by generator, so that the group may be smaller
///             than what was given; every group is right, and a smaller one saves less.
/// Reference.  Jefferson, Jonauskyte, Pfeiffer and Waldecker (2019), Minimal and canonical images,
///             J. Algebra 521, 481-506, of such forms for groups in general; sorting equal blocks
///             is folklore.
/// Guarantee.  Two sets get the same form if and only if an element of the group takes one to the
///             other.
/// Cost.       O(points of all blocks) a set where blocks are sorted, O(elements * a few) where
///             elements are listed. A copy for each thread.
class OrbitForm {
 public:
  OrbitForm() = default;
  /// For sets over `points` points.
  OrbitForm(std::size_t points, std::vector<Permutation> generators);

  /// Whether nothing is moved.
  [[nodiscard]] bool trivial() const { return steps_.empty(); }
  /// The number of elements of the group is the product of these, each 2 or more.
  [[nodiscard]] const std::vector<std::uint64_t>& order() const { return order_; }
  /// How many times fewer forms than sets there are: the number of orbits, by counting them block
  /// by block (multisets of what a block may be) and by Burnside's lemma. Of large groups that sort
  /// and list on the same points a bound from above.
  [[nodiscard]] double saving() const { return saving_; }
  /// Brings a set to its form; `words` are its words.
  void canonical(std::span<std::uint64_t> words);
  /// The same for a set that is a form but for `point`: nothing is done where no element moves that
  /// point, and only the blocks are looked at that hold it.
  void canonical_but_for(std::size_t point, std::span<std::uint64_t> words);

 private:
  /// Either `count` blocks that are sorted, whose points stand block by block in `points`, or
  /// `count` permutations, of places in `points`, that stand one after another in `elements`, the
  /// one that moves nothing first. After each of these `then` is done, if there is something,
  /// before images are compared.
  struct Step {
    bool sorts = true;
    std::size_t count = 0;
    std::vector<std::uint16_t> points{};
    std::vector<std::uint16_t> elements{};
    std::vector<Step> then{};
  };
  struct Plan {
    std::vector<Step> steps{};
    std::vector<std::uint64_t> order{};
    std::size_t moved = 0;  ///< points
    /// The natural logarithm of the number of orbits of the sets of these points.
    double log_orbits = 0;
  };
  class Recogniser;
  void apply(const Step& step, std::span<std::uint64_t> words);
  void sort_points(const Step& step, std::span<std::uint64_t> words);
  void sort_blocks(const Step& step, std::span<std::uint64_t> words);
  void sort_long_blocks(const Step& step, std::span<std::uint64_t> words);
  void take_least(const Step& step, std::span<std::uint64_t> words);
  void take_least_sorted(const Step& step, std::span<std::uint64_t> words);

  std::vector<Step> steps_;
  std::vector<std::uint64_t> order_;
  double saving_ = 1;
  /// By point: the steps that look at it, in order.
  std::vector<std::vector<std::uint16_t>> steps_of_;
  // Scratch.
  std::vector<std::uint64_t> patterns_;
  std::vector<std::vector<std::uint64_t>> long_patterns_;
  std::vector<unsigned char> bits_;
  std::vector<std::uint64_t> image_;
  std::vector<std::uint64_t> least_;
};

}  // namespace orasp
