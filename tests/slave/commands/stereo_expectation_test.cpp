#include "slave/commands/check/stereo_expectation.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/plate/fit/load_fit.h"
#include "slave/mechanics/plate/plate_surface.h"
#include "slave/vision/dots/dot_layout.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFocal = 800, kBaseline = 0.06, kDistance = 0.25, kSigma = 0.1;

// Paper C's membrane in front of two parallel cameras whose midpoint is on its axis.
Scene WatchedMembrane() {
  Scene scene;
  scene.object.geometry = MembraneGeometry{0.039, 0.001};
  scene.object.material = {.young_modulus = 27.2e6, .poisson_ratio = 0.45};
  scene.tool = Tool{};
  scene.tool->width = 4e-3;
  scene.model.kind = "plate-large";
  scene.manipulator.home = {0, 0, 5e-3};
  scene.operator_options.press_depth = 3e-3;
  scene.sense.Set(PointsOptions{StereoCameras{}, {.sigma = kSigma}});
  scene.sense.Find<StereoCameras>()->X_SL.translation() = Vector3d(-kBaseline / 2, 0, -kDistance);
  return scene;
}

StereoRig ParallelRig() {
  StereoRig rig;
  rig.left = rig.right = {kFocal, kFocal, 319.5, 239.5, {}, {640, 480}};
  rig.X_RL.translation() = Vector3d(-kBaseline, 0, 0);
  return rig;
}

// Reference: parallel cameras, z = f b / d with a disparity d from two positions with sigma each:
// sigma_z = z^2 / (f b) sqrt(2) sigma; x = z (u_l + u_r) / 2f, y alike: sigma_x = z / f sigma /
// sqrt(2), on the axis.
TEST(StereoExpectationTest, DepthIsAsUncertainAsTheDisparity) {
  const auto sight = ExpectedSight(WatchedMembrane(), ParallelRig()).value();
  EXPECT_NEAR(sight.distance, kDistance, 1e-12);
  EXPECT_NEAR(sight.sigma_depth,
              kDistance * kDistance / (kFocal * kBaseline) * std::numbers::sqrt2 * kSigma,
              1e-6 * sight.sigma_depth);
  EXPECT_NEAR(sight.sigma_across, kDistance / kFocal * kSigma / std::numbers::sqrt2,
              1e-6 * sight.sigma_across);
}

// Reference: u = 319.5 + 800 (x +- 30 mm) / 250 mm; the dot's radius of 2 mm is 6.3 px. The left
// image's right edge, 639 px, is at x = 69.8 mm, the right one's left edge at x = -69.8 mm.
TEST(StereoExpectationTest, DotsCountWhereBothImagesShowThemWhole) {
  const std::vector<Vector2d> places{{0, 0},       {0.067, 0},  {0.0685, 0}, {-0.067, 0},
                                     {-0.0685, 0}, {0, 0.0720}, {0, 0.0735}, {0.2, 0}};
  const auto seen = InBothImages(WatchedMembrane(), ParallelRig(), places);
  EXPECT_EQ(seen, (std::vector<Vector2d>{{0, 0}, {0.067, 0}, {-0.067, 0}, {0, 0.0720}}));
}

// Reference: a thousand presses whose dots are moved by noise of that size, each with a fit of its
// own: the spread of a normal sample of 1000 is known to 2.2 % (one sigma), so 10 % is more than
// four.
TEST(StereoExpectationTest, TheForcesSigmaIsTheSpreadOfForcesFittedToNoisyDots) {
  Scene scene = WatchedMembrane();
  scene.model.kind = "plate";  // the quickest, where it holds: well below half the thickness
  scene.operator_options.press_depth = 0.3e-3;
  scene.sense.Find<PointTracking>()->sigma = 0.01;
  const StereoRig rig = ParallelRig();
  const auto places = DotPlaces(*scene.sense.Find<PointTracking>());
  const auto expected = ExpectedForce(scene, rig, places).value();
  ASSERT_NE(expected.validity, Validity::kFailed);

  const auto model = MakeModel(scene, MeshObject(scene, std::nullopt));
  auto& plate = dynamic_cast<PlateSurface&>(*model);
  const PlateSurface::Tool tool{4e-3, scene.tool->IsRigidFace()};
  const Contact press =
      PlateSurface::ToolContact(Contact::Kind::kDisplacement, {0, 0}, tool, -0.3e-3);
  Solution solution;
  plate.Solve({&press, 1}, &solution);
  EXPECT_NEAR(expected.force, -solution.responses()[0].force_O.z(), 1e-3 * expected.force);
  std::vector<double> truth, sigmas, noisy(places.size());
  for (const Vector2d& p : places) {
    truth.push_back(plate.Displacement(solution, p));
    // On parallel cameras the depth's sigma is the same everywhere on a plane z = const.
    sigmas.push_back(kDistance * kDistance / (kFocal * kBaseline) * std::numbers::sqrt2 * 0.01);
  }
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  LoadFitter fitter(plate, tool);
  double sum = 0, squares = 0;
  constexpr int kPresses = 1000;
  for (int i = 0; i < kPresses; ++i) {
    for (std::size_t k = 0; k < noisy.size(); ++k) noisy[k] = truth[k] + sigmas[k] * normal(random);
    const LoadFit fit = fitter.Fit(places, noisy, sigmas);
    ASSERT_NE(fit.validity, Validity::kFailed) << fit.reason;
    const double off = fit.force + expected.force;
    sum += off;
    squares += off * off;
  }
  const double spread = std::sqrt(squares / kPresses - std::pow(sum / kPresses, 2));
  EXPECT_NEAR(spread / expected.sigma, 1.0, 0.1);
}

TEST(StereoExpectationTest, WithoutAMembraneUnderHomeNoForceIsExpected) {
  Scene scene = WatchedMembrane();
  scene.manipulator.home = {0.05, 0, 0.005};
  EXPECT_FALSE(ExpectedForce(scene, ParallelRig(), {{0, 0}}));
  scene.object.geometry = BoxGeometry{{1, 1, 1}, {1, 1, 1}};
  EXPECT_FALSE(ExpectedForce(scene, ParallelRig(), {{0, 0}}));
}

// Two dots determine two unknowns at most: position and force are three.
TEST(StereoExpectationTest, TooFewDotsGiveNoForce) {
  const auto expected = ExpectedForce(WatchedMembrane(), ParallelRig(), {{0, 0}, {0.01, 0}});
  EXPECT_EQ(expected.value().validity, Validity::kFailed);
}

}  // namespace
}  // namespace palpate
