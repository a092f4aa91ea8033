#include "slave/site/camera/simulated_site.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "tests/slave/site/camera/site_scenes.h"
#include "tests/support/references.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using site::BlockScene;
using site::EmbryoScene;

constexpr double kTop = 0.088;  // the block's surface [m]
constexpr double kMiddle = 0.044;

// Carries the tool along a straight way in steps of a thousandth.
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

// Reference: elasticity has no memory. The same place gives the same force on the way in and out,
// and none before and after.
TEST(SimulatedSite, ForceDependsOnThePlaceAlone) {
  SimulatedSite site(BlockScene());
  const Eigen::Vector3d above(kMiddle, 0.0881, 0), half(kMiddle, 0.087, 0), deep(0.046, 0.084, 0);
  Carry(site, above, half);
  const Truth in = site.truth();
  Carry(site, half, deep);
  EXPECT_LT(site.truth().force.x(), 0) << "dragged to the right, the body pulls to the left";
  Carry(site, deep, half);
  const Truth out = site.truth();
  EXPECT_LT((in.force - out.force).norm(), 1e-12);
  EXPECT_NEAR(in.depth, 0.001, 1e-12);
  Carry(site, half, above);
  EXPECT_FALSE(site.truth().in_contact);
  EXPECT_EQ(site.truth().force.norm(), 0);
  EXPECT_EQ(site.truth().depth, 0);
}

TEST(SimulatedSite, TheSurfaceIsWhereTheBodyReallyLies) {
  Scene scene = BlockScene();
  scene.site.misplacement = {0.21e-3, -0.5e-3};
  SimulatedSite site(scene);
  Carry(site, {kMiddle, 0.091, 0}, {kMiddle, kTop - 0.4e-3, 0});
  EXPECT_FALSE(site.truth().in_contact);
  Carry(site, {kMiddle, kTop - 0.4e-3, 0}, {kMiddle, kTop - 0.6e-3, 0});
  EXPECT_TRUE(site.truth().in_contact);
  EXPECT_NEAR(site.truth().depth, 0.1e-3, 1e-12);
}

// Reference: what counts is where the tool is on the body. A tool that stands on one that comes
// nearer presses as one that goes down, to the last bit; the pictures show both elsewhere.
TEST(SimulatedSite, ABodyThatMovesTakesItsContactAlong) {
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
  EXPECT_GT(cv::norm(moving.TakePicture(), resting.TakePicture(), cv::NORM_L1), 1e5);
}

// Reference: frame invariance. Body, tool and motion turned together give the turned force.
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

TEST(SimulatedSite, AnIncompressibleEmbryoPushesBack) {
  SimulatedSite site(EmbryoScene());
  Carry(site, {0.7e-3, 0, 0}, {0.5e-3, 0, 0});
  EXPECT_GT(site.truth().force.x(), 0.01);
  EXPECT_NEAR(site.truth().force.y() / site.truth().force.x(), 0, 1e-2);
}

TEST(SimulatedSite, AJumpIntoTheBodyTouchesWhereItEntered) {
  SimulatedSite site(BlockScene());
  site.MoveTool({kMiddle, 0.091, 0});
  site.MoveTool({kMiddle, 0.084, 0});
  EXPECT_TRUE(site.truth().in_contact);
  EXPECT_NEAR(site.truth().depth, 0.004, 1e-12);
}

TEST(SimulatedSite, AJumpThroughTheBodyTouchesNothing) {
  SimulatedSite site(BlockScene());
  site.MoveTool({kMiddle, 0.1, 0});
  site.MoveTool({kMiddle, -0.1, 0});
  EXPECT_FALSE(site.truth().in_contact);
}

TEST(SimulatedSite, ATipThatStartsInsideTouchesOnlyAfterItHasComeOut) {
  Scene scene = BlockScene();
  scene.manipulator.home = {kMiddle, 0.085, 0};
  SimulatedSite site(scene);
  Carry(site, {kMiddle, 0.085, 0}, {kMiddle, 0.080, 0});
  EXPECT_FALSE(site.truth().in_contact);
  Carry(site, {kMiddle, 0.080, 0}, {kMiddle, 0.090, 0});
  Carry(site, {kMiddle, 0.090, 0}, {kMiddle, 0.087, 0});
  EXPECT_TRUE(site.truth().in_contact);
}

TEST(SimulatedSite, PlacesThatAreNoneAreIgnored) {
  SimulatedSite site(BlockScene());
  const Eigen::Vector3d last(kMiddle, 0.09, 0);
  site.MoveTool(last);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity(), 1e300, -1e300}) {
    site.MoveTool({bad, 0.08, 0});
    site.MoveTool({kMiddle, bad, 0});
    EXPECT_EQ(site.truth().p_S_tip, last);
    EXPECT_FALSE(site.truth().in_contact);
  }
  EXPECT_EQ(site.TakePicture().size(), cv::Size(640, 480));
}

TEST(SimulatedSite, PicturesAreTakenWhileTheToolMoves) {
  SimulatedSite site(BlockScene());
  std::jthread mover([&site](const std::stop_token& stop) {
    for (int k = 0; !stop.stop_requested(); ++k) {
      site.MoveTool({kMiddle, 0.0885 - 0.004 * std::abs(std::sin(1e-3 * k)), 0});
    }
  });
  for (int k = 0; k < 40; ++k) {
    ASSERT_EQ(site.TakePicture().type(), CV_8U);
    ASSERT_TRUE(site.truth().force.allFinite());
  }
}

std::string Refusal(const Scene& scene) {
  return Thrown<std::invalid_argument>([&] { const SimulatedSite site(scene); });
}

TEST(SimulatedSite, RefusalsNameTheKey) {
  Scene scene = BlockScene();
  scene.tool.reset();
  EXPECT_THAT(Refusal(scene), ::testing::HasSubstr("tool.width"));
  scene.tool = Tool{.width = 0};
  EXPECT_THAT(Refusal(scene), ::testing::HasSubstr("tool.width"));
  scene = BlockScene();
  scene.object.geometry = ImageContourGeometry{0.01};
  EXPECT_THAT(Refusal(scene), ::testing::HasSubstr("object.geometry.contour"));
  scene = BlockScene();
  scene.sense = {};
  EXPECT_THAT(Refusal(scene), ::testing::HasSubstr("sense.camera"));
  scene = BlockScene();
  scene.sense.Find<Camera>()->size = {0, 0};
  EXPECT_THAT(Refusal(scene), ::testing::HasSubstr("sense.camera.size"));
  scene = BlockScene();
  scene.sense.Find<Camera>()->pixel = 0;
  EXPECT_THAT(Refusal(scene), ::testing::HasSubstr("sense.camera.pixel"));
  scene = BlockScene();
  scene.object.geometry = PolygonGeometry{{{{0, 0}, {1, 1}, {1, 0}, {0, 0.5}}, {}}, 0.01};
  EXPECT_THAT(Refusal(scene), ::testing::HasSubstr("object."));
}

}  // namespace
}  // namespace palpate
