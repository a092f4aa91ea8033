// A session is recorded while the haptic thread ticks; that thread must allocate no memory.
#include <atomic>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "master/device/sim_hand.h"
#include "master/recording/session_recording.h"
#include "master/session/recorder.h"
#include "shared/recording/recording_reader.h"
#include "tests/master/haptics/rig.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

TEST(RecordedTicksTest, TheHapticThreadAllocatesNothingAndEveryTickIsKept) {
  constexpr int kTicks = 3000, kBehind = 32;  // the ring holds 64
  const auto file =
      std::filesystem::temp_directory_path() / ("ticks." + std::to_string(getpid()) + ".mcap");
  {
    SessionRecording recording({.file = file});
    Rig rig;
    SimHand hand(0.005, 0.02);
    std::atomic<int> taken{0};
    Recorder recorder(&rig.records, {}, [&](const TickRecord& tick) {
      recording.OnTick(tick);
      ++taken;
    });
    std::jthread slow([&](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        recorder.Drain({});
        std::this_thread::yield();
      }
      recorder.Finish();
    });
    long allocations = 0;
    for (int tick = 0; tick < kTicks; ++tick) {
      rig.now += kHapticPeriod;
      rig.slave.Step(rig.now, &rig.commands, &rig.states);
      const long before = OwnAllocationCount();
      const DeviceReading reading = hand.Read(rig.now);
      hand.WriteForce(rig.loop.Tick(reading, rig.now));
      allocations += OwnAllocationCount() - before;
      while (tick - taken > kBehind) std::this_thread::yield();
    }
    slow.request_stop();
    slow.join();
    EXPECT_EQ(rig.records.dropped(), 0U);
    EXPECT_EQ(allocations, 0);
  }
  int kept = 0;
  for (RecordingReader reader(file); reader.Next();) kept += reader.topic() == kTickTopic ? 1 : 0;
  EXPECT_EQ(kept, kTicks);
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace palpate
