// The scenes in deploy/scenes load, and say what the papers say.
#include <numbers>

#include <gtest/gtest.h>

#include "slave/scene/scene_loader.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

Scene LoadShipped(const std::string& name) {
  return LoadScene(std::string(SourcePath("/deploy/scenes/")) + name + ".yaml");
}

// Every corner that moves into the picture: the object and the tool from home to full press.
void ExpectInPicture(const Scene& scene) {
  const Camera& camera = *scene.sense.Find<Camera>();
  const Eigen::Vector2d half(0.5 * camera.size[0] * camera.pixel,
                             0.5 * camera.size[1] * camera.pixel);
  const auto expect = [&](const Eigen::Vector3d& p_S) {
    const Eigen::Vector3d p_C = camera.X_SC.inverse() * p_S;
    EXPECT_LT(std::abs(p_C.x()), half.x()) << p_S.transpose();
    EXPECT_LT(std::abs(p_C.y()), half.y()) << p_S.transpose();
  };
  for (const auto& p : OutlineOf(scene.object.geometry).outer) {
    expect(scene.object.X_SO * Eigen::Vector3d(p.x(), p.y(), 0));
  }
  expect(scene.manipulator.home);
}

TEST(ShippedSceneTest, TheBlockIsPaperAsFirstExperiment) {
  const Scene scene = LoadShipped("silicone-block");
  const auto& block = std::get<RectangleGeometry>(scene.object.geometry);
  EXPECT_DOUBLE_EQ(block.width, 0.088);
  EXPECT_DOUBLE_EQ(block.height, 0.088);
  EXPECT_DOUBLE_EQ(block.thickness, 0.009);
  EXPECT_DOUBLE_EQ(scene.object.material.young_modulus, 127e3);
  EXPECT_DOUBLE_EQ(scene.object.material.density, 1050);
  EXPECT_EQ(std::get<FixedSide>(scene.object.fixed.at(0).where).side, "bottom");
  EXPECT_DOUBLE_EQ(scene.tool->width, 5.87e-3);
  EXPECT_EQ(scene.tool->direction, Eigen::Vector2d(0, -1));
  EXPECT_EQ(scene.model.elements, 180);
  EXPECT_EQ(scene.model.plane, Plane::kStress);
  EXPECT_DOUBLE_EQ(scene.operator_options.press_depth, 5e-3);
  EXPECT_DOUBLE_EQ(scene.operator_options.press_speed, 20e-3);
  EXPECT_GT(scene.manipulator.max_speed, scene.operator_options.press_speed);
  EXPECT_GT(scene.site.misplacement.norm(), 0);
  ExpectInPicture(scene);
}

TEST(ShippedSceneTest, TheEmbryoIsPaperAsSecondExperiment) {
  const Scene scene = LoadShipped("zebrafish-embryo");
  EXPECT_DOUBLE_EQ(std::get<DiscGeometry>(scene.object.geometry).radius, 0.6e-3);
  EXPECT_DOUBLE_EQ(scene.object.material.young_modulus, 1.51e6);
  EXPECT_DOUBLE_EQ(scene.object.material.poisson_ratio, 0.5);
  EXPECT_EQ(scene.model.plane, Plane::kStrain);
  const auto& arc = std::get<FixedArc>(scene.object.fixed.at(0).where);
  EXPECT_DOUBLE_EQ(arc.centre, std::numbers::pi);
  EXPECT_DOUBLE_EQ(arc.half_angle, std::numbers::pi / 6);
  EXPECT_EQ(scene.tool->direction, Eigen::Vector2d(-1, 0));  // from home on the right
  EXPECT_DOUBLE_EQ(scene.model.puncture_from, 40e-6);
  ASSERT_TRUE(scene.site.embryo);
  EXPECT_EQ(scene.site.embryo->puncture, Eigen::Vector2d(50e-6, 200e-6));
  EXPECT_GT(scene.operator_options.press_depth, scene.site.embryo->puncture[1]);
  ExpectInPicture(scene);
}

// Reference b, disc of 100 elements, plane strain, nu 0.5: 0.651 N per um and metre of thickness on
// a patch of 38 um, so 200 um of the 1.2 mm thick disc, where the chorion breaks at the latest, are
// 156 mN.
TEST(ShippedSceneTest, TheEmbryosLargestForceStaysWithinTheForceLimit) {
  const Scene scene = LoadShipped("zebrafish-embryo");
  const double force =
      0.6511619520953413e6 * scene.site.embryo->puncture[1] * ThicknessOf(scene.object.geometry);
  const double felt = scene.operator_options.transform.force_scale * force;
  EXPECT_LT(felt, scene.operator_options.force_limit);
  EXPECT_GT(felt, 0.5 * scene.operator_options.force_limit);  // and is well felt
}

TEST(ShippedSceneTest, TheFoamCubeIsPaperBsHardOne) {
  const Scene scene = LoadScene(SourcePath("/deploy/scenes/foam-cube.yaml"), {}, SceneUse::kSolve);
  EXPECT_EQ(std::get<BoxGeometry>(scene.object.geometry).size, Eigen::Vector3d(0.06, 0.06, 0.06));
  EXPECT_DOUBLE_EQ(scene.object.material.young_modulus, 3800);
  EXPECT_DOUBLE_EQ(scene.object.material.density, 45);
  EXPECT_EQ(scene.model.fem.law, FemOptions::Law::kCorotational);
}

// Reference: paper C, 5.1, and the rig stated for its simulated site.
TEST(ShippedSceneTest, TheMembraneIsPaperCsFirstExperiment) {
  const Scene scene = LoadShipped("rubber-membrane");
  EXPECT_DOUBLE_EQ(std::get<MembraneGeometry>(scene.object.geometry).radius, 0.039);
  EXPECT_DOUBLE_EQ(scene.object.material.young_modulus, 27.2e6);
  EXPECT_DOUBLE_EQ(scene.object.material.poisson_ratio, 0.45);
  EXPECT_EQ(scene.model.kind, "plate-large");
  EXPECT_DOUBLE_EQ(scene.operator_options.press_depth, 5e-3);
  const StereoCameras& pair = *scene.sense.Find<StereoCameras>();
  EXPECT_EQ(pair.source, StereoCameras::Source::kSimulated);
  EXPECT_EQ(pair.rate, 30);
  EXPECT_EQ(pair.focal, 800);
  EXPECT_DOUBLE_EQ(pair.baseline, 0.06);
  EXPECT_NEAR(pair.X_SL.translation().z(), -0.25, 1e-12);
  const PointTracking& points = *scene.sense.Find<PointTracking>();
  EXPECT_EQ(points.track, PointTracking::Track::kDots);
  EXPECT_EQ(points.count, 31);
  EXPECT_TRUE(points.spacing.isApprox(Eigen::Vector2d(0.015, 0.010)));
  EXPECT_EQ(scene.site.noise, 2);
  EXPECT_EQ(scene.site.blur, 0.7);
}

// Reference: paper C, 5.2. Nothing holds what moves as a whole, so no force is told. The mesh has
// the extent of the surface that the simulated site draws: semi-axes of 34, 30 and 20 mm, and bumps
// of 0.6 mm.
TEST(ShippedSceneTest, TheHeartIsPaperCsSecondExperiment) {
  const Scene scene = LoadShipped("heart-target");
  EXPECT_TRUE(std::holds_alternative<MeshFileGeometry>(scene.object.geometry));
  EXPECT_FALSE(IsHeld(scene.object));
  EXPECT_EQ(scene.sense.Find<PointTracking>()->track, PointTracking::Track::kTexture);
  EXPECT_EQ(scene.sense.Find<StereoCameras>()->rate, 30);
  EXPECT_EQ(scene.site.pace, 1);
  // The tool's default width is a fifteenth of the larger side.
  EXPECT_NEAR(15 * scene.tool.value().width, 0.068, 2 * 0.0006);
}

}  // namespace
}  // namespace palpate
