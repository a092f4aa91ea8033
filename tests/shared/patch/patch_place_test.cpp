#include "shared/patch/patch_place.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/shared/patch/patches.h"

namespace palpate {
namespace {

// A square of 20 mm in the plane z = 0, seen from +z, as two triangles.
SurfacePatch Square() {
  SurfacePatch patch;
  patch.epoch = 1;
  patch.vertices_per_cell = 3;
  patch.vertex_count = 4;
  patch.cell_count = 2;
  patch.vertices[0] = {0, 0, 0};
  patch.vertices[1] = {0.02F, 0, 0};
  patch.vertices[2] = {0.02F, 0.02F, 0};
  patch.vertices[3] = {0, 0.02F, 0};
  patch.cells[0] = {0, 1, 2};
  patch.cells[1] = {0, 2, 3};
  MarkRim(&patch);
  return patch;
}

// Reference: the square's closed form, clamped coordinates.
TEST(PatchPlaceTest, TheNearestPlaceOfASquareIsTheClampedPoint) {
  const SurfacePatch square = Square();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> at(-0.03, 0.05);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d p(at(random), at(random), at(random));
    const Eigen::Vector3d clamped(std::clamp(p.x(), 0.0, 0.02), std::clamp(p.y(), 0.0, 0.02), 0);
    const PatchPlace place = NearestPlace(square, p);
    ASSERT_LT((place.p - clamped).norm(), 1e-8) << p.transpose();
    ASSERT_NEAR(std::abs(place.height), (p - clamped).norm(), 1e-8);
    ASSERT_EQ(place.height < 0, p.z() < 0);
    const bool outside = p.head<2>() != clamped.head<2>();
    ASSERT_EQ(place.at_rim, outside) << p.transpose();
  }
}

// Reference: a ridge belongs to both faces; the nearer face determines the side. The inside is
// below.
TEST(PatchPlaceTest, OverARidgeIsOutsideAndUnderItIsInside) {
  const SurfacePatch roof = Roof(500, 0, 3, 0.5);
  EXPECT_NEAR(NearestPlace(roof, {0, 0.001, 0}).height, 0.001, 1e-9);
  EXPECT_LT(NearestPlace(roof, {0.001, -0.004, 0}).height, 0);
  EXPECT_TRUE(NearestPlace(roof, {0.05, 0, 0}).at_rim);
  EXPECT_FALSE(NearestPlace(roof, {0.001, 0.003, 0}).at_rim);
}

}  // namespace
}  // namespace palpate
