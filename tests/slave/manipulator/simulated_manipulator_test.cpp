#include "slave/manipulator/simulated_manipulator.h"

#include <chrono>
#include <limits>
#include <thread>

#include <gtest/gtest.h>

#include "tests/support/eventually.h"

namespace palpate {
namespace {

using namespace std::chrono_literals;

class SimulatedManipulatorTest : public testing::Test {
 protected:
  SimulatedManipulator arm_{{.home = {0, 0, 0},
                             .max_speed = 0.05,
                             .workspace_min = {-0.1, -0.1, 0},
                             .workspace_max = {0.1, 0.1, 0}}};
};

TEST_F(SimulatedManipulatorTest, ReachesItsTarget) {
  ASSERT_TRUE(arm_.Command({0.002, 0, 0}));
  EXPECT_TRUE(Eventually([&] { return std::abs(arm_.Tip().x() - 0.002) < 1e-9; }));
}

TEST_F(SimulatedManipulatorTest, HoldStopsAndLimitsAreReported) {
  EXPECT_FALSE(arm_.Command({std::numeric_limits<double>::quiet_NaN(), 0, 0}));
  arm_.Command({1, 0, 0});
  EXPECT_TRUE(arm_.at_limit());
  ASSERT_TRUE(Eventually([&] { return arm_.Tip().x() > 1e-3; }));
  arm_.Hold();
  const Eigen::Vector3d held = arm_.Tip();
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(arm_.Tip(), held);
  EXPECT_FALSE(arm_.at_limit());
}

}  // namespace
}  // namespace palpate
