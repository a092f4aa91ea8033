#include "slave/checks/points/rest_surface.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

constexpr int kColumns = 80, kRows = 60;
constexpr double kTopDistance = 0.25, kTableDistance = 0.31,
                 kHalfWidth = 0.03;  // of the top, its table [m]

// A square of 60 mm, a quarter of a metre before a camera, in its frame.
SurfaceMesh Square() {
  SurfaceMesh surface;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    surface.nodes.emplace_back(kHalfWidth * x, kHalfWidth * y, kTopDistance);
  }
  surface.triangles = {{0, 2, 1}, {0, 3, 2}};
  return surface;
}

// Returns what a camera measures of the square on a table if its focal length (factor `focal`),
// position and rotation about y differ from the stated ones.
std::vector<RestRay> SeenRays(double focal, double scale, double shift, double tilt,
                              bool has_table) {
  constexpr double kFocal = 150;
  std::vector<RestRay> rays;
  for (int v = 0; v < kRows; ++v) {
    for (int u = 0; u < kColumns; ++u) {
      const double x = (u - 0.5 * kColumns) / kFocal, y = (v - 0.5 * kRows) / kFocal;
      const double X = std::tan(std::atan(x) + tilt) * kTopDistance - shift, Y = y * kTopDistance;
      const bool on = std::abs(X) <= kHalfWidth && std::abs(Y) <= kHalfWidth;
      // A plane whose depth grows across the image by the tilt.
      const double z = kTopDistance / (1 - std::tan(tilt) * x);
      rays.push_back({{x / focal, y / focal}, on ? scale * z : has_table ? kTableDistance : 0});
    }
  }
  return rays;
}

// Returns the rays of the square rotated about its centre.
std::vector<RestRay> Turned(double tilt) {
  return SeenRays(1, 1, std::tan(tilt) * kTopDistance, tilt, true);
}

RestSurface CompareRest(const std::vector<RestRay>& rays) {
  return CompareAtRest(Square(), rays, kColumns, 5e-4, 25);
}

std::string Fault(const RestSurface& rest) {
  return std::string(FaultOf(rest, 2 * kHalfWidth));
}

TEST(RestSurfaceTest, ASurfaceWhereTheSceneHasItIsAccepted) {
  for (const bool has_table : {false, true}) {
    const RestSurface rest = CompareRest(SeenRays(1, 1, 0, 0, has_table));
    EXPECT_NEAR(rest.distance, kTopDistance, 1e-9);
    EXPECT_NEAR(rest.off, 0, 1e-9);
    EXPECT_NEAR(rest.tilt, 0, 1e-9);
    EXPECT_GT(rest.edge, 0.95);
    EXPECT_LT(rest.beyond, 0.05);
    EXPECT_EQ(Fault(rest), "");
  }
}

// Depths that are 10 % too long, and a camera 20 mm too high.
TEST(RestSurfaceTest, AnotherDistanceIsNamed) {
  for (const double scale : {1.1, 0.9, 0.27 / 0.25}) {
    const RestSurface rest = CompareRest(SeenRays(1, scale, 0, 0, true));
    EXPECT_NEAR(rest.off, (scale - 1) * kTopDistance, 1e-6);
    EXPECT_THAT(Fault(rest), HasSubstr("nearer or farther")) << scale;
  }
}

// With intrinsics of another stream the body appears smaller or larger, with any surroundings; an
// image of half the size with the intrinsics of the full one: by a factor of two.
TEST(RestSurfaceTest, IntrinsicsOfAnotherStreamAreNamed) {
  for (const bool has_table : {false, true}) {
    for (const double focal : {1.15, 1.3}) {
      EXPECT_THAT(Fault(CompareRest(SeenRays(focal, 1, 0, 0, has_table))),
                  HasSubstr("not extend as far"))
          << focal;
    }
    EXPECT_NE(Fault(CompareRest(SeenRays(2, 1, 0, 0, has_table))), "")
        << "most of it sees the table";
    for (const double focal : {0.85, 0.7}) {
      EXPECT_THAT(Fault(CompareRest(SeenRays(focal, 1, 0, 0, has_table))),
                  HasSubstr("extends farther"))
          << focal;
    }
  }
}

// Only the focal length of one axis is wrong: the sides along the other axis see the table. The
// body's edge must be in the image: with 1.7 times the focal length it no longer is.
TEST(RestSurfaceTest, PixelsThatAreNotSquareAreNamed) {
  for (const double focal : {0.5, 0.8, 1.25, 1.5}) {
    std::vector<RestRay> rays = SeenRays(1, 1, 0, 0, true);
    for (RestRay& ray : rays) ray.slope.y() /= focal;
    EXPECT_NE(Fault(CompareRest(rays)), "") << focal;
  }
}

// Another body of the same height touches it on one side.
TEST(RestSurfaceTest, ANeighbourOnOneSideIsNoFault) {
  std::vector<RestRay> rays = SeenRays(1, 1, 0, 0, true);
  for (RestRay& ray : rays) {
    if (ray.slope.x() > 0 && std::abs(ray.slope.y()) * kTopDistance <= kHalfWidth)
      ray.z = kTopDistance;
  }
  EXPECT_EQ(Fault(CompareRest(rays)), "");
}

TEST(RestSurfaceTest, ABodyBesideItsPlaceIsNamed) {
  EXPECT_THAT(Fault(CompareRest(SeenRays(1, 1, 0.008, 0, true))), HasSubstr("not extend as far"));
}

TEST(RestSurfaceTest, ATiltIsNamed) {
  const RestSurface rest = CompareRest(Turned(0.1));
  EXPECT_NEAR(rest.tilt, 0.1, 0.02);
  EXPECT_THAT(Fault(rest), HasSubstr("tilted"));
  EXPECT_EQ(Fault(CompareRest(Turned(0.02))), "");
}

TEST(RestSurfaceTest, ACameraThatDoesNotSeeTheBodyIsNamed) {
  std::vector<RestRay> rays = SeenRays(1, 1, 0, 0, false);
  for (RestRay& ray : rays) ray.slope.x() += 5;
  EXPECT_THAT(Fault(CompareRest(rays)), HasSubstr("no surface at rest"));
  for (RestRay& ray : rays) ray.z = 0;
  EXPECT_THAT(Fault(CompareRest(rays)), HasSubstr("no surface at rest"));
}

// Without rows there is no extent: points of a pair.
TEST(RestSurfaceTest, PointsOfAPairShowDistanceAndTilt) {
  const auto compare = [](double scale) {
    return CompareAtRest(Square(), SeenRays(1, scale, 0, 0, true), 0, 0, 1);
  };
  EXPECT_EQ(Fault(compare(1)), "");
  EXPECT_THAT(Fault(compare(1.05)), HasSubstr("nearer or farther"));
}

}  // namespace
}  // namespace palpate
