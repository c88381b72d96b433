#include "orasp/geometry/mesh.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/geometry/shapes.h"

namespace orasp {
namespace {

using shapes::block;

TEST(Measure, TellsTheSizesOfABlock) {
  const MeshMeasure m = measure(block({1, 2, 3}, {3, 5, 7}));
  EXPECT_NEAR(m.volume, 2 * 3 * 4, 1e-12);
  EXPECT_NEAR(m.area, 2 * (2 * 3 + 3 * 4 + 2 * 4), 1e-12);
  EXPECT_NEAR(m.centroid[0], 2, 1e-12);
  EXPECT_NEAR(m.centroid[1], 3.5, 1e-12);
  EXPECT_NEAR(m.centroid[2], 5, 1e-12);
  EXPECT_NEAR(m.box.diagonal(), std::sqrt(4.0 + 9 + 16), 1e-12);
  EXPECT_TRUE(m.closed);
}

TEST(Measure, LosesNothingFarFromTheOrigin) {
  const MeshMeasure m = measure(shapes::shifted(block({0, 0, 0}, {1, 1, 1}), {1e7, -1e7, 1e7}));
  EXPECT_NEAR(m.volume, 1, 1e-7);
  EXPECT_NEAR(m.centroid[1], 0.5 - 1e7, 1e-7);
}

TEST(Measure, FindsTheVolumeOfATubeOfManySides) {
  // A regular polygon of n corners on a circle of radius r covers n r^2 sin(2 pi / n) / 2.
  const double share = 400 * std::sin(2 * std::numbers::pi / 400) / 2;
  const MeshMeasure m = measure(shapes::tube(3, 5, 0, 2, 400));
  EXPECT_NEAR(m.volume, share * (25 - 9) * 2, 1e-9);
  EXPECT_TRUE(m.closed);
}

TEST(Measure, SeesThatAFaceIsMissing) {
  Mesh mesh = block({0, 0, 0}, {1, 1, 1});
  mesh.triangles.pop_back();
  EXPECT_FALSE(measure(mesh).closed);
}

TEST(Measure, SeesThatTrianglesOfOwnCornersCloseASurface) {
  Mesh apart;
  const Mesh mesh = block({0, 0, 0}, {1, 2, 3});
  for (const auto& t : mesh.triangles) {
    const auto base = static_cast<std::uint32_t>(apart.vertices.size());
    for (const std::uint32_t v : t) apart.vertices.push_back(mesh.vertices[v]);
    apart.triangles.push_back({base, base + 1, base + 2});
  }
  EXPECT_TRUE(measure(apart).closed);
  apart.vertices[0][0] += 1e-9;  // as another program rounds
  EXPECT_TRUE(measure(apart).closed);
  apart.vertices[0][0] += 0.1;
  EXPECT_FALSE(measure(apart).closed);
}

TEST(Measure, TakesAMeshThatIsInsideOut) {
  Mesh mesh = block({0, 0, 0}, {1, 2, 3});
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_NEAR(measure(mesh).volume, 6, 1e-12);
  EXPECT_NEAR(measure(mesh).centroid[2], 1.5, 1e-12);
}

TEST(Measure, OfNothingIsNothing) {
  const MeshMeasure m = measure(Mesh{});
  EXPECT_EQ(m.volume, 0);
  EXPECT_EQ(m.box.diagonal(), 0);
  EXPECT_FALSE(m.closed);
}

TEST(Measure, TakesTrianglesWithoutArea) {
  Mesh mesh;
  mesh.vertices = {{1, 1, 1}, {1, 1, 1}, {2, 1, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 0, 0}};
  const MeshMeasure m = measure(mesh);
  EXPECT_EQ(m.area, 0);
  EXPECT_TRUE(std::isfinite(m.centroid[0]));
}

}  // namespace
}  // namespace orasp
