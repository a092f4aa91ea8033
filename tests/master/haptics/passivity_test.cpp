#include <cmath>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

#include "master/haptics/force_chain.h"

namespace palpate {
namespace {

constexpr double kPassivityTick = 0.001;  // [s]

double Depth(double t) {
  return 0.005 * (1 - std::cos(2 * std::numbers::pi * t)) / 2 - 0.001;
}
double Speed(double t) {
  return 0.005 * std::numbers::pi * std::sin(2 * std::numbers::pi * t);
}

// The operator moves in and out of a wall for `seconds`. `law` gives the force at depth and time.
PassivityControl PressAgainst(const std::function<double(double, double)>& law, double seconds,
                              double* damped) {
  PassivityControl port;
  double sent = 0;
  *damped = 0;
  for (int i = 0; i < seconds / kPassivityTick; ++i) {
    const double t = i * kPassivityTick;
    port.Observe({-Depth(t), 0, 0}, {sent, 0, 0}, kPassivityTick);
    const double wanted = law(Depth(t), t);
    const Eigen::Vector3d v(-Speed(t), 0, 0);
    sent = port.LimitToBalance(port.Apply({wanted, 0, 0}, v, kPassivityTick), v, 200).x();
    *damped = std::max(*damped, std::abs(sent - wanted));
    EXPECT_GE(sent, -1e-15) << "the damping never pulls";
    EXPECT_LE(sent, wanted + 1e-12);
  }
  return port;
}

struct PassivityControlTest : testing::Test {
  PassivityControl port;
};

// Reference: sum_k K x_k (x_k+1 - x_k) over a closed path is -K/2 sum dx^2, of which the damping
// may absorb b/T sum dx^2. The balance becomes negative exactly at K = 2 b / T = 2000 N/m. The tick
// that crosses the surface adds K dx^2 / 8 at most, in each of the three presses.
TEST_F(PassivityControlTest, ASpringIsNeverDampedBelowTheTabulatedBound) {
  double damped = 0;
  for (const double K : {100.0, 500.0, 1000.0, 1980.0}) {
    const auto port =
        PressAgainst([K](double d, double) { return std::max(0.0, K * d); }, 3, &damped);
    EXPECT_EQ(damped, 0) << K;
    constexpr double kTravel = 0.0025 * 2 * std::numbers::pi * kPassivityTick;
    EXPECT_GE(port.min_balance(), -3 * K * kTravel * kTravel / 8) << K;
  }
  PressAgainst([](double d, double) { return std::max(0.0, 4000 * d); }, 3, &damped);
  EXPECT_GT(damped, 0);
}

// Reference: conservation. A spring of 650 instead of 500 N/m during the retreat delivers 1/2 150
// d^2 = 1.2 mJ more than it received at d = 4 mm, in each of five presses. Bounded damping that
// never pulls removes more than half of it.
TEST_F(PassivityControlTest, EnergyFromNowhereIsDampedAway) {
  const auto law = [](double d, double t) { return std::max(0.0, (Speed(t) < 0 ? 650 : 500) * d); };
  constexpr double kExcess = 0.5 * 150 * 0.004 * 0.004;
  double damped = 0;
  const PassivityControl pressed = PressAgainst(law, 5, &damped);
  EXPECT_GT(damped, 0);
  EXPECT_GT(pressed.min_balance(), -kExcess / 2);
  EXPECT_GT(pressed.energy_in() - pressed.energy_out(), -5 * kExcess / 2);
}

TEST_F(PassivityControlTest, EnergiesNeverFallAndCloseWithTheWork) {
  port.Observe({0, 0, 0}, {0, 0, 0}, kPassivityTick);
  port.Observe({0, -0.001, 0}, {0, 2, 0}, kPassivityTick);  // pushed in against 2 N: 2 mJ
  EXPECT_NEAR(port.energy_in(), 0.002, 1e-15);
  port.Observe({0, 0.0005, 0}, {0, 1, 0}, kPassivityTick);  // pushed out with 1 N: 1.5 mJ
  EXPECT_NEAR(port.energy_in(), 0.002, 1e-15);
  EXPECT_NEAR(port.energy_out(), 0.0015, 1e-15);
}

// Reference: a spring f = K x that the operator loads leaves W >= f^2 / 2 K, so it is never limited
// up to K_max, from the first tick on. A force without such work gives at most the energy credit
// W_0; where it falls at 200 N/s while the operator yields at 1 m/s, it gives a tenth of that:
// sqrt(2 W_0 200).
TEST_F(PassivityControlTest, AForceIsLimitedByTheEnergyFromTheOperator) {
  constexpr double kSlew = 200;
  double sent = 0;
  for (int i = 0; i < 500; ++i) {
    port.Observe({-10e-6 * i, 0, 0}, {sent, 0, 0}, kPassivityTick);
    const Eigen::Vector3d wanted(2000 * 10e-6 * i, 0, 0);
    EXPECT_EQ(port.LimitToBalance(wanted, {-0.01, 0, 0}, kSlew), wanted) << i;
    sent = wanted.x();
  }
  const double lent = std::sqrt(2 * 0.5e-3 * 2000);  // [N]
  EXPECT_NEAR(PassivityControl().LimitToBalance({3, 0, 0}, {0, 0, 0}, kSlew).x(), lent, 1e-12);
  EXPECT_NEAR(PassivityControl().LimitToBalance({3, 0, 0}, {1, 0, 0}, kSlew).x(),
              lent * std::sqrt(0.1), 1e-12);
}

// A force of 0.3 N that pushes the device out by 1 mm creates an energy deficit of 0.3 mJ. If the
// force falls to 0.1 N, the deficit is reduced by 0.1 mJ (half of the fall times the displacement);
// the rest is below the 0.25 mJ that are not damped.
TEST_F(PassivityControlTest, EnergyRepaidByAFallingForceIsNotDampedAgain) {
  port.Observe({0, 0, 0}, {0, 0, 0}, kPassivityTick);
  port.Observe({0.001, 0, 0}, {0.3, 0, 0}, kPassivityTick);
  EXPECT_EQ(port.Apply({0.1, 0, 0}, {1, 0, 0}, kPassivityTick).x(), 0.1);
  EXPECT_LT(port.Apply({0.3, 0, 0}, {1, 0, 0}, kPassivityTick).x(), 0.3);
}

// If the force also changes its direction, a smaller part of the slew limit remains for its
// decrease.
TEST_F(PassivityControlTest, AHeldForceWithoutEnergyFallsFirst) {
  port.Observe({0, 0, 0}, {3, 0, 0}, kPassivityTick);
  EXPECT_NEAR(port.LimitToBalance({3, 0, 0}, {0.2, 0, 0}, 200).x(), 1, 1e-12);
  EXPECT_TRUE(port.LimitToBalance({0, 3, 0}, {0.2, 0, 0}, 200).isZero(0));
}

// An operator loads a spring of K_max to 3 N, 2.25 mJ, and yields with growing speed: until the 3 N
// have fallen at 200 N/s, an acceleration of 20 m/s^2 lets out 1/6 a f^3 / s^2 = 2.25 mJ more than
// a slow motion would.
TEST_F(PassivityControlTest, ADeviceThatYieldsEverFasterGetsNoMoreEnergy) {
  constexpr double kSlew = 200, kA = 20;  // [N/s], [m/s^2]
  double p = 0, v = 0, sent = 3;
  port.Observe({0, 0, 0}, {0, 0, 0}, kPassivityTick);
  port.Observe({p -= 0.75e-3, 0, 0}, {sent, 0, 0}, 1e9);  // so slow that there is no damping
  for (int i = 0; i < 100; ++i) {
    port.Observe({p += v * kPassivityTick, 0, 0}, {sent, 0, 0}, kPassivityTick);
    v += kA * kPassivityTick;
    const double wanted = port.LimitToBalance({3, 0, 0}, {v, 0, 0}, kSlew).x();
    sent = std::max(wanted, sent - kSlew * kPassivityTick);
  }
  EXPECT_GE(port.min_balance(), -1e-3);
}

// A contact that ends with 1 mJ stored and begins again returns this energy once.
TEST_F(PassivityControlTest, TheEnergyOfAContactIsReturnedOnce) {
  port.Observe({0, 0, 0}, {0, 1, 0}, kPassivityTick);
  port.Observe({0, -0.001, 0}, {0, 1, 0}, 1e9);  // so slow that there is no damping
  EXPECT_NEAR(port.balance(), 1e-3, 1e-12);
  port.Observe({0, -0.001, 0}, {0, 0, 0}, kPassivityTick);
  EXPECT_EQ(port.balance(), 0);
  port.CreditStored();
  EXPECT_NEAR(port.balance(), 1e-3, 1e-12);
  port.Observe({0, -0.001, 0}, {0, 0, 0}, kPassivityTick);
  port.Observe({0, -0.001, 0}, {0, 0, 0}, kPassivityTick);
  port.CreditStored();
  port.CreditStored();
  EXPECT_EQ(port.balance(), 0);
}

// A debt outlives the contact that made it. Free motion reduces it as slowly as the credit W_0 is
// renewed, and saves nothing.
TEST_F(PassivityControlTest, AnEnergyDeficitIsRepaidByFreeMotion) {
  port.Observe({0, 0, 0}, {0, 1, 0}, kPassivityTick);
  port.Observe({0, 1e-4, 0}, {0, 1, 0}, 1e9);  // pushed out: 0.1 mJ
  EXPECT_NEAR(port.balance(), -1e-4, 1e-12);
  port.Observe({0, 2e-4, 0}, {0, 0, 0}, kPassivityTick);
  EXPECT_NEAR(port.balance(), -1e-4 + 0.5e-3 / 60 * kPassivityTick, 1e-12);
  for (int i = 0; i < 13000; ++i) port.Observe({0, 1e-3 * i, 0}, {0, 0, 0}, kPassivityTick);
  EXPECT_EQ(port.balance(), 0);
}

// With an energy deficit larger than W_0 no force could begin: b v^2 T = 1 x 0.1^2 x 0.001 = 0.01
// mJ per tick.
TEST_F(PassivityControlTest, AnEnergyDeficitBeyondTheCreditIsRepaidAtOnce) {
  port.Observe({0, 0, 0}, {0, 1, 0}, kPassivityTick);
  port.Observe({0, 0.6e-3, 0}, {0, 1, 0}, 1e9);
  EXPECT_NEAR(port.balance(), -0.6e-3, 1e-12);
  EXPECT_EQ(port.LimitToBalance({0, 1, 0}, {0, 0.1, 0}, 200), Eigen::Vector3d(0, 0, 0));
  for (int i = 7; i < 17; ++i) port.Observe({0, 1e-4 * i, 0}, {0, 0, 0}, kPassivityTick);
  EXPECT_NEAR(port.balance(), -0.5e-3, 1e-6);
}

// An operator who moves to and fro at up to 0.3 m/s under almost no force gains no credit: a push
// is as if the operator had rested.
TEST_F(PassivityControlTest, MotionWithoutForceStoresNoEnergy) {
  constexpr double kAmplitude = 0.05, kOmega = 2 * std::numbers::pi;
  double p = 0, sent = 0;
  for (int i = 0; i < 12000; ++i) {
    const double t = i * kPassivityTick;
    const double v = t < 6 ? kAmplitude * kOmega * std::cos(kOmega * t) : 0.005;
    p += v * kPassivityTick;
    port.Observe({p, 0, 0}, {sent, 0, 0}, kPassivityTick);
    const Eigen::Vector3d wanted(t < 6.5 ? 1e-6 : 3, 0, 0);
    sent = port.LimitToBalance(port.Apply(wanted, {v, 0, 0}, kPassivityTick), {v, 0, 0}, 200).x();
  }
  EXPECT_GE(port.min_work(), -1.1 * PassivityControl::kEnergyCredit);
  EXPECT_LT(sent, 0.1) << "the hand went on in the push's direction: 5 mm/s x 3 N";
}

TEST_F(PassivityControlTest, ARestingHandIsNeverPushed) {
  port.Observe({0, 0, 0}, {0, 1, 0}, kPassivityTick);
  port.Observe({0, 0.1, 0}, {0, 100, 0}, 1.0);
  ASSERT_LT(port.balance(), 0);
  EXPECT_EQ(port.Apply({0, 1, 0}, {0, 1e-6, 0}, kPassivityTick), Eigen::Vector3d(0, 1, 0));
}

}  // namespace
}  // namespace palpate
