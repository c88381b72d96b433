#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "orasp/bounds/packed_costs.h"
#include "orasp/model/transition_system.h"

namespace orasp {

struct ListingEffort;

/// What a cut gains at most that moves more than a number of parts; nothing is known where there
/// are no functions.
struct LargerMoves {
  /// What a cut into sides of so many parts gains at most that moves either.
  using GainBySizes = std::function<double(std::size_t smaller, std::size_t larger)>;

  /// Of cuts that move at most `most` parts. The system must outlive what is returned.
  [[nodiscard]] static LargerMoves of(const TransitionSystem& system, std::size_t most,
                                      GainBySizes by_sizes);

  std::function<double(std::size_t parts)> gain{};
  /// Where all of these are among those that move; what is at most `low_enough` need not be the
  /// least that is known.
  std::function<double(std::span<const PartIndex> moved, std::size_t parts, double low_enough)>
      gain_with{};
};

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
///                 V(S) <= sum over p in S of y(p) + f(S),
///             if for all connected M of at most K parts
///                 V(M) + gain of moving M <= sum of y - r over M,  unless M holds a base part,
///                 V(M) <= sum of y over M + lent(M) + f(M),        if 2 |M| > K,
///                 V(M) <= sum of y over M,                         if M holds a base part.
///
///             The reserves r(p) >= 0 say that of two sides with at most K parts each the one that
///             moves pays for itself, so that only the other one stays for nothing: lent(M) is the
///             least sum of r over a connected set of K + 1 - |M| parts that holds one next to M.
///             With all reserves 0 every M of more than half of K parts would stay for nothing.
///             And f(S) is the least that a cut costs which moves more than K parts, all of S among
///             them, but no more than some number: each piece of more than K parts but the first
///             comes off another in such a cut, and what stays of it in the end may owe that much.
///             f is 0 if S holds a base part, and never falls as S grows without one. Sets that
///             blocking never lets come off more than K parts (Partings) need not keep the first
///             condition. The least prices are a linear program. Its penalty form is exact with a
///             penalty of 1 for each set, since no multiplier is greater than 1; subgradients over
///             the conditions that are nearest to being broken find prices that are nearly the
///             least, and a repair makes them valid, whatever the reserves are.
/// Proof.      By induction over the parts of S > K. A cut moves A off B; both in the list or
///             larger. If both are in the list and B holds no base part, B is no smaller than A and
///             2 |B| > K. A is connected, holds a part next to B and has at least K + 1 - |B|
///             parts, so that it reserves lent(B) or more: what B falls short of by the second
///             condition, A has left by the first. If B is larger, A has V(A) + gain <= its prices
///             by the first condition; if B holds a base part, B has V(B) <= its prices by the
///             third. A side A of more than K parts that moves has its prices and f(A), by
///             induction, and the cut gains at most -f(A); what stays has at most f(S). If
///             both sides hold a base part, nothing moves and the third condition covers both. So
///             V(S) >= gain + V(A) + V(B) holds for the bound in place of V, which makes it
///             consistent.
/// Reference.  Subgradients: Held and Karp (1971), Mathematical Programming 1, 6-25.
/// Guarantee.  Never below what the cuts of a piece can gain. Precedence, blocking between pieces
///             and max_subassemblies only take cuts away. A listed piece that blocking or limits
///             leave no cut counts all its cuts: the searches find the dead end.
///             What stays has more than half of K parts: with an odd K no fewer than with K - 1,
///             and the prices that are found need not be closer: where larger sets are too many,
///             the closer prices of the two count.
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
  /// So many conditions on prices are kept for RaisedPrices.
  static constexpr std::size_t kMostNearRows = 4096;

  SmallPieces() = default;
  /// No cut may gain more than 0. Pieces of at most `most_listed` parts are listed.
  SmallPieces(const TransitionSystem& system, Expander& expander, std::size_t most_listed,
              const LargerMoves& larger, const ListingEffort& effort);

  [[nodiscard]] bool known() const { return largest_ > 0; }
  [[nodiscard]] double bound(std::span<const PartIndex> piece) const;
  /// Whether larger sets were too many to be listed.
  [[nodiscard]] bool more_could_be_listed() const { return cut_short_; }

  /// Whether the bound of a piece of so many parts is the sum of its prices.
  [[nodiscard]] bool priced(std::size_t parts) const { return known() && parts > largest_; }
  /// Conditions on prices, each with what is left of its room under those that were found: the
  /// ones that have least left, in rising order.
  [[nodiscard]] const std::vector<PriceRow>& near_rows() const { return near_rows_; }
  /// At least so much is left of the room of each of the others.
  [[nodiscard]] double left_beyond() const { return left_beyond_; }

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
    /// Without a call.
    static bool same(const Key& a, const Key& b) {
      return ((a[0] ^ b[0]) | (a[1] ^ b[1]) | (a[2] ^ b[2])) == 0;
    }
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
  /// f: what is said of cuts that move what is not listed, at most most_owed_.
  double gain_of_larger_ = 0;
  std::function<double(std::span<const PartIndex>, std::size_t, double)> gain_of_larger_with_;
  double most_owed_ = 0;
  std::vector<PriceRow> near_rows_;
  double left_beyond_ = 0;
  std::vector<bool> in_base_;  ///< by part; empty where none is

  /// f where so many parts are listed, and it is no more than `most`.
  [[nodiscard]] double owed(std::span<const PartIndex> piece, std::size_t listed,
                            double most) const;

  class Lister;
  void price(Lister& lister, std::size_t largest, const LargerMoves& larger,
             const ListingEffort& effort);
};

/// How much a bound may do before it is first asked.
struct ListingEffort {
  std::size_t most_sets = SmallPieces::kFewSets;            ///< that SmallPieces lists
  std::size_t most_near_rows = SmallPieces::kMostNearRows;  ///< that SmallPieces keeps
  /// Asked now and then, if there is one: where it says true, what is known by then is the bound.
  std::function<bool()> stop{};

  [[nodiscard]] bool is_over() const { return stop && stop(); }
};

}  // namespace orasp
