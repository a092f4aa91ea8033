#include "slave/reference/solid/pressed_block.h"

#include <string>

#include <gtest/gtest.h>

#include "slave/scene/scene_loader.h"

namespace palpate::simulation {
namespace {

Scene SceneOf(double thickness_mm, double nu, const std::string& tool,
              const std::string& fixed = "{side: bottom}") {
  return ParseScene(
      "name: block\nobject:\n  geometry: {rectangle: {width: 100 mm, height: 100 mm, "
      "thickness: " +
      std::to_string(thickness_mm) +
      " mm}}\n  material: {young_modulus: 1 kPa, poisson_ratio: " + std::to_string(nu) +
      "}\n  fixed: " + fixed + "\ntool: {" + tool + "}\nmodel: {kind: extruded}\n");
}

PatchSolution Solve(const Scene& scene, const Eigen::Vector2d& at) {
  const TrueBody body(scene);
  return SolveBlock(body, scene.object.material.poisson_ratio, ThicknessOf(scene.object.geometry),
                    body.Nearest(at), *scene.tool);
}

// Reference: trilinear bricks with mean dilatation, two finer meshes extrapolated, block_flat of
// tests/campaigns/truth/pressed_plane.py. Tolerance: 2 %, of both.
TEST(PressedBlock, IsAsStiffAsFinerBricks) {
  const Scene middle = SceneOf(100, 0.45, "width: 10 mm, depth: 10 mm");
  EXPECT_NEAR(Solve(middle, {0.05, 0.1}).stiffness(1, 1) / 0.14403, 1, 0.02);
  const Scene aside = SceneOf(60, 0.45, "width: 15 mm, depth: 12 mm, behind: 6 mm");
  EXPECT_NEAR(0.6 * Solve(aside, {0.03, 0.1}).stiffness(1, 1) / 0.14826, 1, 0.02);
}

// A block that is rotated by 90 degrees together with its supports is the same body. Tolerance:
// rounding.
TEST(PressedBlock, AllSidesAreEquivalent) {
  const std::string tool = "width: 10 mm, depth: 20 mm, behind: 5 mm";
  const PatchSolution top = Solve(SceneOf(50, 0.4, tool), {0.04, 0.1});
  const PatchSolution right = Solve(SceneOf(50, 0.4, tool, "{side: left}"), {0.1, 0.06});
  EXPECT_NEAR(right.stiffness(0, 0) / top.stiffness(1, 1), 1, 1e-6);
  EXPECT_NEAR(right.stiffness(1, 1) / top.stiffness(0, 0), 1, 1e-6);
}

// The front face moves least far from the tool, and not at all at the supports.
TEST(PressedBlock, TheFrontMovesLessThanTheTool) {
  const PatchSolution solution =
      Solve(SceneOf(60, 0.45, "width: 10 mm, depth: 10 mm"), {0.05, 0.1});
  double largest = 0;
  for (std::size_t n = 0; n < solution.mesh.nodes.size(); ++n) {
    const double moved = std::abs(solution.displacement(static_cast<Eigen::Index>(n), 3));
    if (solution.mesh.nodes[n].y() < 1e-9) {
      EXPECT_EQ(moved, 0);
    }
    largest = std::max(largest, moved);
  }
  EXPECT_LT(largest, 0.5);
  EXPECT_GT(largest, 0.05);
}

}  // namespace
}  // namespace palpate::simulation
