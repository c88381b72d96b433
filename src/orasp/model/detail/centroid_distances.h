#pragma once

#include <cstddef>
#include <mutex>
#include <span>
#include <vector>

#include "orasp/model/detail/connectivity.h"
#include "orasp/model/problem.h"
#include "orasp/model/vector3.h"

namespace orasp::detail {

/// How near to a point the centroid of so many parts can be, whichever they are.
///
/// Problem.    Where a large piece that moves may have its centroid at the depot, moving it costs
///             nothing. In a product that stands beside the depot it cannot: each part is metres
///             away, and so is their mean.
/// Idea.       The means of k parts span a polytope; its point nearest to the depot is nearer than
///             the centroid of any k parts. For any direction u, a unit vector, that point is at
///             least as far away as the mean of the k least values of u * (position - depot), so
///             that each step of the search gives a bound that holds, however far it has come.
/// Reference.  Gilbert (1966), An iterative procedure for computing the minimum of a quadratic form
///             on a convex set, SIAM J. Control 4(1), 61-80.
/// Guarantee.  Never above the true distance. From two parts on it does not fall as they become
///             more.
///             With some parts given, what is said of a set of parts is no more than what is said
///             of a larger one.
/// Cost.       Once, when first asked: about 40 numbers of parts, 64 steps each, O(parts) a step;
///             between two of those numbers the smaller one answers. With some parts given there
///             are kDirections directions, always the same ones, each O(most parts).
class CentroidDistances {
 public:
  static constexpr std::size_t kDirections = 32;

  CentroidDistances(const Problem& problem, const Vector3& depot)
      : problem_(problem), depot_(depot) {}

  /// Metres, of so many parts that have positions and may move; 0 where no part does. Several
  /// threads may ask.
  [[nodiscard]] double least(std::size_t parts) const;
  /// Sets of at least `least` and at most `most` parts. What is at least `enough` need not be the
  /// greatest that is known.
  struct Sets {
    std::size_t least;
    std::size_t most;
    double enough;
  };
  /// The same of such sets that hold all of `some`, which are not fixed and have positions;
  /// infinite where no set of parts is so large.
  [[nodiscard]] double least_with(const Side& some, const Sets& sets) const;
  /// The least that the number of parts is, times the square of that distance, in m^2.
  [[nodiscard]] double least_moment_with(const Side& some, const Sets& sets) const;

 private:
  void work_out() const;
  void work_out_directions(std::span<const PartIndex> parts, std::span<const Vector3> points) const;
  template <class Cost>
  [[nodiscard]] double least_cost_with(const Side& some, const Sets& sets, Cost&& cost) const;

  const Problem& problem_;
  Vector3 depot_;
  mutable std::once_flag worked_out_;
  mutable std::vector<double> least_;  ///< by number of parts
  mutable double rounding_ = 0;        ///< m, that a mean of positions may be off
  /// By direction and part: how far it lies in that direction from the depot.
  mutable std::vector<double> along_;
  /// By direction: the parts that may move and have positions, those that lie least far first.
  mutable std::vector<std::vector<PartIndex>> order_;
};

}  // namespace orasp::detail
