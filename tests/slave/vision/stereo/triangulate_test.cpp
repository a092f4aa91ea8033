#include <cmath>
#include <limits>
#include <random>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "slave/vision/stereo/rig.h"
#include "tests/slave/vision/stereo/test_rigs.h"
#include "tests/support/references.h"

namespace palpate {
namespace {

Eigen::Vector3d Vector3(const nlohmann::json& numbers) {
  return {numbers.at(0).get<double>(), numbers.at(1).get<double>(), numbers.at(2).get<double>()};
}

TEST(TriangulateTest, AgreesWithTheReferenceOfAParallelRig) {
  PALPATE_CASE_OR_SKIP(reference, "g_vision.json", "stereo_parallel");
  const auto& given = reference.at("params");
  StereoRig rig;
  rig.left = rig.right = TestLens();
  rig.X_RL.translation().x() = -given.at("baseline_m").get<double>();
  const double v = given.at("vL"), uL = given.at("uL"), uR = given.at("uR");
  const auto point = Triangulate(rig, {uL, v}, {uR, v}, 1);
  ASSERT_TRUE(point);
  EXPECT_LT((point->p_L - Vector3(reference.at("expected").at("X"))).norm(), 1e-12);
  EXPECT_LT(std::abs(point->miss_px), 1e-9);
  // dZ = Z^2 / (f B) per pixel of disparity, whose sigma is sqrt 2 pixels. The images' rows and the
  // common part of their columns also contribute, but not to z along the ray in this rig.
  const double per_pixel = reference.at("expected").at("depth_error_per_pixel_m");
  EXPECT_NEAR(std::sqrt(point->covariance(2, 2)), std::sqrt(2.0) * per_pixel, 1e-6);
}

TEST(TriangulateTest, AgreesWithTheReferenceOfAVergedRig) {
  PALPATE_CASE_OR_SKIP(reference, "g_vision.json", "stereo_verged");
  const auto& given = reference.at("params");
  StereoRig rig;
  rig.left = rig.right = TestLens();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) rig.X_RL.linear()(i, j) = given.at("R_rows").at(i).at(j);
  }
  rig.X_RL.translation() = -(rig.X_RL.linear() * Vector3(given.at("C_right_m")));
  const auto at = [&](const char* key) {
    return Eigen::Vector2d(given.at(key).at(0).get<double>(), given.at(key).at(1).get<double>());
  };
  const auto point = Triangulate(rig, at("left"), at("right"), 1);
  ASSERT_TRUE(point);
  EXPECT_LT((point->p_L - Vector3(reference.at("expected").at("X"))).norm(), 1e-10);
}

// Monte Carlo of 20 000 noisy images: a variance scatters by sqrt(2 / n) = 1 %, so four sigma are
// 4 %; along every axis of the ellipsoid, that is, in the metric of the stated covariance.
TEST(TriangulateTest, TheCovarianceIsThatOfNoisyImages) {
  const StereoRig rig = VergedTestRig({-0.2, 0.05, 0.001, 0, 0});
  const Eigen::Vector3d p_L(0.03, -0.03, 0.24);
  const auto left = *Project(rig.left, p_L), right = *Project(rig.right, rig.X_RL * p_L);
  const double sigma = 0.3;
  const auto stated = Triangulate(rig, left, right, sigma);
  ASSERT_TRUE(stated);
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, sigma);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const Eigen::Vector2d a = left + Eigen::Vector2d(noise(random), noise(random));
    const Eigen::Vector2d b = right + Eigen::Vector2d(noise(random), noise(random));
    const auto point = Triangulate(rig, a, b, sigma);
    ASSERT_TRUE(point);
    const Eigen::Vector3d d = point->p_L - p_L;
    scatter += d * d.transpose() / kCount;
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix3d> ratio(scatter,
                                                                        stated->covariance);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(ratio.eigenvalues()[i], 1, 0.04) << i;
}

// Reference: no point nearby has a smaller sum of squared errors.
TEST(TriangulateTest, NoNeighbourFitsTheImagesBetter) {
  const StereoRig rig = VergedTestRig({-0.2, 0.05, 0.001, 0, 0});
  const Eigen::Vector3d p_L(0.02, 0.01, 0.26);
  const Eigen::Vector2d left = *Project(rig.left, p_L) + Eigen::Vector2d(0, 2);
  const Eigen::Vector2d right = *Project(rig.right, rig.X_RL * p_L) + Eigen::Vector2d(1, -2);
  const auto misses = [&](const Eigen::Vector3d& p) {
    return (*Project(rig.left, p) - left).squaredNorm() +
           (*Project(rig.right, rig.X_RL * p) - right).squaredNorm();
  };
  const auto point = Triangulate(rig, left, right, 1);
  ASSERT_TRUE(point);
  for (int i = 0; i < 3; ++i) {
    for (const double h : {-2e-6, 2e-6}) {
      EXPECT_GT(misses(point->p_L + h * Eigen::Vector3d::Unit(i)), misses(point->p_L));
    }
  }
  // With rows 4 px apart the rays miss each other by as much, except a few percent from
  // perspective.
  EXPECT_NEAR(point->miss_px, 4, 0.2);
}

TEST(TriangulateTest, RefusesRaysThatDoNotMeetInFront) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  StereoRig rig;
  rig.left = rig.right = TestLens();
  rig.X_RL.translation().x() = -0.06;
  EXPECT_TRUE(Triangulate(rig, {330, 240}, {320, 240}, 1));
  EXPECT_FALSE(Triangulate(rig, {330, 240}, {330, 240}, 1)) << "parallel";
  EXPECT_FALSE(Triangulate(rig, {330, 240}, {340, 240}, 1)) << "behind";
  EXPECT_FALSE(Triangulate(rig, {kNan, 240}, {320, 240}, 1));
  EXPECT_FALSE(Triangulate(rig, {330, 240}, {320, kNan}, 1));
  EXPECT_FALSE(Triangulate(rig, {330, 240}, {320, 1e300}, 1));
  EXPECT_FALSE(Triangulate(rig, {330, 240}, {320, 240}, kNan));
  StereoRig one_eyed = rig;
  one_eyed.X_RL.setIdentity();
  EXPECT_FALSE(Triangulate(one_eyed, {330, 240}, {320, 240}, 1)) << "no baseline";
}

}  // namespace
}  // namespace palpate
