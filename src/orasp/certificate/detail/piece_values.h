#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "orasp/certificate/certificate.h"
#include "orasp/certificate/detail/size_rewards.h"
#include "orasp/model/problem.h"

namespace orasp::detail {

/// What the cuts of a piece gain at most, by what a certificate of the kinds Sizes and Pieces
/// lists: by the piece itself, where it is listed, and by its number of parts.
///
/// A piece may be so many subassemblies at a time (`allowed`). Two sides of a cut that have two
/// parts or more are each at least one until they have come apart. While one of them is as many as
/// are allowed to both, the other is gone; so the other was never more than one less. A piece of n
/// parts gains nothing from more than floor(log2 n): of two sides the smaller one has n/2 parts at
/// most, and may be the one with less.
class PieceValues {
 public:
  using Parts = std::span<const PartIndex>;
  using Key = std::u16string;

  PieceValues(const Problem& problem, const SizeRewards& rewards, const std::vector<double>& sizes);

  /// Whether max_subassemblies is stated.
  [[nodiscard]] bool limited() const { return limited_; }
  /// What is allowed to a piece of the whole product.
  [[nodiscard]] std::size_t allowed() const { return allowed_; }
  /// `allowed` as far as a piece of so many parts makes use of it: 0 where there is no limit.
  [[nodiscard]] std::size_t useful(std::size_t allowed, std::size_t parts) const;
  [[nodiscard]] Key key(Parts parts, std::size_t allowed) const;
  /// States the value of a piece; the first one stays.
  void list(Parts parts, std::size_t allowed, double value);
  [[nodiscard]] double by_size(std::size_t parts) const { return sizes_[parts]; }
  [[nodiscard]] double of(Parts parts, std::size_t allowed) const;

  /// What is allowed to each of the two sides of a cut: the choices, one or two, or none where the
  /// cut is not possible.
  struct Halves {
    std::size_t a;
    std::size_t b;
  };
  [[nodiscard]] std::vector<Halves> halves(std::size_t a, std::size_t b, std::size_t allowed) const;
  /// What two sides gain together, at most, rounded up; -infinity where they cannot be.
  [[nodiscard]] double of_both(Parts a, Parts b, std::size_t allowed) const;
  /// What a cut into so many parts gains itself, whichever side the first part is on.
  [[nodiscard]] double cut(std::size_t a, std::size_t b) const;
  /// The same of a cut into these: it happens at a connection that joins the two.
  [[nodiscard]] double cut(Parts a, Parts b) const;
  /// By the smaller number of parts: whether a cut of `parts` parts into so many is worth more than
  /// `value` by sizes.
  [[nodiscard]] std::vector<bool> sizes_above(std::size_t parts, double value) const;

 private:
  const Problem& problem_;
  const SizeRewards& rewards_;
  const std::vector<double>& sizes_;
  /// By part; nothing where all attempts succeed.
  std::vector<std::vector<ConnectionIndex>> around_;
  bool limited_;
  std::size_t allowed_;
  std::unordered_map<Key, double> listed_;
};

}  // namespace orasp::detail
