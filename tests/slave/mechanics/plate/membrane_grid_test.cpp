#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "slave/mechanics/plate/plate_surface.h"

namespace palpate {
namespace {

// Reference: a regular 144-gon's area, and Euler's formula for a disc.
TEST(MembraneGrid, CoversTheDiscOnce) {
  const double a = 0.039;
  const SurfaceMesh grid = MembraneGrid(a);
  ASSERT_EQ(grid.nodes.size(), 1U + 3 * 24 * 25);
  double area = 0;
  for (const auto& [i, j, k] : grid.triangles) {
    const auto node = [&](int n) { return grid.nodes.at(static_cast<std::size_t>(n)); };
    const double twice = (node(j) - node(i)).cross(node(k) - node(i)).z();
    EXPECT_GT(twice, 0);
    area += twice / 2;
  }
  const double polygon = 72 * a * a * std::sin(2 * std::numbers::pi / 144);
  EXPECT_NEAR(area / polygon, 1, 1e-12);
  EXPECT_EQ(grid.triangles.size(), 2 * grid.nodes.size() - 2 - 144);
}

}  // namespace
}  // namespace palpate
