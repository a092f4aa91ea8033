#include "master/device/turn_passivity.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kTurnTick = 0.001;  // [s]

// A handle with an inertia of 2e-4 kg m2 that a torque turns, and a little friction.
class Handle {
 public:
  void Step(const Vector3d& t) {
    w_ += kTurnTick / kInertia * (t - kFriction * w_);
    const Vector3d turn = kTurnTick * w_;
    received_ += t.dot(turn);
    const double angle = turn.norm();
    if (angle > 0) q_ = Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle)) * q_;
    q_.normalize();
  }
  void Push(const Vector3d& w) { w_ += w; }
  [[nodiscard]] const Eigen::Quaterniond& q() const { return q_; }
  [[nodiscard]] const Vector3d& w() const { return w_; }
  [[nodiscard]] double received() const { return received_; }  // from the device [J]

 private:
  static constexpr double kInertia = 2e-4, kFriction = 1e-3;
  Eigen::Quaterniond q_{1, 0, 0, 0};
  Vector3d w_{0, 0, 0};
  double received_ = 0;
};

// The worst torque: always along the rotation. Reference: without the control the handle receives
// more than 0.1 J in a second; with it W_0, and the work of single ticks.
TEST(TurnPassivityTest, ATorqueThatDrivesTheHandleReceivesNoMoreThanTheCredit) {
  for (const bool controlled : {false, true}) {
    TurnPassivity turning;
    Handle handle;
    handle.Push({0.1, 0.2, -0.1});
    Vector3d t(0, 0, 0);
    double largest = 0;  // work of a tick [J]
    for (int i = 0; i < 1000; ++i) {
      handle.Step(t);
      turning.Observe(handle.q(), t, true);
      largest = std::max(largest, std::abs(t.dot(handle.w())) * kTurnTick);
      const Vector3d wanted = 0.05 * handle.w().normalized();
      t = controlled ? turning.Apply(wanted) : wanted;
    }
    EXPECT_NEAR(turning.balance(), -handle.received(), 1e-6 + 1e-3 * handle.received());
    if (controlled) {
      EXPECT_LE(handle.received(), TurnPassivity::kEnergyCredit + 2 * largest);
      EXPECT_GT(handle.received(), TurnPassivity::kEnergyCredit / 2) << "the credit is used";
    } else {
      EXPECT_GT(handle.received(), 0.1);
    }
  }
}

// A rotational spring that the operator winds up and releases returns the energy that it received.
TEST(TurnPassivityTest, ASpringThatTheOperatorWoundIsNotWeakened) {
  TurnPassivity turning;
  Vector3d t(0, 0, 0);
  for (int i = 0; i <= 2000; ++i) {
    const double angle = 0.2 * std::sin(M_PI * i / 2000.0);
    turning.Observe(Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vector3d::UnitZ())), t, true);
    const Vector3d wanted(0, 0, -0.3 * angle);
    t = turning.Apply(wanted);
    ASSERT_EQ(t, wanted) << i;
  }
}

// Reference: Apply never reverses or lengthens a torque, and changes only its part along the turn.
TEST(TurnPassivityPropertyTest, OnlyWeakens) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  const auto any = [&](double size) {
    return Vector3d(size * normal(random), size * normal(random), size * normal(random));
  };
  int weakened = 0;
  for (int round = 0; round < 200; ++round) {
    TurnPassivity turning;
    Handle handle;
    Vector3d t(0, 0, 0);
    for (int i = 0; i < 200; ++i) {
      if (i % 20 == 0) handle.Push(any(0.5));
      handle.Step(t);
      turning.Observe(handle.q(), t, i % 50 > 3);
      const Vector3d wanted = any(0.05);
      t = turning.Apply(wanted);
      ASSERT_LE(t.norm(), wanted.norm() * (1 + 1e-12));
      ASSERT_GE(t.dot(wanted), -1e-18);
      weakened += t != wanted ? 1 : 0;
    }
  }
  EXPECT_GT(weakened, 1000) << "the test did not exercise the control";
}

TEST(TurnPassivityTest, ANewEngagementRenewsTheCredit) {
  TurnPassivity turning;
  const auto turn_to = [&](double angle, double torque, bool engaged) {
    turning.Observe(Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vector3d::UnitX())),
                    Vector3d(torque, 0, 0), engaged);
  };
  turn_to(0, 0, true);
  turn_to(0.1, 0.1, true);
  EXPECT_NEAR(turning.balance(), -0.01, 1e-12);
  EXPECT_TRUE(turning.Apply({0.1, 0, 0}).isZero(1e-15));
  EXPECT_EQ(turning.Apply({-0.1, 0.05, 0}), Vector3d(-0.1, 0.05, 0)) << "braking is free";
  turn_to(0.1, 0, false);
  turn_to(0.1, 0, true);
  EXPECT_EQ(turning.balance(), 0);
}

}  // namespace
}  // namespace palpate
