#include "slave/site/points/stereo_site.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/site/points/painted_membrane.h"
#include "slave/site/points/textured_target.h"
#include "slave/vision/dots/dot_layout.h"
#include "tests/slave/site/points/membrane_scenes.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using site::kCoarse;
using site::MembraneScene;
using site::TargetScene;
using site::WithoutFlaws;
using testing::HasSubstr;

// Where a tool's tip is over the place p_O, `depth` below the rest plane.
Vector3d Tip(const Scene& scene, const Vector2d& p_O, double depth) {
  return scene.object.X_SO * Vector3d(p_O.x(), p_O.y(), -depth);
}

// The rig of the stated scenes written down by hand, not by SimulatedRig().
struct Eye {
  Isometry3d X_CO;
  Vector2d ImageOf(const Vector3d& p_O) const {
    const Vector3d p_C = X_CO * p_O;
    return {319.5 + 800 * p_C.x() / p_C.z(), 239.5 + 800 * p_C.y() / p_C.z()};
  }
};

Eye EyeAt(double x_O) {
  Isometry3d X_OC = Isometry3d::Identity();
  const Vector3d p_O(x_O, 0, -0.25);
  X_OC.linear().col(2) = -p_O.normalized();
  X_OC.linear().col(1) = Vector3d::UnitY();
  X_OC.linear().col(0) = X_OC.linear().col(1).cross(X_OC.linear().col(2));
  X_OC.translation() = p_O;
  return {X_OC.inverse()};
}

// The dot near `at` [px]: dark on light, of a picture without flaws. Its edge is 6.4 px
// from its middle, the rim of the membrane 9.3 px at least.
struct SeenDot {
  Vector2d centre;
  double area = 0;  // [px^2]
};

SeenDot DotNear(const cv::Mat& picture, const Vector2d& at) {
  const int x0 = static_cast<int>(std::lround(at.x())), y0 = static_cast<int>(std::lround(at.y()));
  const double ground = site::MembraneView::kRubber;
  double sum = 0;
  Vector2d moment(0, 0);
  for (int y = y0 - 10; y <= y0 + 10; ++y) {
    for (int x = x0 - 10; x <= x0 + 10; ++x) {
      if ((Vector2d(x, y) - at).norm() > 8.5) continue;
      const double share = ground - picture.at<uchar>(y, x);
      sum += share;
      moment += share * Vector2d(x, y);
    }
  }
  return {moment / sum, sum / (ground - site::DottedMembrane::kDot)};
}

// Mean picture place of the disc at centre_O, by area in the picture: rings cut into cells. It lies
// where the true centre is and across the surface's normal there.
SeenDot DiscSeen(const StereoSite& site, const Eye& eye, const Vector2d& centre_O) {
  constexpr int kRings = 24, kTurns = 48;
  constexpr double kRadius = 0.002, kThickness = 0.001, kStep = 3e-5;
  const auto place = [&](const Vector2d& p) {
    return Vector3d(Vector3d(p.x(), p.y(), -kThickness) + site.TrueDisplacement(p));
  };
  const Vector2d dx(kStep, 0), dy(0, kStep);
  const Vector3d n = (place(centre_O + dx) - place(centre_O - dx))
                         .cross(place(centre_O + dy) - place(centre_O - dy))
                         .normalized();
  const Vector3d across = n.unitOrthogonal(), other = n.cross(across), middle = place(centre_O);
  const auto see = [&](double r, double angle) {
    return eye.ImageOf(middle + r * (std::cos(angle) * across + std::sin(angle) * other));
  };
  Vector2d moment(0, 0);
  double sum = 0;
  for (int i = 0; i < kRings; ++i) {
    for (int k = 0; k < kTurns; ++k) {
      const double r0 = kRadius * i / kRings, r1 = kRadius * (i + 1) / kRings;
      const double a0 = 2 * std::numbers::pi * k / kTurns;
      const double a1 = 2 * std::numbers::pi * (k + 1) / kTurns;
      const Vector2d p = see(r1, a1) - see(r0, a0), q = see(r0, a1) - see(r1, a0);
      const double area = 0.5 * std::abs(p.x() * q.y() - p.y() * q.x());  // by the diagonals
      sum += area;
      moment += area * see(0.5 * (r0 + r1), 0.5 * (a0 + a1));
    }
  }
  return {moment / sum, sum};
}

struct Press {
  const char* name;
  Vector2d p_O;
  double depth;
};

class MembranePictureTest : public testing::TestWithParam<Press> {};

// Reference: discs on the true surface, projected through the rig written down by hand, with the
// area that they have in the picture (the known bias of circles is in it). Tolerance: rounding to 8
// bit moves the centroid of the 128 px of a dot by less than 0.01 px and its area by less than
// 0.5 %, the reference's cells by 0.002 px and 0.3 %.
TEST_P(MembranePictureTest, DotsLieWhereTheTruthProjectsThem) {
  const Press press = GetParam();
  Scene scene = WithoutFlaws(MembraneScene());
  scene.manipulator.home = Tip(scene, press.p_O, -5e-3);
  StereoSite site(scene, kCoarse);
  site.MoveTool(Tip(scene, press.p_O, press.depth));
  const StereoPictures pictures = site.TakePictures();
  const std::array<Eye, 2> eyes{EyeAt(-0.03), EyeAt(0.03)};
  double worst = 0, worst_area = 0, moved = 0;
  for (const Vector2d& p_O : DotPlaces(*scene.sense.Find<PointTracking>())) {
    for (std::size_t e = 0; e < 2; ++e) {
      const SeenDot expected = DiscSeen(site, eyes[e], p_O);
      const cv::Mat& picture = e == 0 ? pictures.left : pictures.right;
      const SeenDot dot = DotNear(picture, expected.centre);
      worst = std::max(worst, (dot.centre - expected.centre).norm());
      worst_area = std::max(worst_area, std::abs(dot.area / expected.area - 1));
      moved =
          std::max(moved, (expected.centre - eyes[e].ImageOf({p_O.x(), p_O.y(), -0.001})).norm());
    }
  }
  EXPECT_LT(worst, 0.02);
  EXPECT_LT(worst_area, 0.01);
  EXPECT_GT(moved, press.depth > 0 ? 300 * press.depth : -1) << "the dots did not move";
}

INSTANTIATE_TEST_SUITE_P(Presses, MembranePictureTest,
                         testing::Values(Press{"rest", {0, 0}, -1e-3},
                                         Press{"centre", {0, 0}, 4e-3},
                                         Press{"eccentric", {0.0117 * 0.6, 0.0117 * 0.8}, 2e-3}),
                         [](const auto& press) { return press.param.name; });

// Reference: the law of action and reaction along the normal, and a frictionless tool: no force
// along the surface; none without contact. Deeper is stiffer.
TEST(StereoSite, TheToolIsPushedBackAlongTheNormal) {
  Scene scene = MembraneScene();
  scene.object.X_SO.linear() =
      Eigen::AngleAxisd(0.3, Vector3d(1, 2, 0).normalized()).toRotationMatrix();
  scene.sense.Find<StereoCameras>()->X_SL = site::LeftEye(scene.object.X_SO);
  scene.manipulator.home = Tip(scene, {0, 0}, -5e-3);
  StereoSite site(scene, kCoarse);
  EXPECT_FALSE(site.truth().in_contact);
  EXPECT_EQ(site.truth().force, Vector3d::Zero());
  double before = 0, slope = 0;
  for (const double depth : {0.5e-3, 1e-3, 1.5e-3, 2e-3}) {
    site.MoveTool(Tip(scene, {0, 0}, depth));
    const Truth truth = site.truth();
    EXPECT_TRUE(truth.in_contact && truth.solved);
    EXPECT_NEAR(truth.depth, depth, 1e-12);
    const Vector3d f_O = scene.object.X_SO.linear().transpose() * truth.force;
    EXPECT_NEAR(f_O.head<2>().norm(), 0, 1e-9 * f_O.z());
    EXPECT_GT(f_O.z() - before, slope);
    slope = f_O.z() - before;
    before = f_O.z();
  }
  site.MoveTool(Tip(scene, {0, 0}, -1e-4));
  EXPECT_FALSE(site.truth().in_contact);
  EXPECT_EQ(site.truth().force, Vector3d::Zero());
  EXPECT_EQ(site.truth().depth, 0);
  site.MoveTool(Tip(scene, {0.0395, 0}, 1e-3));
  EXPECT_FALSE(site.truth().in_contact) << "beyond the rim";
}

// Reference: a round membrane looks the same from all sides; and a press nearer to the rim is
// stiffer.
TEST(StereoSite, ForceDependsOnTheRadiusAloneAndGrowsTowardsTheRim) {
  Scene scene = MembraneScene();
  scene.operator_options.press_depth = 1e-3;
  scene.manipulator.home = Tip(scene, {0.012, 0}, -5e-3);
  StereoSite site(scene, kCoarse);
  const auto force = [&](const Vector2d& p_O) {
    site.MoveTool(Tip(scene, p_O, 1e-3));
    return site.truth().force.norm();
  };
  const double there = force({0.012, 0});
  EXPECT_NEAR(force({0, 0.012}) / there, 1, 1e-12);
  EXPECT_NEAR(force({-0.012 * 0.6, -0.012 * 0.8}) / there, 1, 1e-12);
  site.MoveTool(Tip(scene, {0, 0.012}, 1e-3));
  const Vector3d u = site.TrueDisplacement({0, 0.008});
  site.MoveTool(Tip(scene, {0.012, 0}, 1e-3));
  const Vector3d v = site.TrueDisplacement({0.008, 0});
  EXPECT_NEAR((u - Vector3d(-v.y(), v.x(), v.z())).norm(), 0, 1e-9) << "turned by a right angle";
  EXPECT_LT(u.z(), -0.5e-3);
  EXPECT_GT(force({0.0135, 0}), 1.01 * there);
}

// Reference: a sheet under tension N resists a push as a string does, by N times its slopes: a
// membrane that is tight at rest is stiffer, by a force that grows with the depth.
TEST(StereoSite, TensionAtRestStiffens) {
  Scene scene = MembraneScene();
  scene.operator_options.press_depth = 1e-3;
  StereoSite slack(scene, kCoarse);
  scene.model.prestress = 500;
  StereoSite tight(scene, kCoarse);
  double before = 0;
  for (const double depth : {0.3e-3, 0.6e-3}) {
    for (StereoSite* site : {&slack, &tight}) site->MoveTool(Tip(scene, {0, 0}, depth));
    const double more = tight.truth().force.z() - slack.truth().force.z();
    // Point load on a round membrane, w = F ln(a / r) / (2 pi N), under the tool's edge; the
    // plate's bending shares the way.
    EXPECT_GT(more, 0.5 * 2 * std::numbers::pi * 500 * depth / std::log(39.0 / 2));
    EXPECT_GT(more, 1.5 * before);
    before = more;
  }
}

// Reference: the press solved at that very place. Tolerance: half a raster from both neighbours the
// worst measured are 1e-3 of the depth and 4.5e-3 of the force; fields that are not carried to the
// tool's place are off by 1e-2.
TEST(StereoSite, PressesBetweenTheSolvedRadiiAreBlendedWithinHalfAPercent) {
  const double radius = 0.0105;
  Scene scene = MembraneScene();
  scene.operator_options.press_depth = 1e-3;
  StereoSite blended(scene, kCoarse);
  scene.manipulator.home = Tip(scene, {radius, 0}, -5e-3);
  StereoSite exact(scene, kCoarse);
  for (StereoSite* site : {&blended, &exact}) site->MoveTool(Tip(scene, {radius, 0}, 1e-3));
  EXPECT_NEAR(blended.truth().force.norm() / exact.truth().force.norm(), 1, 0.006);
  double worst = 0;
  for (int k = -36; k <= 36; ++k) {
    const Vector2d p_O(1e-3 * k, 0.5e-3);
    worst = std::max(worst, (blended.TrueDisplacement(p_O) - exact.TrueDisplacement(p_O)).norm());
  }
  EXPECT_LT(worst, 0.003 * 1e-3);
}

// Reference: the press on the finest mesh in use, with twice as many rungs. Tolerances: what the
// header states; measured are 0.12 % and 8 um at worst, most of it the mesh's.
TEST(StereoSite, PressesAwayFromHomeAreAsGoodAsStated) {
  const double radius = 0.018;  // six rasters: nothing is blended
  const Scene scene = MembraneScene();
  site::PressedMembrane fine(std::get<MembraneGeometry>(scene.object.geometry),
                             scene.object.material, scene.tool->width, {radius, 0});
  std::vector<double> rungs{0.1e-3, 0.25e-3};
  for (int k = 1; k <= 12; ++k) rungs.push_back(0.5e-3 * k);
  for (const double depth : rungs) ASSERT_TRUE(fine.Deepen(depth));
  StereoSite site(scene);
  for (const double depth : {0.15e-3, 0.4e-3, 0.8e-3, 1.55e-3, 2.4e-3, 3.3e-3, 4.6e-3}) {
    site.MoveTool(Tip(scene, {radius, 0}, depth));
    EXPECT_NEAR(site.truth().force.norm() / -site::ForceAt(fine.press(), depth), 1, 0.002) << depth;
    double worst = 0;
    for (int k = -38; k <= 38; ++k) {
      const Vector2d p_O(1e-3 * k, 1e-3);
      const Vector3d u = site::DisplacementAt(fine.press(), p_O, depth);
      worst = std::max(worst, (site.TrueDisplacement(p_O) - u).norm());
    }
    EXPECT_LT(worst, 10e-6) << depth;
  }
}

// Reference: a press that is read late is the press that was waited for.
TEST(StereoSite, WhatIsTrueDoesNotDependOnHowFarTheThreadHasCome) {
  Scene scene = MembraneScene();
  scene.operator_options.press_depth = 1e-3;
  StereoSite waited(scene, kCoarse), late(scene, kCoarse);
  waited.MoveTool(Tip(scene, {0, 0}, 0.35e-3));
  late.MoveTool(Tip(scene, {0, 0}, 1e-3));
  late.MoveTool(Tip(scene, {0, 0}, 0.35e-3));
  EXPECT_EQ(waited.truth().force, late.truth().force);
  EXPECT_EQ(waited.TrueDisplacement({0.01, 0.01}), late.TrueDisplacement({0.01, 0.01}));
}

// Where a tool is that slides along x at the manipulator's rate, step by step.
constexpr double kSlideStep = 8e-3 / 1000;  // 8 mm/s at 1 kHz [m]

// Reference: the definition of ahead. No step waits or is guessed, and the force has no jump: per
// step it grows by less than 0.1 % (it doubles over 20 mm, so by 0.03 % on average; between
// neighbouring solved radii it grows by some 5 %).
TEST(StereoSite, ASlideOverSolvedPressesNeitherWaitsNorJumps) {
  Scene scene = MembraneScene();
  scene.operator_options.press_depth = 3e-3;
  StereoSite site(scene, kCoarse);
  for (double x = 0; x < 0.0215; x += 1e-3) site.MoveTool(Tip(scene, {x, 0}, 3e-3));
  const std::uint64_t waits = site.waits();
  EXPECT_GT(waits, 0U);
  double before = 0, largest = 0;
  int guessed = 0;
  for (double x = 0; x <= 0.02; x += kSlideStep) {
    site.MoveTool(Tip(scene, {x, 0}, 3e-3), Patience::kNone);
    const Truth truth = site.truth();
    guessed += truth.solved ? 0 : 1;
    const double force = truth.force.norm();
    if (before > 0) largest = std::max(largest, std::abs(force / before - 1));
    before = force;
    site.MoveTool(Tip(scene, {x, 0}, 3e-3));
    ASSERT_EQ(site.truth().force.norm(), force) << "both ways of moving tell the same";
  }
  EXPECT_EQ(guessed, 0);
  EXPECT_EQ(site.waits(), waits);
  EXPECT_LT(largest, 1e-3);
}

// Reference: the same press, waited for. What is guessed has the right sign and order: a press at
// the centre is half as stiff as one at half the radius.
TEST(StereoSite, WhereNothingIsSolvedTheToolMovesOnAndTheTruthSaysSo) {
  Scene scene = MembraneScene();
  scene.operator_options.press_depth = 1e-3;
  StereoSite site(scene, kCoarse);
  site.MoveTool(Tip(scene, {0, 0}, 1e-3));
  const std::uint64_t waits = site.waits();
  const Vector3d tip = Tip(scene, {0.02, 0}, 1e-3);
  site.MoveTool(tip, Patience::kNone);  // 20 mm are beyond what a tool at the centre has solved
  EXPECT_EQ(site.waits(), waits);
  const Truth guess = site.truth();
  EXPECT_FALSE(guess.solved);
  EXPECT_TRUE(guess.in_contact);
  EXPECT_EQ(guess.p_S_tip, tip);
  EXPECT_NEAR(site.TrueDisplacement({0.02, 0}).z(), -1e-3, 2e-5) << "the tool's place is kept";
  site.MoveTool(tip);
  EXPECT_EQ(site.waits(), waits + 1);
  EXPECT_TRUE(site.truth().solved);
  EXPECT_GT(guess.force.z(), 0.4 * site.truth().force.z());
  EXPECT_LT(guess.force.z(), site.truth().force.z());
  site.MoveTool(tip, Patience::kNone);
  EXPECT_TRUE(site.truth().solved);
}

// Reference: the press depth of the scene, anywhere the tool can be.
TEST(StereoSite, PressesEverywhereAreSolvedWhileTheToolRests) {
  Scene scene = MembraneScene();
  scene.operator_options.press_depth = 0.2e-3;
  StereoSite site(scene, kCoarse);
  site.SolveEverywhere();
  while (!site.is_solved_everywhere()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  for (double x = 0; x < 0.029; x += 1e-3) {
    site.MoveTool(Tip(scene, {0, x}, 0.2e-3), Patience::kNone);
    EXPECT_TRUE(site.truth().solved) << x;
  }
  EXPECT_EQ(site.waits(), 0U);
}

// On its own fine mesh the site has a dozen presses of a second each before it when it is told to
// go: it must not finish them.
TEST(StereoSite, ASiteThatIsStillSolvingCanGo) {
  Scene scene = MembraneScene();
  StereoSite site(scene);
  site.SolveEverywhere();
  site.MoveTool(Tip(scene, {0.02, 0}, 3e-3), Patience::kNone);
  EXPECT_FALSE(site.truth().solved);
  EXPECT_FALSE(site.is_solved_everywhere());
}

TEST(StereoSite, TooDeepAndTooNearTheRimSaySo) {
  Scene scene = MembraneScene();
  scene.operator_options.press_depth = 0.5e-3;  // presses are solved to 0.8 mm
  StereoSite site(scene, kCoarse);
  site.MoveTool(Tip(scene, {0, 0}, 0.79e-3));
  EXPECT_TRUE(site.truth().solved);
  const double force = site.truth().force.norm();
  site.MoveTool(Tip(scene, {0, 0}, 0.9e-3));
  EXPECT_FALSE(site.truth().solved);
  EXPECT_GT(site.truth().force.norm(), force);
  EXPECT_LT(site.truth().force.norm(), 2 * force);
  EXPECT_NEAR(site.truth().depth, 0.9e-3, 1e-15);
  site.MoveTool(Tip(scene, {0.035, 0}, 0.2e-3));
  EXPECT_TRUE(site.truth().in_contact);
  EXPECT_FALSE(site.truth().solved);
  EXPECT_TRUE(std::isfinite(site.truth().force.norm()));
  site.MoveTool({std::numeric_limits<double>::quiet_NaN(), 0, 0});
  site.MoveTool({1e300, 0, 0});
  EXPECT_EQ(site.truth().p_S_tip, Tip(scene, {0.035, 0}, 0.2e-3)) << "no tool is there";
}

TEST(StereoSite, TheSameCallsGiveTheSamePictures) {
  Scene scene = MembraneScene();
  scene.operator_options.press_depth = 0.5e-3;
  for (const auto track : {PointTracking::Track::kDots, PointTracking::Track::kTexture}) {
    scene.sense.Find<PointTracking>()->track = track;
    StereoSite a(scene, kCoarse), b(scene, kCoarse);
    Scene reseeded = scene;
    reseeded.site.seed = 2;
    StereoSite other(reseeded, kCoarse);
    for (const double depth : {-1e-3, 0.3e-3}) {
      for (StereoSite* site : {&a, &b, &other}) site->MoveTool(Tip(scene, {0.001, 0}, depth));
      const StereoPictures of_a = a.TakePictures(), of_b = b.TakePictures();
      EXPECT_EQ(cv::norm(of_a.left, of_b.left), 0);
      EXPECT_EQ(cv::norm(of_a.right, of_b.right), 0);
      EXPECT_GT(cv::norm(of_a.left, other.TakePictures().left), 0) << "another seed";
    }
  }
}

// Reference: the scene's own numbers. Two pictures of a world at rest differ by two draws of the
// noise; the light falls by `lighting` from the upper left to the lower right corner.
TEST(StereoSite, NoiseLightAndBlurAreAsTheSceneSays) {
  Scene scene = MembraneScene();
  scene.site.flicker = 0;
  StereoSite site(scene, kCoarse);
  const StereoPictures first = site.TakePictures(), second = site.TakePictures();
  for (const auto& [a, b] : {std::pair{first.left, second.left}, {first.left, first.right}}) {
    cv::Mat x, y;
    const cv::Rect corner(4, 4, 120, 60);  // plain in both eyes
    a(corner).convertTo(x, CV_32F);
    b(corner).convertTo(y, CV_32F);
    cv::Scalar mean, deviation;
    cv::meanStdDev(x - y, mean, deviation);
    // Rounding adds 1 / 12 to the variance of each.
    EXPECT_NEAR(deviation[0], std::sqrt(2 * (4 + 1.0 / 12)), 0.1);
    EXPECT_NEAR(mean[0], 0, 0.15);
  }
  const auto grey = [&](int x, int y) { return cv::mean(first.left({x, y, 24, 24}))[0]; };
  EXPECT_NEAR(grey(0, 0) / site::MembraneView::kBeyond, 1, 0.03);
  EXPECT_NEAR(grey(616, 456) / grey(0, 0), 0.85, 0.03);
}

TEST(StereoSite, ADotTellsTheBlur) {
  Scene sharp = WithoutFlaws(MembraneScene()), soft = sharp;
  soft.site.blur = 0.7;
  const cv::Mat of_sharp = StereoSite(sharp, kCoarse).TakePictures().left;
  const cv::Mat of_soft = StereoSite(soft, kCoarse).TakePictures().left;
  cv::Mat expected;
  of_sharp.convertTo(expected, CV_32F);
  cv::GaussianBlur(expected, expected, {7, 7}, 0.7);
  cv::Mat difference;
  cv::absdiff(expected, cv::Mat_<float>(of_soft), difference);
  double worst = 0;
  cv::minMaxLoc(difference, nullptr, &worst);
  EXPECT_LT(worst, 1.6) << "rounding twice and the cut of the reference's kernel";
  cv::absdiff(cv::Mat_<float>(of_sharp), cv::Mat_<float>(of_soft), difference);
  cv::minMaxLoc(difference, nullptr, &worst);
  EXPECT_GT(worst, 20);
}

// Reference: the path of paper C as its formula is printed, with the time of the pictures.
TEST(StereoSite, TheTargetFollowsItsPathAPeriodPerPair) {
  Scene scene = TargetScene();
  scene.site.pace = 3;
  StereoSite site(scene, kCoarse);
  ASSERT_TRUE(site.target());
  const auto path = [&](int picture) {
    const double t = 3 * picture / 30.0;
    return Vector3d(scene.object.X_SO *
                    (0.010 * Vector3d(std::cos(t), std::sin(t), std::cos(t) + std::sin(t))));
  };
  const Vector3d p_S_first = path(0) + Vector3d(0.01, 0.005, -0.02);
  for (int k = 0; k < 5; ++k) {
    site.TakePictures();
    EXPECT_NEAR(site.target()->seconds, k / 30.0, 1e-12);
    EXPECT_NEAR((site.target()->X_SB.translation() - path(k)).norm(), 0, 1e-12);
    EXPECT_NEAR((site.target()->PlaceOf(p_S_first) - p_S_first - path(k) + path(0)).norm(), 0,
                1e-12);
  }
  EXPECT_FALSE(site.truth().in_contact);
}

// Reference: SSD of windows: what is printed on the body stands in the second picture where the
// pose says. The best whole-pixel match lies within a pixel of the projection.
TEST(StereoSite, TheTargetsTextureMovesWithIt) {
  Scene scene = TargetScene();
  StereoSite site(scene, kCoarse);
  const cv::Mat first = site.TakePictures().left;
  const TargetTruth before = *site.target();
  for (int k = 0; k < 10; ++k) site.TakePictures();
  const cv::Mat last = site.TakePictures().left;
  const site::TexturedTarget target({});
  const Isometry3d X_LS = scene.sense.Find<StereoCameras>()->X_SL.inverse();
  for (const Vector2d& p_I : {Vector2d(340, 250), Vector2d(320, 280), Vector2d(380, 230)}) {
    const auto p_B = target.PointAt(site.rig().left, X_LS * before.X_SB, p_I);
    ASSERT_TRUE(p_B);
    const auto expected = Project(site.rig().left, X_LS * site.target()->X_SB * *p_B);
    const cv::Point corner(static_cast<int>(p_I.x()) - 15, static_cast<int>(p_I.y()) - 15);
    cv::Mat score;
    cv::matchTemplate(last, first({corner, cv::Size(31, 31)}), score, cv::TM_SQDIFF);
    cv::Point best;
    cv::minMaxLoc(score, nullptr, nullptr, &best);
    EXPECT_NEAR(best.x + 15, expected->x(), 1);
    EXPECT_NEAR(best.y + 15, expected->y(), 1);
    EXPECT_GT((*expected - p_I).norm(), 3) << "nothing moved";
  }
}

// Reference: the projection of the truth. A window of the picture at rest is found again there, and
// not where it was: the noise of two pictures remains, sqrt(2) sigma.
TEST(StereoSite, TheMembranesTextureMovesWithIt) {
  Scene scene = MembraneScene();
  scene.sense.Find<PointTracking>()->track = PointTracking::Track::kTexture;
  scene.operator_options.press_depth = 3e-3;
  scene.site.flicker = 0;
  StereoSite site(scene, kCoarse);
  EXPECT_FALSE(site.target());
  const cv::Mat rest = site.TakePictures().right;
  site.MoveTool(Tip(scene, {0, 0}, 3e-3));
  const cv::Mat pressed = site.TakePictures().right;
  const Eye eye = EyeAt(0.03);
  const auto window = [](const cv::Mat& picture, const Vector2d& p_I) {
    cv::Mat part;
    const cv::Point2f centre(static_cast<float>(p_I.x()), static_cast<float>(p_I.y()));
    cv::getRectSubPix(picture, {9, 9}, centre, part, CV_32F);
    return part;
  };
  for (const Vector2d& p_O : {Vector2d(0.009, 0.004), Vector2d(-0.007, 0.01)}) {
    const Vector3d p(p_O.x(), p_O.y(), -0.001);
    const Vector2d from = eye.ImageOf(p), to = eye.ImageOf(p + site.TrueDisplacement(p_O));
    const cv::Mat before = window(rest, from);
    const double there = cv::norm(before, window(pressed, to)) / 9;
    const double stayed = cv::norm(before, window(pressed, from)) / 9;
    EXPECT_LT(there, 6) << p_O.transpose();
    EXPECT_GT(stayed, 2.5 * there) << p_O.transpose();
  }
}

std::string Refusal(const Scene& scene) {
  return Thrown<std::invalid_argument>([&] { const StereoSite site(scene, kCoarse); });
}

TEST(StereoSite, ScenesThatCannotBeSimulatedNameTheKey) {
  const auto refusal = [](const auto& spoil) {
    Scene scene = MembraneScene();
    spoil(scene);
    return Refusal(scene);
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal([](Scene& s) { s.sense = {}; }), HasSubstr("sense.camera"));
  EXPECT_THAT(refusal([](Scene& s) { s.sense.Set(PointsOptions{.eyes = DepthPictures{}}); }),
              HasSubstr("sense.camera"));
  EXPECT_THAT(refusal([](Scene& s) {
                s.sense.Find<PointTracking>()->track = PointTracking::Track::kSurface;
              }),
              HasSubstr("sense.points.track"));
  EXPECT_THAT(refusal([](Scene& s) { s.sense.Find<PointTracking>()->count = 300; }),
              HasSubstr("sense.points"));
  EXPECT_THAT(refusal([](Scene& s) { s.sense.Find<PointTracking>()->count = 0; }),
              HasSubstr("count"));
  EXPECT_THAT(refusal([](Scene& s) { s.sense.Find<PointTracking>()->dot_radius = 0; }),
              HasSubstr("sense.points.radius"));
  EXPECT_THAT(refusal([](Scene& s) { s.sense.Find<PointTracking>()->dot_radius = kNan; }),
              HasSubstr("sense.points.radius"));
  EXPECT_THAT(refusal([](Scene& s) { s.tool.reset(); }), HasSubstr("tool.width"));
  EXPECT_THAT(refusal([](Scene& s) { s.tool->width = 0.1; }), HasSubstr("tool.width"));
  EXPECT_THAT(refusal([](Scene& s) { s.operator_options.press_depth = 0; }),
              HasSubstr("operator.press.depth"));
  EXPECT_THAT(refusal([](Scene& s) { s.object.geometry = BoxGeometry{}; }),
              HasSubstr("object.geometry"));
  EXPECT_THAT(refusal([](Scene& s) { s.sense.Find<StereoCameras>()->focal = 0; }),
              HasSubstr("focal"));
  EXPECT_THAT(refusal([](Scene& s) { s.sense.Find<StereoCameras>()->baseline = 0; }),
              HasSubstr("baseline"));
  EXPECT_THAT(refusal([](Scene& s) { s.sense.Find<StereoCameras>()->baseline = kNan; }),
              HasSubstr("baseline"));
  EXPECT_THAT(refusal([](Scene& s) { s.sense.Find<StereoCameras>()->baseline = 1; }),
              HasSubstr("baseline"));
  EXPECT_THAT(refusal([](Scene& s) {
                s.sense.Find<StereoCameras>()->size = {0, 480};
              }),
              HasSubstr("size"));
  EXPECT_THAT(refusal([](Scene& s) { s.sense.Find<StereoCameras>()->rate = 0; }),
              HasSubstr("rate"));
  EXPECT_THAT(refusal([](Scene& s) { s.sense.Find<StereoCameras>()->X_SL.translation().x() += 1; }),
              HasSubstr("sense.camera.pose"));
  EXPECT_EQ(Refusal(MembraneScene()), "");
}

}  // namespace
}  // namespace palpate
