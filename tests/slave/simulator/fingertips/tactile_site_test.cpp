#include "slave/simulator/fingertips/tactile_site.h"

#include <gtest/gtest.h>

#include "tests/slave/simulator/fingertips/touch_scenes.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using simulation::CubeScene;
using simulation::PinchScene;

// Forces on it are 10 to 30 % off, series are solved in a tenth of the time.
constexpr SiteResolution kCoarseSite{.edge = 3.5e-3, .fine_reach = 4e-3, .growth = 0.8};

void PressBy(TactileSite* site, double depth, const Vector3d& beside = {0, 0, 0}) {
  site->MoveTool(site->home() + (site->gap() + depth) * site->approach() + beside);
}

// Reference: symmetry. Two fingers press as mirror images in a symmetry plane of the body and its
// hexahedra. Tolerance: Newton's method stops at residuals of 1e-5.
TEST(TactileSite, PinchingFingersFeelOppositeForces) {
  TactileSite site(PinchScene(), kCoarseSite);
  EXPECT_TRUE(site.approach().isApprox(Vector3d(0, -1, 0)));
  PressBy(&site, 1.5e-3);
  const auto truth = site.truth().fingers;
  ASSERT_TRUE(truth[0].in_contact && truth[1].in_contact);
  EXPECT_GT(truth[0].force.y(), 0.03);
  const Vector3d mirrored = truth[1].force.cwiseProduct(Vector3d(1, -1, 1));
  EXPECT_LT((truth[0].force - mirrored).norm(), 1e-4 * truth[0].force.norm());
  EXPECT_NEAR(truth[1].X_SF.translation().y(), -0.012 + 6.5e-3, 1e-9);
}

// Reference: Mindlin 1949, ratio of tangential to normal stiffness 2 (1 - nu) / (2 - nu), and a
// friction of 1 at most.
TEST(TactileSite, SidewaysMotionIsHeldUntilItSlips) {
  TactileSite site(CubeScene(), kCoarseSite);
  PressBy(&site, 1.95e-3);
  const double below = site.truth().fingers[0].force.z();
  PressBy(&site, 2e-3);
  const double normal = site.truth().fingers[0].force.z();
  const double across = site.truth().fingers[0].force.x();
  PressBy(&site, 2e-3, {0.1e-3, 0, 0});
  const double held = across - site.truth().fingers[0].force.x();
  const double stiffness = (normal - below) / 0.05e-3;
  EXPECT_NEAR(held, 2 * 0.85 / 1.85 * stiffness * 0.1e-3, 0.15 * held);
  PressBy(&site, 2e-3, {20e-3, 0, 0});
  EXPECT_NEAR(across - site.truth().fingers[0].force.x(), normal, 0.05 * normal);
  PressBy(&site, -1e-3);
  PressBy(&site, 2e-3);  // it sticks again
  EXPECT_NEAR(site.truth().fingers[0].force.x(), across, 1e-9);
}

// Reference: the same contact after it is solved; the cube's top is flat, so the solved contact
// beside it is equivalent.
TEST(TactileSite, WithoutWaitingAnUnsolvedContactIsTheNearestSolvedOne) {
  const Vector3d beside{0, 9e-3, 0};
  TactileSite site(CubeScene(), kCoarseSite);
  PressBy(&site, 2e-3);
  PressBy(&site, -1e-3);
  site.MoveTool(site.home() + (site.gap() + 1.5e-3) * site.approach() + beside,
                WhenUnsolved::kUseNearest);
  const Truth nearest = site.truth();
  EXPECT_FALSE(nearest.solved) << "it waited";
  EXPECT_TRUE(nearest.in_contact);
  PressBy(&site, 1.5e-3, beside);
  const Truth solved = site.truth();
  EXPECT_TRUE(solved.solved);
  EXPECT_NEAR(nearest.force.z(), solved.force.z(), 0.25 * solved.force.z());
  EXPECT_NEAR(nearest.depth, solved.depth, 0.1e-3);
  site.MoveTool(site.home() + (site.gap() + 1.5e-3) * site.approach() + beside,
                WhenUnsolved::kUseNearest);
  EXPECT_TRUE(site.truth().solved);
  EXPECT_EQ(site.truth().force, solved.force);
}

TEST(TactileSite, PosesOfObjectAndHandRotateTheWholeScene) {
  Scene scene = CubeScene();
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(1.1, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  X.translation() = Vector3d(0.2, -0.1, 0.4);
  scene.object.X_SO = X;
  scene.sense.Find<Tactile>()->fingers[0].X_SF = X * scene.sense.Find<Tactile>()->fingers[0].X_SF;
  TactileSite turned(scene, kCoarseSite), plain(CubeScene(), kCoarseSite);
  PressBy(&turned, 1e-3);
  PressBy(&plain, 1e-3);
  const FingerTruth a = turned.truth().fingers[0], b = plain.truth().fingers[0];
  EXPECT_LT((a.force - X.linear() * b.force).norm(), 1e-6 * b.force.norm());
  EXPECT_LT((a.p_S_contact - X * b.p_S_contact).norm(), 1e-9);
  // The skin has the same load in its own frame.
  const TactileFrame fa = turned.TakeSample(Time{}), fb = plain.TakeSample(Time{});
  EXPECT_EQ(fa.fingers[0].channels, fb.fingers[0].channels);
}

}  // namespace
}  // namespace palpate
