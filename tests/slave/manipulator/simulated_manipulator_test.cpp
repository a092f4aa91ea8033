#include "slave/manipulator/simulated_manipulator.h"

#include <atomic>
#include <chrono>
#include <limits>
#include <mutex>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/eventually.h"

namespace palpate {
namespace {

using namespace std::chrono_literals;

ManipulatorOptions Options() {
  return {.home = {0, 0, 0},
          .max_speed = 0.05,
          .workspace_min = {-0.1, -0.1, 0},
          .workspace_max = {0.1, 0.1, 0}};
}

TEST(SimulatedManipulator, ReachesItsTarget) {
  SimulatedManipulator arm(Options());
  ASSERT_TRUE(arm.Command({0.002, 0, 0}));
  EXPECT_TRUE(Eventually([&] { return std::abs(arm.Tip().x() - 0.002) < 1e-9; }));
}

TEST(SimulatedManipulator, NotFiniteCommandsAreIgnoredAndCounted) {
  SimulatedManipulator arm(Options());
  EXPECT_FALSE(arm.Command({std::numeric_limits<double>::quiet_NaN(), 0, 0}));
  EXPECT_FALSE(arm.Command({0, std::numeric_limits<double>::infinity(), 0}));
  EXPECT_EQ(arm.ignored_commands(), 2u);
  EXPECT_EQ(arm.Tip(), Eigen::Vector3d(0, 0, 0));
}

TEST(SimulatedManipulator, HoldStopsAndLimitsAreTold) {
  SimulatedManipulator arm(Options());
  arm.Command({1, 0, 0});
  EXPECT_TRUE(arm.at_limit());
  ASSERT_TRUE(Eventually([&] { return arm.Tip().x() > 1e-3; }));
  arm.Hold();
  const Eigen::Vector3d held = arm.Tip();
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(arm.Tip(), held);
  EXPECT_FALSE(arm.at_limit());
}

TEST(SimulatedManipulator, CommandsFromManyThreadsAreSafe) {
  SimulatedManipulator arm(Options());
  std::vector<std::jthread> operators;
  for (int k = 0; k < 3; ++k) {
    operators.emplace_back([&arm, k] {
      for (int i = 0; i < 2000; ++i) {
        arm.Command({1e-5 * i, 1e-3 * k, 0});
        if (i % 100 == 0) arm.Hold();
        EXPECT_TRUE(arm.Tip().allFinite());
      }
    });
  }
}

}  // namespace
}  // namespace palpate
