#include "master/haptics/tick_drive.h"

#include <chrono>
#include <set>
#include <thread>

#include <gtest/gtest.h>

#include "tests/master/haptics/test_device.h"

namespace palpate {
namespace {

// A device whose own thread calls the tick `count` times, once per millisecond, and then stops.
class Driven : public TestDevice {
 public:
  explicit Driven(int count) : count_(count) {}
  DeviceReading Read(Time) noexcept override { return {}; }
  bool StartTicks(const Tick* tick) override {
    thread_ = std::jthread([this, tick](const std::stop_token& stop) {
      for (int i = 0; i < count_ && !stop.stop_requested(); ++i) {
        (*tick)(Clock::now());
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    });
    return true;
  }
  void StopTicks() override {
    thread_.request_stop();
    if (thread_.joinable()) thread_.join();
  }

 private:
  int count_;
  std::jthread thread_;
};

struct Seen {
  int ticks = 0;
  bool overlapped = false;
  std::atomic<bool> inside{false};
  std::set<std::thread::id> threads;
  bool Take(int last) {
    overlapped = overlapped || inside.exchange(true);
    threads.insert(std::this_thread::get_id());
    ++ticks;
    inside = false;
    return ticks < last;
  }
};

// The device's thread makes ticks and then stops; the caller continues, so that commands reach the
// slave. Two threads are never inside a tick at once.
TEST(TickDriveTest, TheCallerTakesOverFromASilentDevice) {
  Driven device(40);
  Seen seen;
  TickDrive drive(device, [&](Time) { return seen.Take(200); });
  PeriodicStats stats;
  drive.Run(std::chrono::hours(1), {}, &stats);
  drive.Stop();
  EXPECT_EQ(seen.ticks, 200);
  EXPECT_FALSE(seen.overlapped);
  EXPECT_EQ(seen.threads.size(), 2U);
  EXPECT_EQ(stats.ticks, 200U);
}

// A device that ticks 500 times per second has no missed ticks.
TEST(TickDriveTest, TicksAreCountedAtTheRateOfTheDevice) {
  class Slow final : public Driven {
   public:
    using Driven::Driven;
    [[nodiscard]] DeviceLimits limits() const override { return {.rate = 500}; }
  } device(1000000);
  Seen seen;
  TickDrive drive(device, [&](Time) { return seen.Take(50); });
  PeriodicStats stats;
  drive.Run(std::chrono::hours(1), {}, &stats);
  drive.Stop();
  const double periods = 500 * stats.duration;
  EXPECT_NEAR(static_cast<double>(stats.missed), std::max(0.0, periods - 50), 1);
}

// Between two runs, and after the last, the device's thread does not tick.
TEST(TickDriveTest, OutsideOfARunNothingTicks) {
  Driven device(1000000);
  Seen seen;
  TickDrive drive(device, [&](Time) { return seen.Take(20); });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(seen.ticks, 0);
  PeriodicStats stats;
  drive.Run(std::chrono::hours(1), {}, &stats);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  drive.Stop();
  EXPECT_EQ(seen.ticks, 20);
}

}  // namespace
}  // namespace palpate
