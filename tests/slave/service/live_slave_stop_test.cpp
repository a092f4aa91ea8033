// The whole slave: emergency stops and resets from several threads, a camera that fails once.
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "slave/capture/frame_source.h"
#include "slave/live/live_slave.h"
#include "slave/scene/scene_loader.h"
#include "tests/slave/simulator/simulated_devices.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

bool HasStopAlarm(const SlaveStatus& status) {
  for (const std::string& alarm : status.alarms) {
    if (alarm.starts_with("emergency stop for")) return true;
  }
  return false;
}

// In whichever order both take effect, tool and record agree: a stopped tool has a record that
// survives a restart, a released tool has none.
TEST(LiveSlaveStopTest, ToolAndRecordAgreeAfterAStopBesideAReset) {
  const Scratch scratch;
  const Scene scene =
      LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"), {"model.elements=60"});
  const std::unique_ptr<Slave> made = MakeLiveSlave(scene, scratch.path());
  const SimulatedDevices devices(scene, made.get());
  Slave& slave = *made;
  for (int round = 0; round < 300; ++round) {
    slave.EmergencyStop("first");
    const std::uint64_t known = slave.Status().stops;
    std::jthread reset([&] {
      try {
        slave.Reset(known);
      } catch (const std::logic_error&) {  // another stop arrived during the reset
      }
    });
    slave.EmergencyStop("second");
    reset.join();
    const SlaveStatus status = slave.Status();
    const bool is_stopped = status.phase == Phase::kEstop;
    ASSERT_EQ(is_stopped, HasStopAlarm(status)) << "round " << round;
    ASSERT_EQ(is_stopped, std::filesystem::exists(scratch.path() / "emergency-stop")) << round;
    ASSERT_TRUE(is_stopped) << "round " << round << ": the reset knew the first stop only";
    slave.Reset(status.stops);
  }
}

// An image each 10 ms; the third one fails, as a broken driver does.
class FailingOnce final : public FrameSource {
 public:
  std::optional<Frame> Next(const std::stop_token& stop) override {
    if (stop.stop_requested()) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    if (++count_ == 3) throw std::runtime_error("a damaged image");
    return Frame{cv::Mat(48, 64, CV_8UC1, cv::Scalar(90)), count_, Clock::now()};
  }
  [[nodiscard]] std::string description() const override { return "a camera"; }

 private:
  std::uint64_t count_ = 0;
};

TEST(LiveSlaveTest, SensingGoesOnAfterASampleThatBreaksIt) {
  const auto slave = MakePreviewSlave(
      Camera{}, [](const ImageFilter& /*filter*/) { return std::make_unique<FailingOnce>(); });
  while (slave->Status().frames < 10) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_THAT(slave->Status().alarms, testing::Contains(testing::HasSubstr("a damaged image")));
}

}  // namespace
}  // namespace palpate
