#include "slave/mechanics/bem3d/closed_surface.h"

#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/mechanics/bem3d/solid_bodies.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

SurfaceMesh Cube() {
  return solid_bodies::Box({1, 1, 1}, {2, 2, 2});
}

std::string Refusal(const SurfaceMesh& mesh) {
  return Thrown<std::invalid_argument>([&] { ClosedSurface surface(mesh); });
}

void Turn(std::array<int, 3>* triangle) {
  std::swap((*triangle)[1], (*triangle)[2]);
}

TEST(ClosedSurface, IsMeasuredByItsLargestSideAboutItsMiddle) {
  SurfaceMesh mesh = solid_bodies::Box({2, 1, 4}, {1, 1, 1});
  for (auto& p : mesh.nodes) p += Eigen::Vector3d(100, 200, 300);
  const ClosedSurface surface(mesh);
  EXPECT_EQ(surface.length_unit, 4);
  EXPECT_EQ(surface.origin_O, Eigen::Vector3d(101, 200.5, 302));
  EXPECT_EQ(surface.size(), 12);
  EXPECT_FALSE(surface.has_cavities);
}

TEST(ClosedSurface, KnowsItsCavities) {
  const auto shell =
      solid_bodies::WithCavity(solid_bodies::Sphere(2, 2), solid_bodies::Sphere(1, 1));
  EXPECT_TRUE(ClosedSurface(shell).has_cavities);
}

TEST(ClosedSurface, RefusesOpenSurfacesWithTheTriangle) {
  SurfaceMesh mesh = Cube();
  mesh.triangles.pop_back();
  EXPECT_THAT(Refusal(mesh), AllOf(HasSubstr("triangle "), HasSubstr("has no neighbour")));
}

TEST(ClosedSurface, RefusesTrianglesWithoutArea) {
  SurfaceMesh mesh = Cube();
  mesh.triangles[7][1] = mesh.triangles[7][0];
  EXPECT_THAT(Refusal(mesh), HasSubstr("triangle 7: it has no area"));
}

TEST(ClosedSurface, RefusesTheSameTriangleTwice) {
  SurfaceMesh mesh = Cube();
  mesh.triangles.push_back(mesh.triangles[3]);
  EXPECT_THAT(Refusal(mesh), HasSubstr("triangle 48: it has the corners of triangle 3"));
  Turn(&mesh.triangles.back());
  EXPECT_THAT(Refusal(mesh), HasSubstr("triangle 48: it has the corners of triangle 3"));
}

TEST(ClosedSurface, RefusesATriangleThatIsTurnedRound) {
  SurfaceMesh mesh = Cube();
  Turn(&mesh.triangles[11]);
  EXPECT_THAT(Refusal(mesh), AllOf(HasSubstr("triangle 1"), HasSubstr("one orientation")));
}

TEST(ClosedSurface, RefusesSurfacesInsideOut) {
  SurfaceMesh mesh = Cube();
  for (auto& triangle : mesh.triangles) Turn(&triangle);
  EXPECT_THAT(Refusal(mesh), HasSubstr("inside out"));
}

TEST(ClosedSurface, RefusesASecondBody) {
  SurfaceMesh mesh = Cube();
  SurfaceMesh other = Cube();
  for (auto& p : other.nodes) p.x() += 3;
  for (auto& triangle : other.triangles) Turn(&triangle);
  EXPECT_THAT(Refusal(solid_bodies::WithCavity(mesh, other)),
              HasSubstr("triangle 48: a second body"));
}

TEST(ClosedSurface, RefusesACavityOutsideOfTheBody) {
  SurfaceMesh other = solid_bodies::Box({0.5, 0.5, 0.5}, {2, 2, 2});
  for (auto& p : other.nodes) p.x() += 3;
  EXPECT_THAT(Refusal(solid_bodies::WithCavity(Cube(), other)),
              HasSubstr("triangle 48: a part begins here that is inside out"));
}

TEST(ClosedSurface, RefusesNodesThatAreNone) {
  SurfaceMesh mesh = Cube();
  mesh.triangles[5][2] = 99;
  EXPECT_THAT(Refusal(mesh), HasSubstr("triangle 5: node 99: accepted is 0 to 26"));
  mesh = Cube();
  mesh.nodes[static_cast<std::size_t>(mesh.triangles[0][0])].x() =
      std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Refusal(mesh), HasSubstr("is not finite"));
  EXPECT_THAT(Refusal({}), HasSubstr("accepted is 4 or more"));
}

}  // namespace
}  // namespace palpate
