// Emergency stops and resets of the whole slave from several threads.
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include <gtest/gtest.h>

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

// Whatever the order in which both take effect, tool and record agree: a stopped tool has a record
// that survives a restart, and a released one has none.
TEST(LiveSlaveStopTest, ToolAndRecordAgreeAfterAStopBesideAReset) {
  const Scratch scratch;
  const Scene scene =
      LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"), {"model.elements=60"});
  const std::unique_ptr<Slave> made = MakeLiveSlave(scene, scratch.path());
  const SimulatedDevices devices(scene, made.get());
  Slave& slave = *made;
  for (int round = 0; round < 300; ++round) {
    slave.EmergencyStop("first");
    std::jthread reset([&] {
      try {
        slave.Reset();
      } catch (const std::logic_error&) {  // another stop arrived during the reset
      }
    });
    slave.EmergencyStop("second");
    reset.join();
    const SlaveStatus status = slave.Status();
    const bool is_stopped = status.phase == Phase::kEstop;
    ASSERT_EQ(is_stopped, HasStopAlarm(status)) << "round " << round;
    ASSERT_EQ(is_stopped, std::filesystem::exists(scratch.path() / "emergency-stop")) << round;
    if (is_stopped) slave.Reset();
  }
}

}  // namespace
}  // namespace palpate
