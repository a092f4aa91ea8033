#include "slave/simulator/camera/simulated_site.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/slave/reference/planar/planar_scenes.h"
#include "tests/support/references.h"

namespace palpate {
namespace {

using simulation::BlockScene;

constexpr double kTop = 0.088;  // the block's surface [m]
constexpr double kMiddle = 0.044;

// Moves the tool along a straight path in a thousand steps.
void Carry(SimulatedSite& site, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  for (int k = 0; k <= 1000; ++k) site.MoveTool(from + k / 1000.0 * (to - from));
}

// Reference: the continuum value for the 5.87 mm indenter at 5 mm. Tolerance: the site's 1e-3.
TEST(SimulatedSite, AFiveMillimetrePressGivesTheContinuumForce) {
  PALPATE_CASE_OR_SKIP(given, "b_block_embryo.json", "block_centre_plane_stress_nu0.49_bonded");
  const double wanted = given["expected"]["force_N_at_5mm"];
  SimulatedSite site(BlockScene());
  Carry(site, {kMiddle, 0.091, 0}, {kMiddle, kTop - 0.005, 0});
  const Truth truth = site.truth();
  EXPECT_TRUE(truth.in_contact);
  EXPECT_NEAR(truth.depth, 0.005, 1e-12);
  EXPECT_NEAR(truth.force.y() / wanted, 1, 1e-3);
  EXPECT_NEAR(truth.force.x() / wanted, 0, 1e-3);
  EXPECT_EQ(truth.force.z(), 0);
}

// Reference: only the position of the tool relative to the body matters. A resting tool on a rising
// body gives exactly the same force as a tool that goes down; only the images differ by a shift.
TEST(SimulatedSite, AMovingBodyMovesItsContact) {
  Scene scene = BlockScene();
  const Eigen::Vector3d above(kMiddle, 0.091, 0), deep(kMiddle, kTop - 3e-3, 0);
  const Eigen::Vector3d nearer(0, 2e-3, 0);
  SimulatedSite resting(scene);
  Carry(resting, above, deep - nearer);
  scene.site.motion = {{0, 2e-3}, 4};
  SimulatedSite moving(scene);
  moving.SetTime(0);
  Carry(moving, above, deep);
  EXPECT_NEAR(moving.truth().depth, 3e-3, 1e-12);
  moving.SetTime(1);  // a quarter of its period
  moving.MoveTool(deep);
  EXPECT_NEAR(moving.truth().depth, 5e-3, 1e-12);
  EXPECT_LT((moving.truth().force - resting.truth().force).norm(), 1e-9);
  EXPECT_EQ(moving.truth().p_S_tip, deep);
  EXPECT_GT(cv::norm(moving.TakeImage(), resting.TakeImage(), cv::NORM_L1), 1e5);
}

// Reference: a circle does not depend on the direction of its shaft. On the same path of its centre
// a round end gives the same force to rounding; only the tip's position differs.
TEST(SimulatedSite, TheForceOfARoundEndDoesNotDependOnItsDirection) {
  constexpr double kEndRadius = 0.005;
  const auto press = [&](double lean) {
    Scene scene = BlockScene();
    scene.tool->shape = Tool::Shape::kRound;
    scene.tool->radius = kEndRadius;
    scene.tool->width = 2 * kEndRadius;
    scene.tool->direction = {std::sin(lean), -std::cos(lean)};
    const Eigen::Vector3d tip = kEndRadius * Eigen::Vector3d(std::sin(lean), -std::cos(lean), 0);
    scene.manipulator.home = Eigen::Vector3d(kMiddle, kTop + 0.012, 0) + tip;
    SimulatedSite site(scene);
    Carry(site, scene.manipulator.home, Eigen::Vector3d(kMiddle, kTop + 0.001, 0) + tip);
    return site.truth();
  };
  const Truth straight = press(0);
  EXPECT_NEAR(straight.depth, 0.004, 1e-12);
  EXPECT_GT(straight.force.norm(), 0.1);
  for (const double lean : {-0.35, 0.15, 0.35}) {
    const Truth leaning = press(lean);
    EXPECT_NEAR(leaning.depth, straight.depth, 1e-12) << lean;
    EXPECT_LT((leaning.force - straight.force).norm(), 1e-9) << lean;
    EXPECT_GT((leaning.p_S_tip - straight.p_S_tip).norm(), 1e-4) << lean;
  }
}

// Reference: frame invariance. If body, tool and motion are rotated together, the force is rotated
// as well.
TEST(SimulatedSite, ATurnedSceneGivesTheTurnedForce) {
  SimulatedSite straight(BlockScene());
  const Eigen::Vector3d from(0.03, 0.09, 0), to(0.031, 0.086, 0);
  Carry(straight, from, to);
  Scene scene = BlockScene();
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()).matrix();
  X.translation() << 0.01, -0.02, 0;
  scene.object.X_SO = X;
  scene.tool->direction = X.linear().topLeftCorner<2, 2>() * scene.tool->direction;
  scene.manipulator.home = X * scene.manipulator.home;
  SimulatedSite turned(scene);
  Carry(turned, X * from, X * to);
  const Eigen::Vector3d force = straight.truth().force;
  EXPECT_GT(force.norm(), 0.5);
  EXPECT_LT((turned.truth().force - X.linear() * force).norm() / force.norm(), 1e-6);
}

}  // namespace
}  // namespace palpate
