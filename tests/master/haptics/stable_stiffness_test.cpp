#include "master/haptics/stable_stiffness.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "master/haptics/force_chain.h"

namespace palpate {
namespace {

// Returns the energy that a spring K, sampled and held for T, delivers over a cycle of `steps`
// steps of `dx` in and out, less the energy that the damping b dissipates. It is computed from
// force and motion only.
double Gained(double K, double T, double b, int steps, double dx) {
  double x = 0, gained = 0;
  for (int i = 0; i < 2 * steps; ++i) {
    const double step = i < steps ? dx : -dx;
    gained += -K * x * step - b * step * step / T;
    x += step;
  }
  return gained;
}

// Reference: the energy of a cycle, 1 % below and above the limit.
TEST(StableStiffnessTest, IsWhereACycleBeginsToGainEnergy) {
  for (const double rate : {1000.0, 500.0, 200.0}) {
    const double K = StableStiffness(RenderMode::kLocal, {.device_rate = rate}, 0);
    const double b = PassivityControl::kPhysicalDamping;
    EXPECT_LT(Gained(0.99 * K, 1 / rate, b, 20, 1e-4), 0) << rate;
    EXPECT_GT(Gained(1.01 * K, 1 / rate, b, 20, 1e-4), 0) << rate;
  }
}

}  // namespace
}  // namespace palpate
