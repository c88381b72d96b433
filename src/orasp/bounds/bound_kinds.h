#pragma once

#include <array>
#include <memory>
#include <string_view>

#include "orasp/bounds/bound.h"
#include "orasp/bounds/place_prices.h"
#include "orasp/model/transition_system.h"

namespace orasp {

/// The bounds that a search may be told to use.
///
/// None: the paper's, the most that the last step can earn. It is known where no other step earns
/// more than 0, as the paper assumes. Connections: ConnectionBound. Sizes and Parts: PieceBound.
/// Best: the strongest cheap one, for each piece the better of sizes and parts where the objective
/// sees the piece only, PlaceBound where it depends on when a step comes, their sum where it is a
/// sum of both, else connections.
enum class BoundKind { None, Connections, Sizes, Parts, Best };
inline constexpr std::array<std::string_view, 5> kBoundNames = {"none", "connections", "sizes",
                                                                "parts", "best"};
/// @throws InputError that names the known ones.
[[nodiscard]] BoundKind bound_called(std::string_view name);

/// A bound of that kind. It may turn out to know nothing about the problem (Bound::known). `like`
/// is another of the same kind and system, or null: what took long to work out is shared with it.
[[nodiscard]] std::unique_ptr<Bound> make_bound(const TransitionSystem& system, BoundKind kind,
                                                const Bound* like = nullptr);

/// What is known of a start whose rewards depend on when steps come.
struct StartByPlaces {
  /// The most that any plan earns; infinite where nothing is known.
  double most;
  /// Null where nothing is known.
  std::shared_ptr<const PlacePrices> prices{};
};
/// Of a bound that make_bound made.
[[nodiscard]] StartByPlaces start_by_places(const Bound& bound);

}  // namespace orasp
