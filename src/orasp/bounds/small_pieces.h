#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "orasp/model/transition_system.h"

namespace orasp {

struct ListingEffort;

/// Bounds what the cuts of a piece gain where the gain of a cut depends on what is moved, any
/// number of parts may move, and no cut gains more than 0.
///
/// Problem.    Under `time` and `travel` a large moved piece may have its centroid near the depot
///             and cost nearly nothing, so that only small pieces tell what a plan must cost.
/// Idea.       Up to K parts every connected piece S is listed with its exact value: V(S), the
///             greatest sum of gain(A, B) + V(A) + V(B) over its cuts (Bellman's recursion over
///             pieces; gains are those above what connections cost, see CutTrees). For larger ones
///             each part p has a price y(p), and
///
///                 V(S) <= sum over p in S of y(p),   if for all connected M of at most K parts
///                 V(M) + gain of moving M <= sum of y - r over M,  unless M holds a base part,
///                 V(M) <= sum of y over M + lent(M),               if 2 |M| > K,
///                 V(M) <= sum of y over M,                         if M holds a base part.
///
///             The reserves r(p) >= 0 say that of two sides with at most K parts each the one that
///             moves pays for itself, so that only the other one stays for nothing: lent(M) is the
///             least sum of r over a connected set of K + 1 - |M| parts that holds one next to M.
///             With all reserves 0 every M of more than half of K parts would stay for nothing. The
///             least prices are a linear program. Its penalty form is exact with a penalty of 1 for
///             each set, since no multiplier is greater than 1; subgradients find prices that are
///             nearly the least, and a repair makes them valid, whatever the reserves are.
/// Proof.      By induction over the parts of S > K. A cut moves A off B; both in the list or
///             larger. If both are in the list and B holds no base part, B is no smaller than A and
///             2 |B| > K. A is connected, holds a part next to B and has at least K + 1 - |B|
///             parts, so that it reserves lent(B) or more: what B falls short of by the second
///             condition, A has left by the first. If B is larger, A has V(A) + gain <= its prices
///             by the first condition; if B holds a base part, B has V(B) <= its prices by the
///             third, and V is at most the prices by induction for a side of more than K parts,
///             where the gain is at most 0. If both sides hold a base part, nothing moves and the
///             third condition covers both. So V(S) >= gain + V(A) + V(B) holds for the bound in
///             place of V, which makes it consistent.
/// Reference.  Subgradients: Held and Karp (1971), Mathematical Programming 1, 6-25.
/// Guarantee.  Never below what the cuts of a piece can gain. Precedence, blocking between pieces
///             and max_subassemblies only take cuts away. A listed piece that blocking or limits
///             leave no cut counts all its cuts: the searches find the dead end.
/// Cost.       K is the greatest, 12 at most, for which the sets are few enough to be listed: in
///             less than a tenth of a second, with kMostSets in some tenths, with kManySets in some
///             seconds. O(parts) a piece.
class SmallPieces {
 public:
  static constexpr std::size_t kMostListed = 12;
  /// At most so many sets are listed; where there is a second and some hundred MiB; and where there
  /// is more time.
  static constexpr std::size_t kFewSets = 30'000;
  static constexpr std::size_t kMostSets = 200'000;
  static constexpr std::size_t kManySets = 1'000'000;

  SmallPieces() = default;
  /// No cut may gain more than 0. Pieces of at most `most_listed` parts are listed.
  SmallPieces(Expander& expander, const Problem& problem, std::size_t most_listed,
              const ListingEffort& effort);

  [[nodiscard]] bool known() const { return largest_ > 0; }
  [[nodiscard]] double bound(std::span<const PartIndex> piece) const;
  /// Whether larger sets were too many to be listed.
  [[nodiscard]] bool more_could_be_listed() const { return cut_short_; }

 private:
  /// The parts of a set in rising order, each plus 1 and in 16 bits.
  using Key = std::array<std::uint64_t, 3>;
  static Key key_of(std::span<const PartIndex> sorted);

  /// Keys, each with a number from 0 in the order in which they came: open addressing.
  class KeyIndex {
   public:
    static constexpr std::uint32_t kAbsent = 0xffffffffU;
    struct Inserted {
      std::uint32_t number;
      bool is_new;
    };
    Inserted insert(const Key& key);
    [[nodiscard]] std::uint32_t find(const Key& key) const;
    /// Forgets all keys from the number `size` on.
    void shrink(std::size_t size);

   private:
    static std::size_t hash(const Key& key) {
      const std::uint64_t mixed =
          (key[0] ^ key[1] * 0x9E3779B97F4A7C15U ^ std::rotl(key[2], 29) * 0xC2B2AE3D27D4EB4FU) *
          0xD6E8FEB86659FD93U;
      return static_cast<std::size_t>(mixed ^ (mixed >> 32U));
    }
    void fill(std::size_t slots);

    std::vector<Key> keys_;
    /// A number plus 1; 0 where there is none. At most half full.
    std::vector<std::uint32_t> slots_;
  };

  std::size_t largest_ = 0;
  bool cut_short_ = false;
  KeyIndex listed_;
  /// By number: the value of each listed set.
  std::vector<double> values_;
  std::vector<double> prices_;

  class Lister;
};

/// How much a bound may do before it is first asked.
struct ListingEffort {
  std::size_t most_sets = SmallPieces::kFewSets;  ///< that SmallPieces lists
  /// Asked now and then, if there is one: where it says true, what is known by then is the bound.
  std::function<bool()> stop{};

  [[nodiscard]] bool is_over() const { return stop && stop(); }
};

}  // namespace orasp
