#include "orasp/model/detail/centroid_distances.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>

#include "orasp/model/tolerance.h"

namespace orasp::detail {
namespace {

double product(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Some points, seen from the depot.
class Points {
 public:
  explicit Points(std::vector<Vector3> points) : points_(std::move(points)) {}

  /// A lower bound on the distance of the mean of any `count` of them.
  [[nodiscard]] double least_mean(std::size_t count) {
    constexpr int kSteps = 64;
    constexpr double kNearEnough = 1e-9;
    Vector3 nearest = mean_along({0, 0, 0}, points_.size());
    double least = 0;
    for (int step = 0; step < kSteps; ++step) {
      const double length = std::sqrt(product(nearest, nearest));
      if (length == 0) break;
      const Vector3 corner = mean_along(nearest, count);
      least = std::max(least, product(nearest, corner) / length);
      if (length - least <= kNearEnough * length) break;
      // The point of the segment between the two that is nearest.
      const Vector3 way = {corner[0] - nearest[0], corner[1] - nearest[1], corner[2] - nearest[2]};
      const double squared = product(way, way);
      if (squared == 0) break;
      const double share = std::clamp(0.0 - product(nearest, way) / squared, 0.0, 1.0);
      for (std::size_t i = 0; i < 3; ++i) nearest[i] += share * way[i];
    }
    return least;
  }

 private:
  /// The mean of the `count` points that lie least far along `direction`.
  [[nodiscard]] Vector3 mean_along(const Vector3& direction, std::size_t count) {
    if (count < points_.size()) {
      std::nth_element(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(count),
                       points_.end(), [&](const Vector3& a, const Vector3& b) {
                         return product(a, direction) < product(b, direction);
                       });
    }
    Vector3 sum = {0, 0, 0};
    for (std::size_t p = 0; p < count; ++p) {
      for (std::size_t i = 0; i < 3; ++i) sum[i] += points_[p][i];
    }
    for (double& x : sum) x /= static_cast<double>(count);
    return sum;
  }

  std::vector<Vector3> points_;
};

}  // namespace

double CentroidDistances::least(std::size_t parts) const {
  std::call_once(worked_out_, [this] { work_out(); });
  return least_[std::min(parts, least_.size() - 1)];
}

double CentroidDistances::least_with(const Side& some, const Sets& sets) const {
  return least_cost_with(some, sets, [](std::size_t parts, double metres) {
    static_cast<void>(parts);
    return metres;
  });
}

double CentroidDistances::least_moment_with(const Side& some, const Sets& sets) const {
  return least_cost_with(some, sets, [](std::size_t parts, double metres) {
    return static_cast<double>(parts) * metres * metres;
  });
}

// Along each direction those that lie least far join one after the other. Both costs fall, and
// then rise, as they do.
template <class Cost>
double CentroidDistances::least_cost_with(const Side& some, const Sets& sets, Cost&& cost) const {
  if (some.parts() > sets.most) return kInfinity;
  std::call_once(worked_out_, [this] { work_out(); });
  const std::size_t parts = problem_.num_parts();
  std::array<std::uint64_t, (kMaxParts + 63) / 64> is_in;  // only the words in use are set
  std::fill_n(is_in.begin(), (parts + 63) / 64, std::uint64_t{0});
  some.for_each([&](PartIndex part) { is_in[part / 64] |= std::uint64_t{1} << (part % 64); });
  double greatest = 0;
  for (std::size_t d = 0; d < order_.size() && greatest < sets.enough; ++d) {
    const std::span<const double> along = std::span(along_).subspan(d * parts, parts);
    double sum = 0;
    some.for_each([&](PartIndex part) { sum += along[part]; });
    std::size_t count = some.parts();
    const auto cost_now = [&] {
      return cost(count, std::max(0.0, sum / static_cast<double>(count) - rounding_));
    };
    double lowest = count >= sets.least ? cost_now() : kInfinity;
    for (const PartIndex part : order_[d]) {
      if (count == sets.most || lowest <= greatest) break;
      if ((is_in[part / 64] >> (part % 64) & 1U) != 0) continue;
      sum += along[part];
      ++count;
      if (count < sets.least) continue;
      const double now = cost_now();
      if (now > lowest) break;
      lowest = now;
    }
    greatest = std::max(greatest, lowest);
  }
  return greatest;
}

void CentroidDistances::work_out_directions(std::span<const PartIndex> parts,
                                            std::span<const Vector3> points) const {
  std::vector<Vector3> directions;
  Vector3 middle = {0, 0, 0};
  for (const Vector3& point : points) {
    for (std::size_t i = 0; i < 3; ++i) middle[i] += point[i];
  }
  const double length = std::sqrt(product(middle, middle));
  if (length > 0)
    directions.push_back({middle[0] / length, middle[1] / length, middle[2] / length});
  while (directions.size() < kDirections) {
    // Spread evenly over the sphere, along a spiral.
    const auto number = static_cast<double>(directions.size());
    const double z = 1 - 2 * (number + 0.5) / kDirections;
    const double radius = std::sqrt(1 - z * z);
    const double angle = std::numbers::pi * (1 + std::sqrt(5.0)) * number;
    directions.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
  }
  // Those first that look where the parts are: they tell most.
  std::ranges::stable_sort(directions, std::ranges::greater(),
                           [&](const Vector3& direction) { return product(direction, middle); });
  along_.assign(kDirections * problem_.num_parts(), 0.0);
  for (std::size_t d = 0; d < kDirections; ++d) {
    const std::span<double> along =
        std::span(along_).subspan(d * problem_.num_parts(), problem_.num_parts());
    for (std::size_t i = 0; i < parts.size(); ++i)
      along[parts[i]] = product(directions[d], points[i]);
    std::vector<PartIndex>& order = order_.emplace_back(parts.begin(), parts.end());
    std::ranges::stable_sort(order, {}, [&](PartIndex part) { return along[part]; });
  }
}

void CentroidDistances::work_out() const {
  // More than sums and means of positions lose by rounding.
  constexpr double kRounding = 1e-11;
  constexpr std::size_t kEachUpTo = 16;
  std::vector<Vector3> points;
  std::vector<PartIndex> parts;
  double farthest = 0;
  for (PartIndex part = 0; part < problem_.num_parts(); ++part) {
    const std::optional<Vector3>& position = problem_.parts()[part].position;
    if (!position || problem_.in_base(part)) continue;
    const Vector3& x = *position;
    parts.push_back(part);
    points.push_back({x[0] - depot_[0], x[1] - depot_[1], x[2] - depot_[2]});
    for (std::size_t i = 0; i < 3; ++i)
      farthest = std::max({farthest, std::abs(x[i]), std::abs(depot_[i])});
  }
  least_.assign(points.size() + 1, 0.0);
  if (points.empty() || !std::isfinite(farthest * farthest * 3)) return;
  rounding_ = kRounding * farthest;
  work_out_directions(parts, points);
  least_[1] = kInfinity;
  for (const Vector3& point : points)
    least_[1] = std::min(least_[1], std::sqrt(product(point, point)));
  Points seen(std::move(points));
  double least = 0;
  std::size_t next = 2;
  for (std::size_t count = 2; count < least_.size(); ++count) {
    // The mean of more points is a mean of means of fewer.
    if (count == next) {
      least = std::max(least, seen.least_mean(count));
      next += count < kEachUpTo ? 1 : count / 4;
    }
    least_[count] = least;
  }
  for (double& metres : least_) metres = std::max(0.0, metres - rounding_);
}

}  // namespace orasp::detail
