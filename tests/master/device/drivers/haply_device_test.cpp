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
  explicit HaplyBench(const std::string& api) : service(api) {
    service.Ask("clock 0");
    service.Ask("set grip_stiffness inf");
  }
  void Open() {
    device = HaplyDevice::Open({service.port(), [this] { return now.load(); }});
    device->LowerForceLimit(kForceLimit);
  }
  // One millisecond of both clocks, then two answers of the service: the second has the new time.
  DeviceReading Read() {
    service.Ask("step 0.001");
    now = now.load() + std::chrono::milliseconds(1);
    DeviceReading reading = device->Read(now);
    for (int fresh = 0, left = 5000; fresh < 2 && left > 0; --left) {
      std::this_thread::sleep_for(std::chrono::microseconds(200));
      reading = device->Read(now);
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
  // Force that the motors make now, frame H [N].
  [[nodiscard]] Eigen::Vector3d Made() const {
    std::istringstream answer(service.Ask("force"));
    Eigen::Vector3d f(NAN, NAN, NAN);
    answer >> f.x() >> f.y() >> f.z();
    return f;
  }

  HaplyService service;
  std::atomic<Time> now{Time{std::chrono::hours(1)}};
  std::unique_ptr<HaplyDevice> device;
};

std::string WhyNot(std::uint16_t port) {
  try {
    HaplyDevice::Open({port, [] { return Time{}; }});
  } catch (const DeviceUnavailable& error) {
    return error.what();
  }
  return "opened";
}

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
  const bool told = bench_.device->description().find("force gate 0.3") != std::string::npos;
  EXPECT_EQ(told, is_gated);
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
  const std::string file = testing::TempDir() + "palpate-haply-press.csv";
  std::ofstream csv(file);
  csv << "time_s,x,y,z\n";
  constexpr std::size_t kTicks = 2000;
  for (std::size_t i = 0; i < kTicks; ++i) {
    const Eigen::Vector3d& p = press[i].p_M;
    csv << 0.001 * static_cast<double>(i + 1) << ',' << p.x() << ',' << -p.z() << ',' << p.y()
        << '\n';
  }
  csv.close();
  bench_.Open();
  EXPECT_EQ(bench_.service.Ask("follow " + file), "ok");
  Rig rig({}, RenderMode::kLocal, kForceLimit, kSlewPerTick);
  for (std::size_t i = 0; i < kTicks; ++i) {
    if (i > 0 && press[i].engaged != press[i - 1].engaged) {
      bench_.service.Ask(press[i].engaged ? "press 0 1" : "press 0 0");
    }
    const DeviceReading reading = bench_.Read();
    rig.now = bench_.now;
    rig.slave.Step(rig.now, &rig.commands, &rig.states);
    bench_.device->WriteForce(rig.loop.Tick(reading, rig.now));
    TickRecord drained;
    while (rig.records.Pop(&drained)) {
    }
    worst = std::max(worst, (rig.loop.record().chain.sent - press[i].sent).norm());
  }
  EXPECT_GT(peak, 1.5);
  EXPECT_LT(worst, 0.01 * peak);
}

TEST_P(HaplyDeviceTest, WithoutACalibrationThereIsNoForce) {
  bench_.service.Ask("set calibrated 0");
  bench_.Open();
  const DeviceReading reading = bench_.Run(10, {1, 0, 0});
  EXPECT_EQ(reading.status.fault, DeviceFault::kNotCalibrated);
  EXPECT_EQ(bench_.device->status().output, DeviceOutput::kOff);
}

TEST_P(HaplyDeviceTest, UnpluggingEndsTheForceAndTheEngagement) {
  bench_.Open();
  bench_.service.Ask("press 0 1");
  ASSERT_TRUE(bench_.Run(20, {1, 0, 0}).engaged);
  bench_.service.Ask("unplug");
  const DeviceReading gone = bench_.Run(3, {1, 0, 0});
  EXPECT_FALSE(gone.engaged);
  EXPECT_THAT(FaultInWords(gone.status), HasSubstr("unplugged: the Inverse3"));
  EXPECT_EQ(bench_.device->status().output, DeviceOutput::kOff);
  bench_.service.Ask("replug");
  EXPECT_FALSE(bench_.Run(20).engaged) << "the button was never released";
  bench_.service.Ask("press 0 0");
  bench_.Run(3);
  bench_.service.Ask("press 0 1");
  EXPECT_TRUE(bench_.Run(3).engaged);
}

TEST_P(HaplyDeviceTest, OtherProgramsThatAddForcesAreTold) {
  HaplyDevice::Options options{bench_.service.port(), [] { return Time{}; }};
  const auto other = HaplyDevice::Open(options);
  bench_.Open();
  EXPECT_THAT(bench_.device->description(), HasSubstr("1 other sessions may add forces"));
}

INSTANTIATE_TEST_SUITE_P(Releases, HaplyDeviceTest, testing::Values("3.1", "3.5"));

TEST(HaplyLossTest, TheEndOfTheServiceIsToldAndItsReturnFound) {
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

TEST(HaplyLossTest, NobodyAtThePortIsTold) {
  EXPECT_THAT(WhyNot(1), HasSubstr("no haply-inverse-service answers at 127.0.0.1:1"));
}

TEST(HaplyLossTest, AServiceWithoutADeviceIsTold) {
  const HaplyService service("3.5");
  service.Ask("unplug");
  EXPECT_THAT(WhyNot(service.port()), HasSubstr("no Inverse3 is connected"));
}

}  // namespace
}  // namespace palpate
