#include "slave/live/model_validity_monitor.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using testing::HasSubstr;

// Studied to 5 mm, for 500 Hz.
class ModelValidityMonitorTest : public testing::Test {
 protected:
  void Press(double depth, int updates, double update) {
    ContactEstimate estimate;
    estimate.force = Eigen::Vector3d::UnitY();
    estimate.validity = Validity::kValid;
    estimate.depth = depth;
    for (int i = 0; i < updates; ++i) watch_.Update(estimate, true, update);
  }
  void LetGo() { watch_.Update({}, false, 0); }
  // The breaches, as soon as there are `count`.
  std::vector<ModelValidityMonitor::Breach> WaitForBreaches(std::size_t count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return breaches_.size() >= count; });
    return breaches_;
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<ModelValidityMonitor::Breach> breaches_;
  ModelValidityMonitor watch_{
      Scene{}, [this](const ModelValidityMonitor::Breach& breach, const std::stop_token&) {
        const std::lock_guard lock(mutex_);
        breaches_.push_back(breach);
        changed_.notify_all();
      }};
};

TEST_F(ModelValidityMonitorTest, ADeeperPressIsReportedOnceForADepthWithAReserve) {
  Press(5.4e-3, 10, 1e-4);
  LetGo();
  Press(8e-3, 10, 1e-4);
  LetGo();
  LetGo();
  ASSERT_EQ(WaitForBreaches(1).size(), 1U) << "5.4 mm is no deeper than studied";
  Press(10.5e-3, 10, 1e-4);  // within the reserve
  LetGo();
  Press(12e-3, 10, 1e-4);
  LetGo();
  const auto breaches = WaitForBreaches(2);
  EXPECT_EQ(breaches[0].depth, 10e-3);
  EXPECT_THAT(breaches[0].words, HasSubstr("indentation of 8 mm"));
  EXPECT_EQ(breaches[1].depth, 15e-3);
}

TEST_F(ModelValidityMonitorTest, LateUpdatesAreReportedUnlessTheyAreFew) {
  for (int i = 0; i < 40; ++i) {  // one in twenty is late: somebody else had the processor
    Press(1e-3, 19, 1.9e-3);
    Press(1e-3, 1, 0.1);
  }
  LetGo();
  Press(1e-3, 200, 2.1e-3);
  LetGo();
  const auto breaches = WaitForBreaches(1);
  EXPECT_EQ(breaches[0].depth, 5e-3);
  EXPECT_THAT(breaches[0].words, HasSubstr("200 of 200 updates took longer than 2 ms"));

  Press(1e-3, 200, 3.9e-3);  // as late as before, more or less: what was decided stays
  LetGo();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_EQ(WaitForBreaches(1).size(), 1U);
  Press(1e-3, 200, 4.1e-3);
  LetGo();
  EXPECT_EQ(WaitForBreaches(2).size(), 2U);
}

}  // namespace
}  // namespace palpate
