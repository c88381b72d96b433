#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "orasp/certificate/detail/attempts.h"
#include "orasp/model/problem.h"

namespace orasp::detail {

/// What steps earn where a cut is told by the sizes of its two pieces: the sentences of
/// docs/format.md about `piece_cost`, `cubesat`, `custom`, `cubesat_zone`, `completion`, `time`
/// where no part has a position, `fuel` where all parts weigh the same, and weighted sums of these,
/// read once more for certificates.
///
///     a step that does not complete earns  own(c) + (cut(a, b) if it separates),
///     the one that completes earns         last(c, separates, a, b).
///
/// Each of the three is rounded up, and the greatest where several values are possible. Where
/// attempts are made again until they succeed, each is what all attempts earn together on average;
/// of a cut, at whatever connection it happens.
class SizeRewards {
 public:
  /// With `prices` the propellant of `fuel` is left out, and told by prices of parts instead: then
  /// parts may weigh what they like.
  explicit SizeRewards(const Problem& problem, bool prices = false);

  /// Whether the objective is one of those above.
  [[nodiscard]] bool known() const { return known_; }
  [[nodiscard]] double own(ConnectionIndex connection) const;
  [[nodiscard]] double cut(std::size_t a, std::size_t b) const {
    return all_together(one_cut(a, b), attempts_);
  }
  /// The same at a connection that is tried so often.
  [[nodiscard]] double cut(std::size_t a, std::size_t b, const Attempts& attempts) const {
    return all_together(one_cut(a, b), attempts);
  }
  [[nodiscard]] double last(ConnectionIndex connection, bool separates, std::size_t a,
                            std::size_t b) const;
  /// What was left out, of a cut that moves `part`, with whatever else: at most this. What moves
  /// weighs at least as much as the part, and more propellant is burnt for more mass.
  [[nodiscard]] double price(PartIndex part) const;
  /// What was left out, of all that a group of parts weighs but the heaviest of them, where a cut
  /// moves the group: at most this, beyond the fixed amount of each cut.
  [[nodiscard]] double price_of_group(std::span<const PartIndex> group) const;
  /// Whether anything was left out.
  [[nodiscard]] bool priced() const { return !priced_.empty(); }

 private:
  struct Addend {
    double weight;
    const ObjectiveParameters* parameters;
  };
  void add(const Objective& objective, double weight);
  [[nodiscard]] double one_cut(std::size_t a, std::size_t b) const;
  [[nodiscard]] double zone_cut(double weight, std::size_t a, std::size_t b) const;
  [[nodiscard]] static double propellant(double weight, const Fuel& fuel, double mass);
  [[nodiscard]] double transfer(double weight, double seconds) const;
  [[nodiscard]] double fuel_cut(double weight, const Fuel& fuel, std::size_t a,
                                std::size_t b) const;

  const Problem& problem_;
  bool known_ = true;
  bool prices_;
  std::vector<Addend> addends_;
  std::vector<Addend> priced_;
  Attempts attempts_;         ///< at any connection that joins two parts
  std::vector<bool> starts_;  ///< by size: whether the whole product has a piece of that many parts
  std::size_t largest_ = 0;   ///< of its pieces
  bool some_fixed_ = false;   ///< a base part decides which side moves
  bool some_stay_ = false;    ///< a cut may move nothing, since there are several base parts
};

/// The numbers of parts of the pieces that `present` leaves, single parts among them.
[[nodiscard]] std::vector<std::size_t> piece_sizes(const Problem& problem,
                                                   const ConnectionSet& present);

}  // namespace orasp::detail
