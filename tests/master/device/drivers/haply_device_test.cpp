#include "master/device/haply/haply_device.h"

#include <atomic>
#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/master/device/drivers/driver_bench.h"
#include "tests/master/device/drivers/haply_service.h"

namespace palpate {
namespace {

using testing::HasSubstr;

// The service's clock and ours are injected. Messages take what they take: a tick waits for them.
class HaplyBench {
 public:
  explicit HaplyBench(const std::string& api) : service(api) { service.Ask("clock 0"); }
  // What `call` returns; its allocations count.
  template <class Call>
  auto Counted(const Call& call) {
    const long before = OwnAllocationCount();
    const auto result = call();
    allocations += OwnAllocationCount() - before;
    return result;
  }

  void Open() {
    device = HaplyDevice::Open({service.port(), [this] { return now.load(); }});
    device->LowerForceLimit(kForceLimit);
  }
  // One millisecond of both clocks, then `answers` of the service: the second has the new time.
  DeviceReading Read(int answers = 2) {
    service.Ask("step 0.001");
    now = now.load() + std::chrono::milliseconds(1);
    DeviceReading reading = Counted([this] { return device->Read(now); });
    for (int fresh = 0, left = 5000; fresh < answers && left > 0; --left) {
      std::this_thread::sleep_for(std::chrono::microseconds(200));
      reading = Counted([this] { return device->Read(now); });
      if (!reading.repeated) ++fresh;
    }
    return reading;
  }
  DeviceReading Run(int ms, const Eigen::Vector3d& force = {0, 0, 0}) {
    DeviceReading reading;
    for (int i = 0; i < ms; ++i) {
      reading = Read();
      device->Write(force, {0, 0, 0});
    }
    return reading;
  }
  // One tick of the haptic loop in `rig`.
  const TickRecord& Tick(Rig* rig, int answers) {
    const DeviceReading reading = Read(answers);
    rig->now = now;
    rig->slave.Step(now, &rig->commands, &rig->states);
    Counted([&] {
      device->WriteForce(rig->loop.Tick(reading, now));
      return 0;
    });
    TickRecord drained;
    while (rig->records.Pop(&drained)) {
    }
    return rig->loop.record();
  }
  // Force that the motors make now, frame H [N].
  [[nodiscard]] Eigen::Vector3d Made() const {
    std::istringstream answer(service.Ask("force"));
    Eigen::Vector3d f(NAN, NAN, NAN);
    answer >> f.x() >> f.y() >> f.z();
    return f;
  }

  long allocations = 0;  // by driver and haptic loop on the tick's thread
  HaplyService service;
  std::atomic<Time> now{Time{std::chrono::hours(1)}};
  std::unique_ptr<HaplyDevice> device;
};

class HaplyDeviceTest : public testing::TestWithParam<const char*> {
 protected:
  HaplyBench bench_{GetParam()};
};

// Frame H has z up and y away from the operator. 3.5 scales by its force gate, which is read back.
TEST_P(HaplyDeviceTest, ForcesArriveInTheFormOfTheReleaseAndTheScaleIsReadBack) {
  const bool is_gated = std::string(GetParam()) == "3.5";
  const double gain = is_gated ? 0.3 : 1;
  bench_.Open();
  EXPECT_THAT(bench_.device->description(), HasSubstr("Inverse3 049D"));
  const bool names_gate = bench_.device->description().find("force gate 0.3") != std::string::npos;
  EXPECT_EQ(names_gate, is_gated);
  bench_.service.Ask("place 0.01 0.02 -0.03");
  const DeviceReading reading = bench_.Run(30, {1, 2, -1});
  EXPECT_NEAR((reading.p_M - Eigen::Vector3d(0.01, -0.03, -0.02)).norm(), 0, 0.02);
  bench_.Read();
  EXPECT_NEAR((bench_.Made() - gain * Eigen::Vector3d(1, 1, 2)).norm(), 0, 1e-9);
  EXPECT_NEAR(static_cast<double>(bench_.device->status().force_share), gain, 0.05);
  EXPECT_EQ(bench_.device->status().output,
            is_gated ? DeviceOutput::kSaturated : DeviceOutput::kOk);
  bench_.device.reset();
  EXPECT_EQ(bench_.Made().norm(), 0) << "the end leaves no force";
}

// Reference: the same motion with the simulated operator.
TEST_P(HaplyDeviceTest, ThePressGivesTheForceOfTheSimulatedOperator) {
  bench_.service.Ask("set gain 1");
  const std::vector<PressTick> press = SimulatedPress();
  double peak = 0, worst = 0;
  for (const PressTick& tick : press) peak = std::max(peak, tick.sent.norm());
  constexpr std::size_t kTicks = 2000;
  bench_.Open();
  FollowPress(bench_.service, press, 0);
  Rig rig({}, RenderMode::kLocal, kForceLimit, kSlewPerTick);
  for (std::size_t i = 0; i < kTicks; ++i) {
    if (i > 0 && press[i].engaged != press[i - 1].engaged) {
      bench_.service.Ask(press[i].engaged ? "press 0 1" : "press 0 0");
    }
    const TickRecord& record = bench_.Tick(&rig, 2);
    worst = std::max(worst, (record.chain.sent - press[i].sent).norm());
  }
  EXPECT_GT(peak, 1.5);
  EXPECT_LT(worst, 0.01 * peak);
  EXPECT_EQ(bench_.allocations, 0) << "messages are for the driver's own thread";
}

TEST_P(HaplyDeviceTest, WithoutACalibrationThereIsNoForce) {
  bench_.service.Ask("set calibrated 0");
  bench_.Open();
  const DeviceReading reading = bench_.Run(10, {1, 0, 0});
  EXPECT_EQ(reading.status.fault, DeviceFault::kNotCalibrated);
  EXPECT_EQ(bench_.device->status().output, DeviceOutput::kOff);
}

// Unplugged at instants of a press, from before the contact to its end: the force is zero within
// 25 ms, the reason is reported, the tool does not move after 40 ms, and the switch that stays
// closed engages nothing. Plugged in again, the device makes no force before an engagement.
TEST_P(HaplyDeviceTest, UnpluggingAtAnyInstantEndsForceAndMotion) {
  constexpr std::size_t kInstants = 8;
  constexpr double kSpeed = 0.080;  // of the press [m/s]: a short one
  const std::vector<PressTick> press = SimulatedPress(kSpeed);
  const auto find = [&press](const auto& wanted) {
    return static_cast<std::size_t>(std::ranges::find_if(press, wanted) - press.begin());
  };
  const std::size_t engaged = find([](const PressTick& tick) { return tick.engaged; });
  const std::size_t first = find([](const PressTick& tick) { return tick.sent.norm() > 0; });
  std::size_t last = first;
  while (press[last].sent.norm() > 0) ++last;
  ASSERT_LT(last, press.size());
  bench_.service.Ask("set gain 1");
  bench_.Open();
  std::size_t in_force = 0;
  for (std::size_t k = 0; k < kInstants; ++k) {
    const std::size_t at = first - 50 + k * (last - first + 50) / kInstants;
    Rig rig({}, RenderMode::kLocal, kForceLimit, kSlewPerTick);
    bench_.service.Ask("press 0 0");
    FollowPress(bench_.service, press, engaged);
    bench_.Tick(&rig, 2);
    bench_.service.Ask("press 0 1");
    for (std::size_t i = engaged + 1; i < at; ++i) bench_.Tick(&rig, 1);
    ASSERT_EQ(rig.state(), OperatorState::kFollowing) << at;
    if (rig.loop.record().chain.sent.norm() > 0.1) ++in_force;
    bench_.service.Ask("unplug");
    Eigen::Vector3d tip(0, 0, 0);
    for (int ms = 1; ms <= 60; ++ms) {
      const TickRecord& record = bench_.Tick(&rig, 1);
      if (ms >= 25) {
        ASSERT_EQ(bench_.Made().norm(), 0) << at << " + " << ms;
        ASSERT_EQ(bench_.device->status().output, DeviceOutput::kOff) << at << " + " << ms;
        ASSERT_THAT(FaultInWords(record.device),
                    HasSubstr("unplugged: the Inverse3 is not connected"));
      }
      if (ms == 40) tip = rig.slave.tip();
      if (ms > 40) {
        ASSERT_EQ(rig.slave.tip(), tip) << at << " + " << ms;
        ASSERT_FALSE(rig.slave.engaged());
      }
    }
    bench_.service.Ask("replug");
    for (int ms = 0; ms < 30; ++ms) {
      bench_.Tick(&rig, 1);
      ASSERT_NE(rig.state(), OperatorState::kFollowing);
      ASSERT_EQ(bench_.Made().norm(), 0);
    }
  }
  EXPECT_GT(in_force, kInstants / 4) << "the test did not unplug under force";
}

INSTANTIATE_TEST_SUITE_P(Releases, HaplyDeviceTest, testing::Values("3.1", "3.5"));

TEST(HaplyLossTest, TheEndOfTheServiceIsReportedAndItsReturnFound) {
  auto service = std::make_unique<HaplyService>("3.5");
  const std::uint16_t port = service->port();
  const auto device = HaplyDevice::Open({port, [] { return Clock::now(); }});
  const auto wait_for = [&device](DeviceFault fault) {
    for (int left = 3000; left > 0 && device->Read(Clock::now()).status.fault != fault; --left) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return FaultInWords(device->status());
  };
  EXPECT_EQ(wait_for(DeviceFault::kNone), "");
  service.reset();
  EXPECT_THAT(wait_for(DeviceFault::kUnplugged), HasSubstr("is lost"));
  service = std::make_unique<HaplyService>("3.5", port);
  EXPECT_EQ(wait_for(DeviceFault::kNone), "");
}

}  // namespace
}  // namespace palpate
