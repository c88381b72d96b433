#pragma once

#include <cstddef>
#include <vector>

#include "orasp/model/detail/checked_reward.h"
#include "orasp/model/problem.h"

namespace orasp::detail {

/// What steps earn where the connection and its place in the order tell all of it: `indexed`,
/// formulas of `index`, `before`, `after`, `duration`, `completes` and the connection's own
/// numbers, and weighted sums of these, read once more for certificates.
///
/// The place of a connection is how many were removed before it; an assembly is looked at
/// backwards. Whatever the order, all that `after` wants gone before a connection is, and what
/// waits for it is not. Rewards come from the formula by which plans are checked (CheckedReward).
class PlaceRewards {
 public:
  /// @throws InputError as CheckedReward.
  explicit PlaceRewards(const Problem& problem);

  /// Whether the objective is one of those above.
  [[nodiscard]] bool known() const { return known_; }
  /// Whether precedence leaves that place to the connection.
  [[nodiscard]] bool possible(ConnectionIndex connection, std::size_t place) const {
    return place >= before_[connection] && place < problem_.num_connections() - behind_[connection];
  }
  /// The most that the step earns, with all attempts that it takes on average, rounded up. Infinite
  /// where a formula yields no number.
  [[nodiscard]] double most(ConnectionIndex connection, std::size_t place) const;

 private:
  void count_what_waits();

  const Problem& problem_;
  bool known_;
  CheckedReward rewards_;
  std::vector<std::size_t> before_;  ///< by connection: how many are removed before it for certain
  std::vector<std::size_t> behind_;  ///< and behind it
};

/// The most connections of a problem whose places are looked at.
inline constexpr std::size_t kMostCertifiedPlaces = 1'000;

/// Prices of connections and of places that together are least, as far as rounding goes: each
/// connection and each place that is possible for it cost at least what the step earns.
/// Idea.      The dual of the assignment that earns most, by shortest augmenting paths.
/// Guarantee. None: whether they prove anything is for check_certificate() to say.
/// Cost.      O(connections^3).
/// Reference. Kuhn (1955), The Hungarian method for the assignment problem, Naval Research
///            Logistics Quarterly 2, 83-97; Jonker and Volgenant (1987), Computing 38, 325-340.
struct PlaceProof {
  std::vector<double> connections{};  ///< empty where no order gives each connection a place
  std::vector<double> places{};
};
[[nodiscard]] PlaceProof prove_by_places(const PlaceRewards& rewards, std::size_t connections);

}  // namespace orasp::detail
