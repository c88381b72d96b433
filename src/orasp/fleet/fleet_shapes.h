#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "orasp/containers/growing_array.h"
#include "orasp/containers/state_table.h"
#include "orasp/fleet/fleet_expander.h"

namespace orasp {

/// Subassemblies up to symmetry: one shape stands for all that come apart alike.
///
/// Idea.       How a subassembly comes apart is told by which of its parts are joined, along which
///             directions, what blocks them and, where moved blocks have a greatest mass, what they
///             weigh. Two subassemblies that differ in the names of their parts and in how the axes
///             are named and turned (the 48 ways to map the axes to each other) take the same
///             steps. So a search need only know one of them. Where there is precedence, or travel
///             counts, every subassembly is a shape of its own.
/// Algorithm.  A code for each first part and way to turn the axes: the parts in the order in which
///             a breadth-first search along directions in turn meets them, with all their
///             neighbours by that order. The least code stands for the shape (as in the canonical
///             codes of polyominoes). First parts are only those of the rarest kind, by what is
///             near them. Codes are only made for two subassemblies whose colours agree.
/// Guarantee.  Sound: a code holds everything, so equal codes are equal shapes; codes are compared
///             in full. Not complete where a part has two neighbours in the same direction, where
///             many shapes have the same colours, or once hardly any were equal: equal shapes told
///             apart cost time alone.
/// Cost.       At most 48 * parts^2 a subassembly, once; 12 to 24 bytes each.
template <class Parts>
class FleetShapes {
 public:
  /// A number of a subassembly that stands for its shape.
  using Shape = std::uint32_t;

  /// Refers to the expander, which must outlive it.
  explicit FleetShapes(const FleetExpander<Parts>& expander);

  [[nodiscard]] Shape of(Parts piece);
  /// The subassembly that stands for a shape.
  [[nodiscard]] Parts piece(Shape shape) const { return from_words<Parts>(table_.key(shape)); }
  /// For each part of the subassembly that stands for the shape of `piece`: the part of `piece` in
  /// its place. Entries of other parts are left alone.
  void match(Parts piece, std::span<std::size_t> place);
  [[nodiscard]] std::uint64_t bytes() const {
    return table_.bytes() + shape_of_.bytes() + same_kind_.size() * kBytesOfEntry;
  }

 private:
  static constexpr std::size_t kNumKinds = 7;  ///< directions, and those that nothing parts
  static constexpr std::uint64_t kBytesOfEntry = 48;
  using Turn = std::array<std::uint8_t, 6>;  ///< the direction that becomes each

  void list_turns();
  /// The least code of `piece` to code_, its parts in that order to order_.
  void encode(Parts piece);
  std::uint64_t kind_of(Parts piece);
  [[nodiscard]] Parts rarest(Parts piece);
  bool encode_from(Parts piece, std::size_t first, const Turn& turn);

  const FleetExpander<Parts>& expander_;
  bool names_matter_;
  std::size_t num_parts_;
  std::vector<std::array<Parts, kNumKinds>> beside_;  ///< by the direction off them
  std::vector<std::uint32_t> weight_;                 ///< equal for parts of equal mass
  std::vector<Turn> turns_;
  detail::StateTable<kWordsOf<Parts>> table_;
  detail::GrowingArray<Shape> shape_of_;
  std::unordered_multimap<std::uint64_t, Shape> same_kind_;  ///< shapes by kind_of()

  std::uint64_t compared_ = 0;  ///< subassemblies looked at
  std::uint64_t alike_ = 0;     ///< of these, that were like one before

  std::vector<std::uint32_t> code_, trial_;
  std::vector<std::size_t> order_, trial_order_;
  std::vector<std::uint32_t> position_;
  std::vector<std::uint64_t> colour_, next_colour_;
};

}  // namespace orasp
