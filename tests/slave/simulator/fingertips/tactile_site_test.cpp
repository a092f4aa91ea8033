#include "slave/simulator/fingertips/tactile_site.h"

#include <gtest/gtest.h>

#include "tests/slave/simulator/fingertips/touch_scenes.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using site::CubeScene;
using site::PinchScene;

// Forces on it are 10 to 30 % off, ladders are solved in a tenth of the time.
constexpr SiteResolution kCoarse{.edge = 3.5e-3, .fine_reach = 4e-3, .growth = 0.8};

void PressBy(TactileSite* site, double depth, const Vector3d& beside = {0, 0, 0}) {
  site->MoveTool(site->home() + (site->gap() + depth) * site->approach() + beside);
}

TEST(TactileSite, PushesBackAgainstThePressAndLetsGo) {
  TactileSite site(CubeScene(), kCoarse);
  EXPECT_TRUE(site.approach().isApprox(Vector3d(0, 0, -1)));
  EXPECT_NEAR(site.gap(), 5e-3, 1e-6);  // a node lies right under the tip
  EXPECT_FALSE(site.truth().fingers[0].in_contact);
  double last = 0;
  for (const double depth : {0.3e-3, 0.8e-3, 1.5e-3, 2.5e-3}) {
    PressBy(&site, depth);
    const FingerTruth truth = site.truth().fingers[0];
    ASSERT_TRUE(truth.in_contact);
    EXPECT_GT(truth.force.z(), 1.2 * last);
    EXPECT_LT(truth.force.head<2>().norm(), 0.1 * truth.force.z());
    EXPECT_NEAR(truth.depth, depth, 0.02 * depth);
    EXPECT_LT((truth.p_S_contact - Vector3d(0.03, 0.03, 0.06 - depth)).norm(), 0.7e-3);
    last = truth.force.z();
  }
  // Hertz at 2.5 mm: 0.0542 N; see PressedBody's tests.
  EXPECT_NEAR(last, 0.0542, 0.014);
  PressBy(&site, -1e-3);
  EXPECT_FALSE(site.truth().fingers[0].in_contact);
  EXPECT_EQ(site.truth().fingers[0].force.norm(), 0);
}

// Reference: a press by two fingers that mirror each other in a plane of the body's symmetry, and
// so do the hexahedra. Tolerance: Newton's method stops at residuals of 1e-5.
TEST(TactileSite, PinchingFingersFeelOppositeForces) {
  TactileSite site(PinchScene(), kCoarse);
  EXPECT_TRUE(site.approach().isApprox(Vector3d(0, -1, 0)));
  PressBy(&site, 1.5e-3);
  const auto truth = site.truth().fingers;
  ASSERT_TRUE(truth[0].in_contact && truth[1].in_contact);
  EXPECT_GT(truth[0].force.y(), 0.03);
  const Vector3d mirrored = truth[1].force.cwiseProduct(Vector3d(1, -1, 1));
  EXPECT_LT((truth[0].force - mirrored).norm(), 1e-4 * truth[0].force.norm());
  EXPECT_NEAR(truth[1].X_SF.translation().y(), -0.012 + 6.5e-3, 1e-9);
}

TEST(TactileSite, AStandingFingerIsPressedByTheBodyThatGivesWay) {
  Scene scene = PinchScene();
  scene.sense.Find<Tactile>()->fingers[1].motion = Finger::Motion::kStands;
  scene.sense.Find<Tactile>()->fingers[1].X_SF.translation().y() = -7e-3;  // it touches
  TactileSite site(scene, kCoarse);
  PressBy(&site, 2.5e-3);
  const auto truth = site.truth().fingers;
  EXPECT_GT(truth[0].force.y(), 0.05);
  EXPECT_TRUE(truth[1].in_contact);
  EXPECT_LT(truth[1].force.y(), -0.005);
  EXPECT_LT(-truth[1].force.y(), truth[0].force.y());
  EXPECT_NEAR(truth[1].X_SF.translation().y(), -7e-3, 1e-12);
}

// Reference: Mindlin 1949, tangential over normal stiffness 2 (1 - nu) / (2 - nu), and no more than
// a friction of 1.
TEST(TactileSite, SidewaysMotionIsHeldUntilItSlips) {
  TactileSite site(CubeScene(), kCoarse);
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
  PressBy(&site, 2e-3);  // it stuck anew
  EXPECT_NEAR(site.truth().fingers[0].force.x(), across, 1e-9);
}

TEST(TactileSite, PosesOfObjectAndHandTurnTheWholeWorld) {
  Scene scene = CubeScene();
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(1.1, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  X.translation() = Vector3d(0.2, -0.1, 0.4);
  scene.object.X_SO = X;
  scene.sense.Find<Tactile>()->fingers[0].X_SF = X * scene.sense.Find<Tactile>()->fingers[0].X_SF;
  TactileSite turned(scene, kCoarse), plain(CubeScene(), kCoarse);
  PressBy(&turned, 1e-3);
  PressBy(&plain, 1e-3);
  const FingerTruth a = turned.truth().fingers[0], b = plain.truth().fingers[0];
  EXPECT_LT((a.force - X.linear() * b.force).norm(), 1e-6 * b.force.norm());
  EXPECT_LT((a.p_S_contact - X * b.p_S_contact).norm(), 1e-9);
  // The skin feels the same in its own frame.
  const TactileFrame fa = turned.TakeSample(Time{}), fb = plain.TakeSample(Time{});
  EXPECT_EQ(fa.fingers[0].electrodes, fb.fingers[0].electrodes);
}

}  // namespace
}  // namespace palpate
