// What averaging takes off a noisy fingertip's force, and what must come through it.
#include "slave/tactile/steady_force.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/normal_noise.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
constexpr double kPerCount = 0.005;  // [N]

// A network's answer to signals of `size`, each part of it wrong by `share`, one sigma.
class NoisyAnswers {
 public:
  Vector3d To(double size, const Vector3d& way, double share) {
    const Vector3d off(normal_(random_), normal_(random_), normal_(random_));
    return kPerCount * size * (way + share * off);
  }

 private:
  std::mt19937_64 random_{7};
  NormalNoise normal_;
};

// A press of half a second. Across the force two thirds of the noise go; along it a third, and
// nothing lags: the error's mean is that of the noise.
TEST(SteadyForce, TakesTheNoiseOffAPress) {
  SteadyForce steady;
  NoisyAnswers answers;
  const Vector3d way = Vector3d(1, 2, -2) / 3;
  double raw2 = 0, across2 = 0, along2 = 0, along = 0;
  for (int i = 0; i < 100; ++i) {
    const double size = 5 + 50 * (1 - std::cos(0.0628 * i)), truth = kPerCount * size;
    const Vector3d force = answers.To(size, way, 0.05);
    const Vector3d error = steady.Take(force, size, 3) / truth - way;
    if (i < 20) continue;
    raw2 += (force / truth - way).squaredNorm() / 3;
    along += error.dot(way);
    along2 += error.dot(way) * error.dot(way);
    across2 += (error - error.dot(way) * way).squaredNorm() / 2;
  }
  EXPECT_LT(std::sqrt(across2 / raw2), 0.5);
  EXPECT_LT(std::sqrt(along2 / raw2), 0.85);
  EXPECT_LT(std::abs(along) / 80, 0.05 / std::sqrt(80) * 3);
}

TEST(SteadyForce, UsualNoiseIsNotAveraged) {
  SteadyForce steady;
  NoisyAnswers answers;
  for (int i = 1; i < 20; ++i) {
    const Vector3d force = answers.To(i, Vector3d::UnitX(), 0.1);
    EXPECT_LT((steady.Take(force, i, 1) - force).norm(), 1e-12);
  }
  EXPECT_LT(steady.left_out(), 1e-12);
}

// From one sample to the next.
TEST(SteadyForce, WhatIsLostTakesItsForceAlong) {
  SteadyForce steady;
  for (int i = 0; i < 50; ++i) steady.Take({0, 0, -0.5}, 100, 3);
  const Vector3d left(0, 0, -0.005);
  EXPECT_LT((steady.Take(left, 1, 3) - left).norm(), 1e-12);
}

// While it follows, what is told is wrong, and it says by how much.
TEST(SteadyForce, AContactThatTurnsIsFollowedAndSaidToTurn) {
  SteadyForce steady;
  for (int i = 0; i < 50; ++i) steady.Take({0, 0, -0.5}, 100, 3);
  const Vector3d turned(0, 0.5, 0);
  for (int i = 0; i < 60; ++i) {
    const double error = (steady.Take(turned, 100, 3) - turned).norm();
    EXPECT_LE(error, 2.001 * steady.left_out()) << i;
  }
  EXPECT_LT((steady.Take(turned, 100, 3) - turned).norm(), 0.02);
}

// From the first sample on, by any angle: never off by three times what it says.
TEST(SteadyForce, ATurnWithinOneSampleIsNeverSilent) {
  for (const double noise : {3.0, 10.0}) {
    for (const double degrees : {30, 60, 90, 120, 180}) {
      SteadyForce steady;
      for (int i = 0; i < 200; ++i) steady.Take({0, 0, -0.5}, 100, noise);
      const double angle = degrees * std::numbers::pi / 180;
      const Vector3d turned(0, 0.5 * std::sin(angle), -0.5 * std::cos(angle));
      for (int i = 0; i < 20; ++i) {
        const double error = (steady.Take(turned, 100, noise) - turned).norm();
        EXPECT_LT(error, 2.5 * steady.left_out()) << noise << ", " << degrees << " deg, " << i;
      }
    }
  }
}

TEST(SteadyForce, NoForceAndNoSignalsAreNoNumberToDivideBy) {
  SteadyForce steady;
  EXPECT_EQ(steady.Take(Vector3d::Zero(), 10, 3), Vector3d::Zero());
  EXPECT_EQ(steady.Take(Vector3d::UnitX(), 0, 3), Vector3d::UnitX());
}

}  // namespace
}  // namespace palpate
