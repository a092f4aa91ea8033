#include "slave/contact/surface_contact.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "slave/mesh/mesh_check.h"
#include "tests/support/allocation_count.h"
#include "tests/support/not_finite.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

Vector3d RandomProbe(std::mt19937* random, double reach) {
  std::uniform_real_distribution<double> coordinate(-reach, reach);
  const double x = coordinate(*random), y = coordinate(*random);
  return {x, y, coordinate(*random)};
}

struct Body {
  std::string name;
  SurfaceMesh surface;
};

SurfaceMesh Box(const Vector3d& size, const std::array<int, 3>& cells) {
  SurfaceMesh surface = SurfaceOf(MeshBox(size, cells));
  for (Vector3d& p : surface.nodes) p -= 0.5 * size;
  return surface;
}

// A thin spike along x whose lower side is cut into a fan of triangles, so that most of the normals
// round its tip point down.
SurfaceMesh FannedSpike() {
  constexpr int kCuts = 20;
  SurfaceMesh surface;
  surface.nodes = {{0.9, 0, 0}, {0, 0, 0.1}};  // tip, ridge of the base
  for (int i = 0; i <= kCuts; ++i) surface.nodes.emplace_back(0, 0.3 - 0.6 * i / kCuts, 0);
  for (int i = 2; i < kCuts + 2; ++i) {
    surface.triangles.push_back({0, i + 1, i});  // below
    surface.triangles.push_back({1, i, i + 1});  // base
  }
  surface.triangles.push_back({0, 2, 1});
  surface.triangles.push_back({0, 1, kCuts + 2});
  return surface;
}

// Box, sphere, a star with dents and spikes, a needle with slivers, a spike, all about 1 across.
std::vector<Body> Bodies(double scale) {
  std::vector<Body> bodies{{"box", Box({1, 0.7, 0.4}, {3, 2, 2})},
                           {"sphere", Refined(Box({1, 1, 1}, {2, 2, 2}))},
                           {"star", Refined(Box({1, 1, 1}, {3, 3, 3}))},
                           {"needle", Box({1, 1e-4, 2e-4}, {7, 1, 1})},
                           {"spike", FannedSpike()}};
  for (Vector3d& p : bodies[1].surface.nodes) p = 0.5 * p.normalized();
  for (Vector3d& p : bodies[2].surface.nodes) {
    const Vector3d u = p.normalized();
    p = u * (0.35 + 0.15 * std::sin(9 * u.x()) * std::cos(7 * u.y() + u.z()));
  }
  for (Body& body : bodies) {
    for (Vector3d& p : body.surface.nodes) p *= scale;
  }
  return bodies;
}

std::array<Vector3d, 3> CornersOf(const SurfaceMesh& surface, std::size_t triangle) {
  const auto& nodes = surface.triangles[triangle];
  return {surface.nodes[static_cast<std::size_t>(nodes[0])],
          surface.nodes[static_cast<std::size_t>(nodes[1])],
          surface.nodes[static_cast<std::size_t>(nodes[2])]};
}

// Distance of `p` from a triangle by trying every subset of its corners: the least squares
// combination of them is its closest point if no weight is negative.
double DistanceByAllSubsets(const Vector3d& p, const std::array<Vector3d, 3>& abc) {
  double least = kInf;
  for (const Vector3d& corner : abc) least = std::min(least, (p - corner).norm());
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3d &a = abc[i], edge = abc[(i + 1) % 3] - a;
    const double s = edge.dot(p - a) / edge.dot(edge);
    if (s > 0 && s < 1) least = std::min(least, edge.cross(p - a).norm() / edge.norm());
  }
  Eigen::Matrix3d system;
  const Vector3d normal = (abc[1] - abc[0]).cross(abc[2] - abc[0]).normalized();
  system << abc[1] - abc[0], abc[2] - abc[0], normal;
  const Vector3d uvh = system.fullPivLu().solve(p - abc[0]);
  if (uvh[0] > 0 && uvh[1] > 0 && uvh[0] + uvh[1] < 1) least = std::min(least, std::abs(uvh[2]));
  return least;
}

// Returns random points around the surface, and points on and above its nodes, edges and faces.
std::vector<Vector3d> Probes(const SurfaceMesh& surface, double scale, std::mt19937* random) {
  std::vector<Vector3d> probes;
  for (int i = 0; i < 60; ++i) probes.push_back(RandomProbe(random, scale));
  for (int i = 0; i < 60; ++i) {
    const auto abc = CornersOf(surface, (*random)() % surface.triangles.size());
    const Vector3d p = i % 3 == 0   ? abc[0]
                       : i % 3 == 1 ? Vector3d(0.5 * (abc[0] + abc[1]))
                                    : Vector3d((abc[0] + abc[1] + abc[2]) / 3);
    probes.push_back(p);
    probes.push_back(p + RandomProbe(random, 0.05 * scale));
  }
  return probes;
}

// Reference: every triangle, one by one, by another formula; and the consistency of the returned
// place. Tolerance: rounding of the coordinates, times 1e4 for the needle's thin triangles, whose
// sides have this ratio.
TEST(SurfaceContactTest, FindsTheClosestPlaceThatTryingEveryTriangleFinds) {
  std::mt19937 random(1);
  for (const double scale : {1e-9, 1.0, 1e3}) {
    for (const Body& body : Bodies(scale)) {
      const SurfaceContact contact(body.surface);
      for (const Vector3d& p : Probes(body.surface, scale, &random)) {
        const auto place = contact.Find(p, 10 * scale);
        ASSERT_TRUE(place) << body.name;
        double least = kInf;
        for (std::size_t t = 0; t < body.surface.triangles.size(); ++t) {
          least = std::min(least, DistanceByAllSubsets(p, CornersOf(body.surface, t)));
        }
        EXPECT_NEAR(place->distance / scale, least / scale, 1e-12) << body.name;
        EXPECT_NEAR((p - place->p_O).norm() / scale, place->distance / scale, 1e-14);
        const auto abc = CornersOf(body.surface, static_cast<std::size_t>(place->triangle));
        const Vector3d& w = place->weights;
        EXPECT_LT((w[0] * abc[0] + w[1] * abc[1] + w[2] * abc[2] - place->p_O).norm() / scale,
                  1e-14);
        EXPECT_NEAR(w.sum(), 1, 1e-15);
        EXPECT_GE(w.minCoeff(), 0);
        const Vector3d normal = (abc[1] - abc[0]).cross(abc[2] - abc[0]).normalized();
        EXPECT_LT((place->n_O - normal).norm(), 1e-9);
      }
    }
  }
}

// Reference: the winding number of the surface about the point. Points closer than 1e-9 to the
// surface are left out because of rounding.
TEST(SurfaceContactTest, DistinguishesInsideFromOutsideAlsoAtSpikesAndHollows) {
  std::mt19937 random(2);
  for (const double scale : {1e-9, 1.0, 1e3}) {
    for (const Body& body : Bodies(scale)) {
      const SurfaceContact contact(body.surface);
      std::vector<int> all(body.surface.triangles.size());
      std::iota(all.begin(), all.end(), 0);
      int inside = 0;
      for (const Vector3d& p : Probes(body.surface, scale, &random)) {
        const auto place = contact.Find(p, 10 * scale);
        if (place->distance < 1e-9 * scale) continue;
        const bool winds = WindingNumber(body.surface, all, p) > 0.5;
        EXPECT_EQ(place->inside, winds) << body.name << ", distance " << place->distance / scale;
        inside += winds ? 1 : 0;
      }
      EXPECT_TRUE(inside > 10 || body.name == "needle") << body.name;
    }
  }
}

TEST(SurfaceContactTest, FindsNothingBeyondTheGateOrWhereThereIsNoPoint) {
  const SurfaceContact contact(Box({2, 2, 2}, {2, 2, 2}));
  EXPECT_TRUE(contact.Find({0, 0, 1.01}, 0.011));
  EXPECT_FALSE(contact.Find({0, 0, 1.01}, 0.009));
  EXPECT_TRUE(contact.Find({0, 0, 0.99}, 0.011)->inside);
  EXPECT_TRUE(contact.Find({0, 0, 1}, 0));
  EXPECT_FALSE(contact.Find({0.3, 0.2, 1}, -1));
  EXPECT_FALSE(contact.Find({0.3, 0.2, 1}, kNan));
  EXPECT_FALSE(contact.Find({0.3, kNan, 1}, 1));
  EXPECT_FALSE(contact.Find({0.3, kInf, 1}, kInf));
  EXPECT_FALSE(contact.Find({1e200, 0, 0}, 1));
  EXPECT_TRUE(contact.Find({1e100, 0, 0}, kInf));
}

// A point over an edge belongs to both triangles; the choice must not depend on their order.
TEST(SurfaceContactTest, AtAnEdgeChoosesTheTriangleThatFacesThePoint) {
  SurfaceMesh surface = Box({2, 2, 2}, {1, 1, 1});
  for (int turn = 0; turn < 2; ++turn) {
    const SurfaceContact contact(surface);
    EXPECT_LT((contact.Find({0.1, 1.1, 1.4}, 1)->n_O - Vector3d(0, 0, 1)).norm(), 1e-15);
    EXPECT_LT((contact.Find({0.1, 1.4, 1.1}, 1)->n_O - Vector3d(0, 1, 0)).norm(), 1e-15);
    EXPECT_LT((contact.Find({1.1, 1.2, 1.3}, 1)->n_O - Vector3d(0, 0, 1)).norm(), 1e-15);
    std::reverse(surface.triangles.begin(), surface.triangles.end());
  }
}

TEST(SurfaceContactTest, PassesOverTrianglesWithoutArea) {
  SurfaceMesh surface = Box({2, 2, 2}, {2, 2, 2});
  const SurfaceContact sound(surface);
  surface.triangles.insert(surface.triangles.begin(), {{0, 0, 0}, {0, 1, 0}, {0, 1, 2}});
  const SurfaceContact contact(surface);
  std::mt19937 random(3);
  for (int i = 0; i < 200; ++i) {
    const Vector3d p = RandomProbe(&random, 1.5);
    const auto place = contact.Find(p, 10), expected = sound.Find(p, 10);
    EXPECT_EQ(place->distance, expected->distance);
    EXPECT_EQ(place->inside, expected->inside);
    EXPECT_NEAR(place->n_O.norm(), 1, 1e-15);
  }
}

TEST(SurfaceContactTest, AllocatesNothingWhenAsked) {
  const SurfaceContact contact(Refined(Refined(Box({1, 1, 1}, {3, 3, 3}))));
  std::mt19937 random(4);
  const long before = AllocationCount();
  int found = 0;
  for (int i = 0; i < 1000; ++i) found += contact.Find(RandomProbe(&random, 1), 0.3) ? 1 : 0;
  EXPECT_EQ(AllocationCount(), before);
  EXPECT_GT(found, 100);
}

TEST(SurfaceContactTest, RefusesWhatIsNoSurface) {
  EXPECT_THROW(SurfaceContact({}), std::invalid_argument);
  const std::vector<Vector3d> nodes{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, kNan, 0}};
  EXPECT_THROW(SurfaceContact({nodes, {{0, 1, 2}}}), std::invalid_argument);
  EXPECT_THROW(SurfaceContact({nodes, {{0, 1, 3}}}), std::invalid_argument);
  EXPECT_THROW(SurfaceContact({nodes, {{0, 1, 4}}}), std::invalid_argument);
}

}  // namespace
}  // namespace palpate
