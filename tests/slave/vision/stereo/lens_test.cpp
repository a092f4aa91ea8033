
#include <gtest/gtest.h>

#include "slave/vision/stereo/rig.h"
#include "tests/slave/vision/stereo/test_rigs.h"

namespace palpate {
namespace {

constexpr std::array<double, 5> kBarrel{-0.27, -0.04, 0.0018, -0.0003, 0.24};
constexpr std::array<double, 5> kPincushion{0.3, 0.1, -0.002, 0.001, 0.05};

// Tests the inverse of Project over the whole image; Newton's method converges to rounding.
TEST(LensTest, EveryPixelGoesOutAndComesBack) {
  for (const auto& distortion : {std::array<double, 5>{}, kBarrel, kPincushion}) {
    const Lens lens = TestLens(distortion);
    for (double u = 0; u <= 639; u += 71) {
      for (double v = 0; v <= 479; v += 53.2) {
        const auto ray = RayOf(lens, {u, v});
        ASSERT_TRUE(ray) << u << " " << v;
        const auto back = Project(lens, 3.7 * ray->homogeneous());
        ASSERT_TRUE(back);
        EXPECT_LT((*back - Eigen::Vector2d(u, v)).norm(), 1e-9) << u << " " << v;
      }
    }
  }
}

// Central differences with step h err by h^2 and round by eps / h: 1e-6 of 800 px at h = 1e-6.
TEST(LensTest, TheJacobianIsTheDerivative) {
  const Lens lens = TestLens(kPincushion);
  const Eigen::Vector3d p(0.08, -0.05, 0.3);
  Eigen::Vector2d at;
  Eigen::Matrix<double, 2, 3> J;
  ASSERT_TRUE(ProjectWithJacobian(lens, p, &at, &J));
  const double h = 1e-6;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d d = h * Eigen::Vector3d::Unit(i);
    const Eigen::Vector2d slope = (*Project(lens, p + d) - *Project(lens, p - d)) / (2 * h);
    EXPECT_LT((slope - J.col(i)).norm(), 1e-5 * J.norm()) << i;
  }
}

// k1 = -1: r (1 - r^2) peaks at r = 1/sqrt 3 with 0.385; no ray has an image beyond, and rays
// beyond would have the image of one within.
TEST(LensTest, ThereIsNoRayBeyondTheFold) {
  const Lens lens = TestLens({-1, 0, 0, 0, 0});
  EXPECT_TRUE(RayOf(lens, {320 + 800 * 0.38, 240}));
  EXPECT_FALSE(RayOf(lens, {320 + 800 * 0.39, 240}));
  EXPECT_FALSE(RayOf(lens, {320, 240 + 800 * 5}));
  EXPECT_TRUE(Project(lens, {0.57, 0, 1}));
  EXPECT_FALSE(Project(lens, {0.59, 0, 1}));
  // Folds, then rises again: 1 + 3 k1 s + 5 k2 s^2 < 0 for s in 0.44 to 0.76 only.
  const Lens wavy = TestLens({-1.2, 0.6, 0, 0, 0});
  EXPECT_TRUE(Project(wavy, {0.5, 0, 1}));
  EXPECT_FALSE(Project(wavy, {1, 0, 1}));
}

}  // namespace
}  // namespace palpate
