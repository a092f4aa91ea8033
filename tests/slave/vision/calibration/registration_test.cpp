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

TEST(RegistrationTest, WithoutNoiseThePoseIsExact) {
  const StereoRig rig = VergedTestRig(kRigBarrel);
  const auto found = RegisterPair(rig, Tips(rig, 12, 0));
  EXPECT_LT((found.X_SC.translation() - TruePose().translation()).norm(), 1e-6);
  EXPECT_LT(AngleBetween(found.X_SC, TruePose()), 1e-6);
  EXPECT_THAT(found.reasons, IsEmpty());
}

// Reference: chi square. Two sigma contain 86 % of a quantity with two directions (the tilts seen
// by a pair); minus two standard deviations of the count in 200 draws, 5 %. Four positions give the
// depths one degree of freedom.
TEST(RegistrationTest, TheSigmaHoldsWithFewPlacesAsWithMany) {
  const StereoRig rig = VergedTestRig(kRigBarrel);
  constexpr int kDraws = 200;
  for (const int count : {4, 5, 8, 20}) {
    int held = 0;
    for (unsigned seed = 0; seed < kDraws; ++seed) {
      const auto found = RegisterPair(rig, Tips(rig, count, 0.2, 1, 100 + seed));
      const double off = (found.X_SC.translation() - TruePose().translation()).norm();
      held += off < 2 * found.sigma_place &&
                      AngleBetween(found.X_SC, TruePose()) < 2 * found.sigma_angle
                  ? 1
                  : 0;
    }
    EXPECT_GT(held, 0.81 * kDraws) << count;
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
  EXPECT_THAT(RegisterPair(rig, tips).reasons, IsEmpty());
  for (const auto& mirror : MirrorsOf(tips)) {
    EXPECT_THAT(RegisterPair(rig, mirror).reasons, Contains(HasSubstr("mirror image")));
  }
}

// Positions on a plane do not reveal a mirrored table.
TEST(RegistrationTest, PlacesOnAPlaneAreRefused) {
  const StereoRig rig = VergedTestRig(kRigBarrel);
  for (const double thickness : {0.0, 0.001}) {
    EXPECT_THAT(RegisterPair(rig, Tips(rig, 14, 0.2, thickness)).reasons,
                ElementsAre(HasSubstr("nearly coplanar")));
  }
}

TEST(RegistrationTest, OutliersAreLeftOutByName) {
  const StereoRig rig = VergedTestRig(kRigBarrel);
  auto tips = Tips(rig, 15, 0.1);
  tips[3].p_S += Eigen::Vector3d(0.02, 0, 0);
  tips[11].left_I += Eigen::Vector2d(30, 20);
  const auto found = RegisterPair(rig, tips);
  EXPECT_FALSE(found.used[3]);
  EXPECT_FALSE(found.used[11]);
  EXPECT_GE(std::count(found.used.begin(), found.used.end(), true), 11);
  EXPECT_LT(AngleBetween(found.X_SC, TruePose()), 0.5 * kDegree);
  EXPECT_THAT(found.reasons, IsEmpty());
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
}

TEST(RegistrationTest, TooFewOrSenselessPlacesAreRefused) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const StereoRig rig = VergedTestRig();
  auto tips = Tips(rig, 2, 0);
  EXPECT_THROW(RegisterPair(rig, tips), std::runtime_error);
  EXPECT_THROW(RegisterPlane({640, 480}, {}), std::runtime_error);
  tips = Tips(rig, 3, 0);
  EXPECT_THAT(RegisterPair(rig, tips).reasons, Contains(HasSubstr("too few to check the result")));
  tips = Tips(rig, 5, 0);
  for (TipPlace& tip : tips) tip.left_I.x() = kNan;
  EXPECT_THROW(RegisterPair(rig, tips), std::runtime_error);
  EXPECT_THROW(RegisterPlane({640, 480}, tips), std::runtime_error);
  for (TipPlace& tip : tips) tip = {{0, 0, 0}, {100, 100}, std::nullopt};
  EXPECT_THROW(RegisterPair(rig, tips), std::runtime_error);
  EXPECT_THROW(RegisterPlane({640, 480}, tips), std::runtime_error);
}

// Random positions have no common pose; a pose that fits some of them is no agreement.
TEST(RegistrationTest, PlacesThatShareNoPoseAreRefused) {
  const StereoRig rig = VergedTestRig();
  auto tips = Tips(rig, 12, 0);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-0.05, 0.05);
  for (TipPlace& tip : tips) tip.p_S = {place(random), place(random), place(random)};
  EXPECT_FALSE(RegisterPair(rig, tips).reasons.empty());
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
