#include "shared/mesh/disc_patch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/not_finite.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

SurfaceMesh Box(double size) {
  return SurfaceOf(MeshBox({size, size, size}, {4, 4, 4}));
}

Vector3d Point(const SurfaceMesh& s, const SurfacePlace& place) {
  Vector3d p = Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const int node =
        s.triangles[static_cast<std::size_t>(place.triangle)][static_cast<std::size_t>(i)];
    p += place.weights[i] * s.nodes[static_cast<std::size_t>(node)];
  }
  return p;
}

// Distance to a triangle by sampling it: an upper bound that falls to the distance itself.
double SampledDistance(const SurfaceMesh& s, std::size_t triangle, const Vector3d& p) {
  const auto& [a, b, c] = s.triangles[triangle];
  const auto at = [&](int i) { return s.nodes[static_cast<std::size_t>(i)]; };
  constexpr int kSteps = 60;
  double least = kInf;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; i + j <= kSteps; ++j) {
      const double u = double(i) / kSteps, v = double(j) / kSteps;
      least = std::min(least, (at(a) + u * (at(b) - at(a)) + v * (at(c) - at(a)) - p).norm());
    }
  }
  return least;
}

TEST(FindPlaceTest, FindsEveryNodeAndCentroidAtEverySize) {
  for (const double size : {1e-9, 0.06, 1e3}) {
    const SurfaceMesh s = Box(size);
    for (int t = 0; t < static_cast<int>(s.triangles.size()); ++t) {
      const auto place = FindPlace(s, Centroid(s, t));
      ASSERT_TRUE(place) << t;
      EXPECT_EQ(place->triangle, t);
      EXPECT_EQ(place->node, -1);
      EXPECT_LE((place->weights - Vector3d::Constant(1.0 / 3)).norm(), 1e-9);
      EXPECT_LE(place->distance, 1e-15 * size);
    }
    for (int i = 0; i < static_cast<int>(s.nodes.size()); ++i) {
      // 1e-7 of the diagonal: the rounding error of a coordinate in a text file.
      const Vector3d p = s.nodes[static_cast<std::size_t>(i)] + Vector3d(1, -1, 1) * 1e-7 * size;
      const auto place = FindPlace(s, p);
      ASSERT_TRUE(place) << i;
      EXPECT_EQ(place->node, i);  // inner ones too
    }
  }
}

// Reference: sampling the triangles, spacing 1/60 of an edge.
TEST(FindPlaceTest, FindsTheNearestPointOfTheSurface) {
  const SurfaceMesh s = SurfaceOf(MeshBox({1, 0.7, 0.4}, {3, 2, 1}));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-0.1, 1.1);
  int found = 0;
  for (int k = 0; k < 60; ++k) {
    const Vector3d p(uniform(random), 0.7 * uniform(random), 0.4 * uniform(random));
    const auto place = FindPlace(s, p);
    double least = kInf;
    for (std::size_t t = 0; t < s.triangles.size(); ++t)
      least = std::min(least, SampledDistance(s, t, p));
    if (!place) continue;
    ++found;
    EXPECT_LE(place->distance, least + 1e-12);
    EXPECT_GE(place->distance, least - 0.01);
    EXPECT_NEAR((Point(s, *place) - p).norm(), place->distance, 1e-14);
    EXPECT_GE(place->weights.minCoeff(), 0);
    EXPECT_NEAR(place->weights.sum(), 1, 1e-14);
  }
  EXPECT_GT(found, 40);
}

// Reference: slave/solve/README.md, of equally near ones the larger index.
TEST(FindPlaceTest, GivesAnEdgeToTheTriangleWithTheLargerIndex) {
  const SurfaceMesh s = Box(1);
  for (int t = 0; t < static_cast<int>(s.triangles.size()); ++t) {
    const auto& [a, b, c] = s.triangles[static_cast<std::size_t>(t)];
    const Vector3d middle =
        0.5 * (s.nodes[static_cast<std::size_t>(a)] + s.nodes[static_cast<std::size_t>(b)]);
    const auto place = FindPlace(s, middle);
    ASSERT_TRUE(place);
    int largest = -1;
    for (int o = 0; o < static_cast<int>(s.triangles.size()); ++o) {
      const auto& other = s.triangles[static_cast<std::size_t>(o)];
      const bool shares = std::ranges::count(other, a) > 0 && std::ranges::count(other, b) > 0;
      if (shares) largest = o;
    }
    EXPECT_EQ(place->triangle, largest) << t;
    (void)c;
  }
}

TEST(FindPlaceTest, RefusesWhatIsFarOrNotFinite) {
  const SurfaceMesh s = Box(1);  // longest edge of a triangle: sqrt(2) / 4
  EXPECT_TRUE(FindPlace(s, {0.6, 0.55, 1 + 0.17}));
  EXPECT_FALSE(FindPlace(s, {0.6, 0.55, 1 + 0.18}));
  EXPECT_FALSE(FindPlace(s, {0.6, kInf, 1}));
  EXPECT_FALSE(FindPlace(s, {0.6, std::nan(""), 1}));
  EXPECT_FALSE(FindPlace(SurfaceMesh{}, {0, 0, 0}));
}

// Reference: the rule, applied to a mesh whose top face is z = 1. Tolerances 1e-9 relative.
TEST(PatchAtTest, HasTheCentroidsAndNodesInTheDiscOnItsSideOnly) {
  const SurfaceMesh s = SurfaceOf(MeshBox({1, 1, 0.05}, {8, 8, 1}));
  const Vector3d p(0.52, 0.47, 0.05);
  for (const double width : {0.11, 0.25, 0.5, 0.9}) {
    const DiscPatch patch = PatchAt(s, *FindPlace(s, p), p, width);
    std::vector<int> triangles, nodes;
    for (int t = 0; t < static_cast<int>(s.triangles.size()); ++t) {
      if (Normal(s, t).z() > 0.5 && (Centroid(s, t) - p).norm() <= width / 2)
        triangles.push_back(t);
    }
    for (int i = 0; i < static_cast<int>(s.nodes.size()); ++i) {
      const Vector3d& q = s.nodes[static_cast<std::size_t>(i)];
      if (q.z() == 0.05 && (q - p).norm() <= width / 2) nodes.push_back(i);
    }
    ASSERT_FALSE(triangles.empty());
    EXPECT_EQ(patch.triangles, triangles) << width;
    EXPECT_EQ(patch.nodes, nodes) << width;
  }
}

TEST(PatchAtTest, IncludesItsEdgeAtEverySize) {
  for (const double size : {1e-9, 0.06, 1e3}) {
    const SurfaceMesh s = Box(size);
    const Vector3d p(0.5 * size, 0.5 * size, size);
    const auto with = PatchAt(s, *FindPlace(s, p), p, 0.5 * size);  // four nodes at a quarter
    EXPECT_EQ(with.nodes.size(), 5U) << size;
    const auto without = PatchAt(s, *FindPlace(s, p), p, 0.5 * size * (1 - 1e-6));
    EXPECT_EQ(without.nodes.size(), 1U) << size;
  }
}

// Reference: the disc's area and circumference, less the segment that a side of the box cuts off;
// all of the side where the disc is wider. 1e-8: the radius has a slack of 1e-9.
TEST(PatchAtTest, ReturnsThePartOfTheDiscOnTheSurface) {
  const SurfaceMesh box = SurfaceOf(MeshBox({2, 2, 1}, {5, 4, 2}));
  const auto disc = [&](const Vector3d& p, double radius) {
    return PatchAt(box, *FindPlace(box, p), p, 2 * radius).disc;
  };
  const double pi = std::numbers::pi;
  for (const double r : {0.01, 0.2, 0.7}) {
    for (const double from_side : {0.05, 0.11, 0.83, 1.0}) {
      const Vector3d p(1, from_side, 1);
      const double half = from_side < r ? std::acos(from_side / r) : 0;  // of the arc beyond
      const double beyond = r * r * half - from_side * r * std::sin(half);
      EXPECT_NEAR(disc(p, r).area / (pi * r * r - beyond), 1, 1e-8) << r << " " << from_side;
      EXPECT_NEAR(disc(p, r).rim / (2 * (pi - half)), 1, 1e-8) << r << " " << from_side;
    }
  }
  EXPECT_NEAR(disc({1, 1, 1}, 3).area, 4, 1e-12);
  EXPECT_NEAR(disc({1, 1, 1}, 3).rim, 0, 1e-12);
}

}  // namespace
}  // namespace palpate
