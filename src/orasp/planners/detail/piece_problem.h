#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "orasp/bounds/piece_gains.h"
#include "orasp/bounds/raised_prices.h"
#include "orasp/model/detail/connectivity.h"
#include "orasp/model/transition_system.h"

namespace orasp::detail {

/// Where the first step completes (TransitionSystem::completes_first): the legal first steps, and
/// how much more each earns because it completes.
struct FirstSteps {
  struct Cut {
    ConnectionIndex connection;
    double surplus;
    double gain;               ///< of the cut itself
    std::vector<PartIndex> a;  ///< the side of its first part
  };
  double most = -kInfinity;  ///< the greatest surplus of all
  /// Of the steps that separate nothing: the greatest surplus, and those that have it.
  double most_without_cut = -kInfinity;
  std::vector<ConnectionIndex> without_cut;
  std::vector<Cut> cuts;
};

/// Where the last step completes, and how much more it then earns depends on which connection it
/// takes: where attempts are repeated until they succeed, or by a formula.
struct LastSteps {
  std::vector<double> surplus;        ///< by connection; the greatest is gains.last_surplus()
  double most_of_loops = -kInfinity;  ///< the greatest of the connections of a part with itself
};

/// What all searches of one problem share; none of them changes it.
struct PieceProblem {
  /// With `the_gains` of the system, or null where they are not known yet.
  PieceProblem(const TransitionSystem& the_system, std::shared_ptr<const PieceGains> the_gains);

  const TransitionSystem& system;
  std::shared_ptr<const PieceGains> shared_gains;
  const PieceGains& gains;
  AssemblyGraph graph;
  std::optional<FirstSteps> first;
  std::optional<LastSteps> last;
  std::optional<RaisedPrices> raised;  ///< where the bound of pieces is by prices
  /// The most parts of a core (AndOrSearch::find_cores).
  std::size_t most_core_parts = 6;
  /// Pieces are swept once so many were expanded one by one (AndOrSearch::sweep).
  std::uint64_t sweep_from = 4'000;
};

}  // namespace orasp::detail
