#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/master/device/drivers/haply_bench.h"

namespace palpate {
namespace {

using testing::HasSubstr;

class HaplyDeviceTest : public testing::TestWithParam<const char*> {
 protected:
  HaplyBench bench_{GetParam()};
};

// 3.5 scales by its force gate, which is read back. A service that does not name its release gets
// both forms.
TEST_P(HaplyDeviceTest, ForcesArriveInTheFormOfTheReleaseAndTheScaleIsReadBack) {
  const bool is_gated = std::string(GetParam()) == "3.5";
  const double gain = is_gated ? 0.3 : 1;
  bench_.service.Ask("set gain " + std::to_string(gain));
  bench_.Open();
  EXPECT_THAT(bench_.device->description(), HasSubstr("Inverse3 049D"));
  const bool names_gate = bench_.device->description().find("force gate 0.3") != std::string::npos;
  EXPECT_EQ(names_gate, is_gated);
  bench_.service.Ask("place 0.01 0.02 -0.03");
  const DeviceReading reading = bench_.Run(30, {1, 2, -1});
  EXPECT_NEAR((reading.p_M - Eigen::Vector3d(0.01, -0.03, -0.02)).norm(), 0, 0.02);
  bench_.Read();
  EXPECT_NEAR((bench_.Made() - gain * Eigen::Vector3d(1, 2, -1)).norm(), 0, 1e-9);
  EXPECT_NEAR(static_cast<double>(bench_.device->status().force_share), gain, 0.05);
  EXPECT_EQ(bench_.device->status().output,
            is_gated ? DeviceOutput::kSaturated : DeviceOutput::kOk);
}

TEST_P(HaplyDeviceTest, WithoutACalibrationThereIsNoForce) {
  bench_.service.Ask("set calibrated 0");
  bench_.Open();
  const DeviceReading reading = bench_.Run(10, {1, 0, 0});
  EXPECT_EQ(reading.status.fault, DeviceFault::kNotCalibrated);
  EXPECT_EQ(bench_.device->status().output, DeviceOutput::kOff);
}

INSTANTIATE_TEST_SUITE_P(Releases, HaplyDeviceTest, testing::Values("3.1", "3.5", "bare"));

TEST(HaplyLossTest, TheEndOfTheServiceIsReportedAndItsReturnFound) {
  auto service = std::make_unique<HaplyService>("3.5");
  const std::uint16_t port = service->port();
  const auto device = HaplyDevice::Open({port, [] { return Clock::now(); }});
  const auto wait_for = [&device](DeviceFault fault) {
    Eventually([&] { return device->Read(Clock::now()).status.fault == fault; });
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
