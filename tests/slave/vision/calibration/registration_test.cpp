#include "slave/vision/calibration/registration.h"

#include <limits>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/scene/scene_loader.h"
#include "tests/slave/vision/stereo/test_rigs.h"

namespace palpate {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kDegree = std::numbers::pi / 180;

Eigen::Isometry3d TruePose() {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Vector3d(0.1, -0.2, -0.25);
  X.linear() = (Eigen::AngleAxisd(20 * kDegree, Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(-10 * kDegree, Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(170 * kDegree, Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  return X;
}

// Returns tip positions about 250 mm in front of the left camera, seen with noise `sigma` [px].
// `thickness` 0: on a plane.
std::vector<TipPlace> Tips(const StereoRig& rig, int count, double sigma, double thickness = 1,
                           unsigned seed = 3) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-0.03, 0.03);
  std::normal_distribution<double> noise(0, 1);
  const auto jitter = [&] {
    const double du = noise(random), dv = noise(random);
    return Eigen::Vector2d(sigma * du, sigma * dv);
  };
  std::vector<TipPlace> tips;
  for (int i = 0; i < count; ++i) {
    const double x = place(random), y = place(random), z = place(random);
    const Eigen::Vector3d p_L(x + 0.03, y, 0.25 + thickness * z);
    TipPlace tip;
    tip.p_S = TruePose() * p_L;
    tip.left_I = *Project(rig.left, p_L) + jitter();
    tip.right_I = *Project(rig.right, rig.X_RL * p_L) + jitter();
    tips.push_back(tip);
  }
  return tips;
}

double AngleBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

const std::array<double, 5> kRigBarrel{-0.2, 0.05, 0.001, 0, 0};

TEST(RegistrationTest, WithoutNoiseEveryWayFindsThePose) {
  const StereoRig rig = VergedTestRig(kRigBarrel);
  const auto tips = Tips(rig, 12, 0);
  for (const auto& found : {RegisterPair(rig, tips), RegisterLens(rig.left, tips)}) {
    EXPECT_LT((found.X_SC.translation() - TruePose().translation()).norm(), 1e-6);
    EXPECT_LT(AngleBetween(found.X_SC, TruePose()), 1e-6);
    EXPECT_THAT(found.reasons, IsEmpty());
  }
}

// Reference: chi square. Two sigma contain 86 % of a quantity with two directions (the tilts seen
// by a pair) and 74 % with three; minus two standard deviations of the count in 200 draws, 5 and 6
// %. Four positions give the depths of a pair one degree of freedom, and a single lens two.
TEST(RegistrationTest, TheSigmaHoldsWithFewPlacesAsWithMany) {
  const StereoRig rig = VergedTestRig(kRigBarrel);
  constexpr int kDraws = 200;
  for (const int count : {4, 5, 8, 20}) {
    int pairs = 0, lenses = 0, lens_draws = 0;
    for (unsigned seed = 0; seed < kDraws; ++seed) {
      const auto tips = Tips(rig, count, 0.2, 1, 100 + seed);
      const auto holds = [](const CameraRegistration& found) {
        const double off = (found.X_SC.translation() - TruePose().translation()).norm();
        return off < 2 * found.sigma_place &&
               AngleBetween(found.X_SC, TruePose()) < 2 * found.sigma_angle;
      };
      pairs += holds(RegisterPair(rig, tips)) ? 1 : 0;
      if (count > 5) continue;  // 400 trial poses each take long
      lenses += holds(RegisterLens(rig.left, tips)) ? 1 : 0;
      ++lens_draws;
    }
    EXPECT_GT(pairs, 0.81 * kDraws) << count;
    EXPECT_GE(lenses, 0.68 * lens_draws) << count;
  }
}

// A table with a wrong sign, or with exchanged columns.
std::vector<std::vector<TipPlace>> MirrorsOf(const std::vector<TipPlace>& tips) {
  std::vector<std::vector<TipPlace>> mirrors(4, tips);
  for (std::size_t i = 0; i < tips.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) mirrors[static_cast<std::size_t>(axis)][i].p_S[axis] *= -1;
    std::swap(mirrors[3][i].p_S.x(), mirrors[3][i].p_S.y());
  }
  return mirrors;
}

TEST(RegistrationTest, AMirroredTableOfPlacesInSpaceIsRefused) {
  const StereoRig rig = VergedTestRig(kRigBarrel);
  const auto tips = Tips(rig, 14, 0.2);
  EXPECT_THAT(RegisterPair(rig, tips).warnings, IsEmpty());
  EXPECT_THAT(RegisterLens(rig.left, tips).warnings, IsEmpty());
  for (const auto& mirror : MirrorsOf(tips)) {
    EXPECT_THAT(RegisterPair(rig, mirror).reasons, Contains(HasSubstr("mirror image")));
    EXPECT_THAT(RegisterLens(rig.left, mirror).reasons, Contains(HasSubstr("mirror image")));
  }
}

// Positions on a plane do not reveal a mirrored table; the assumed side of the camera does. The
// true camera looks towards -z of S from 250 mm above the plane.
TEST(RegistrationTest, PlacesOnAPlaneDetermineTheSideOfTheCamera) {
  const StereoRig rig = VergedTestRig(kRigBarrel);
  for (const double thickness : {0.0, 0.001}) {
    const auto tips = Tips(rig, 14, 0.2, thickness);
    for (const auto& found : {RegisterPair(rig, tips), RegisterLens(rig.left, tips)}) {
      EXPECT_LT(AngleBetween(found.X_SC, TruePose()), 4 * found.sigma_angle);
      EXPECT_THAT(found.reasons, IsEmpty());
      EXPECT_THAT(found.warnings,
                  ElementsAre(HasSubstr("where z of S is greater, and looks towards -z")));
    }
    const auto mirrors = MirrorsOf(tips);
    for (const std::size_t k : {0U, 1U, 3U}) {  // a wrong sign of z also reverses the assumed side
      for (const auto& found :
           {RegisterPair(rig, mirrors[k]), RegisterLens(rig.left, mirrors[k])}) {
        EXPECT_THAT(found.reasons, IsEmpty()) << k;
        EXPECT_THAT(found.warnings,
                    ElementsAre(HasSubstr("where z of S is smaller, and looks towards +z")))
            << k;
      }
    }
  }
}

// From afar a plane tilted by 30 deg to one side looks as one tilted to the other.
TEST(RegistrationTest, ASmallPlaneThatMayBeTiltedEitherWayIsRefused) {
  const Lens lens = TestLens();
  std::mt19937 random(4);
  std::normal_distribution<double> noise(0, 0.3);
  const Eigen::AngleAxisd tilt(30 * kDegree, Eigen::Vector3d::UnitX());
  for (const double size : {0.004, 0.04}) {
    std::vector<TipPlace> tips;
    for (const double x : {-1.0, 0.0, 1.0}) {
      for (const double y : {-1.0, 0.0, 1.0}) {
        const Eigen::Vector3d p_C =
            tilt * Eigen::Vector3d(size * x, size * y, 0) + Eigen::Vector3d(0, 0, 0.25);
        const double du = noise(random), dv = noise(random);
        tips.push_back({TruePose() * p_C, *Project(lens, p_C) + Eigen::Vector2d(du, dv), {}});
      }
    }
    const auto found = RegisterLens(lens, tips);
    if (size < 0.01) {
      EXPECT_THAT(found.reasons, Contains(HasSubstr("a second pose")));
    } else {
      EXPECT_THAT(found.reasons, IsEmpty());
    }
  }
}

TEST(RegistrationTest, OutliersAreLeftOutByName) {
  const StereoRig rig = VergedTestRig(kRigBarrel);
  auto tips = Tips(rig, 15, 0.1);
  tips[3].p_S += Eigen::Vector3d(0.02, 0, 0);
  tips[11].left_I += Eigen::Vector2d(30, 20);
  for (const auto& found : {RegisterPair(rig, tips), RegisterLens(rig.left, tips)}) {
    EXPECT_FALSE(found.used[3]);
    EXPECT_FALSE(found.used[11]);
    EXPECT_GE(std::count(found.used.begin(), found.used.end(), true), 11);
    EXPECT_LT(AngleBetween(found.X_SC, TruePose()), 0.5 * kDegree);
    EXPECT_THAT(found.reasons, IsEmpty());
  }
}

TEST(RegistrationTest, PlacesOnALineDefineNoPose) {
  const StereoRig rig = VergedTestRig();
  std::vector<TipPlace> tips;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d p_L(0.01 + 0.006 * i, 0.004 * i, 0.25 + 0.002 * i);
    tips.push_back(
        {TruePose() * p_L, *Project(rig.left, p_L), *Project(rig.right, rig.X_RL * p_L)});
  }
  EXPECT_THAT(RegisterPair(rig, tips).reasons, Contains(HasSubstr("collinear")));
  try {
    EXPECT_THAT(RegisterLens(rig.left, tips).reasons, Contains(HasSubstr("collinear")));
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("collinear"));
  }
}

TEST(RegistrationTest, TooFewOrSenselessPlacesAreRefused) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const StereoRig rig = VergedTestRig();
  auto tips = Tips(rig, 2, 0);
  EXPECT_THROW(RegisterPair(rig, tips), std::runtime_error);
  EXPECT_THROW(RegisterLens(rig.left, tips), std::runtime_error);
  EXPECT_THROW(RegisterPlane({640, 480}, {}), std::runtime_error);
  tips = Tips(rig, 3, 0);
  EXPECT_THAT(RegisterPair(rig, tips).reasons, Contains(HasSubstr("too few to check the result")));
  tips = Tips(rig, 5, 0);
  for (TipPlace& tip : tips) tip.left_I.x() = kNan;
  EXPECT_THROW(RegisterPair(rig, tips), std::runtime_error);
  EXPECT_THROW(RegisterLens(rig.left, tips), std::runtime_error);
  EXPECT_THROW(RegisterPlane({640, 480}, tips), std::runtime_error);
  for (TipPlace& tip : tips) tip = {{0, 0, 0}, {100, 100}, std::nullopt};
  EXPECT_THROW(RegisterPair(rig, tips), std::runtime_error);
  EXPECT_THROW(RegisterPlane({640, 480}, tips), std::runtime_error);
}

// Random positions have no common pose; a pose that fits three of them is no agreement.
TEST(RegistrationTest, PlacesThatShareNoPoseAreRefused) {
  const StereoRig rig = VergedTestRig();
  auto tips = Tips(rig, 12, 0);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-0.05, 0.05);
  for (TipPlace& tip : tips) tip.p_S = {place(random), place(random), place(random)};
  EXPECT_FALSE(RegisterPair(rig, tips).reasons.empty());
  EXPECT_FALSE(RegisterLens(rig.left, tips).reasons.empty());
}

TEST(RegistrationTest, AnImageThatIsMirroredIsReportedToBe) {
  std::vector<TipPlace> straight, mirrored;
  for (const auto& [u, v] : {std::pair{10.0, 20.0}, {600.0, 50.0}, {300.0, 400.0}, {70.0, 350.0}}) {
    straight.push_back({{1e-3 * u, -1e-3 * v, 0}, {u, v}, std::nullopt});
    mirrored.push_back({{1e-3 * u, 1e-3 * v, 0}, {u, v}, std::nullopt});
  }
  const auto found = RegisterPlane({640, 480}, straight);
  EXPECT_NEAR(found.pixel, 1e-3, 1e-12);
  EXPECT_THAT(found.reasons, IsEmpty());
  EXPECT_THAT(RegisterPlane({640, 480}, mirrored).reasons, Contains(HasSubstr("mirror image")));
}

}  // namespace
}  // namespace palpate
