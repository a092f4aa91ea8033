// Tests requirements that every device with force feedback must meet. A new driver is added to
// kMembers.
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/master/device/drivers/driver_bench.h"
#include "tests/master/device/drivers/haply_bench.h"

namespace palpate {
namespace {

struct Member {
  std::string name;
  std::unique_ptr<DeviceBench> (*make)();
  std::string loss;      // how the loss of the device is reported
  double speed = 0.020;  // of the press that is interrupted [m/s]
  std::size_t instants = 16;
};

template <BenchKind (*kind)()>
std::unique_ptr<DeviceBench> MakeDriver() {
  return std::make_unique<DriverBench>(kind());
}

// The Haply service's messages take long, so its presses are short.
const Member kMembers[] = {
    {"touch", MakeDriver<TouchBench>, "silent: communication error"},
    {"dhd", MakeDriver<DhdBench>, "silent: communication error"},
    {"haply_3_1",
     []() -> std::unique_ptr<DeviceBench> { return std::make_unique<HaplyBench>("3.1"); },
     "unplugged: the Inverse3 is not connected", 0.080, 8},
    {"haply_3_5",
     []() -> std::unique_ptr<DeviceBench> { return std::make_unique<HaplyBench>("3.5"); },
     "unplugged: the Inverse3 is not connected", 0.080, 8},
};

class DeviceConformanceTest : public testing::TestWithParam<Member> {
 protected:
  [[nodiscard]] static std::unique_ptr<DeviceBench> Opened() {
    auto bench = GetParam().make();
    bench->Open();
    return bench;
  }
  // The first tick of `press` with a force, and the first without one after it.
  static std::pair<std::size_t, std::size_t> ContactOf(const std::vector<PressTick>& press) {
    std::size_t first = 0;
    while (press[first].sent.isZero(0)) ++first;
    std::size_t last = first;
    while (!press[last].sent.isZero(0)) ++last;
    return {first, last};
  }
};

// Reference: the same motion with the simulated operator. 1 %: encoder steps and the filtered
// velocity of a device reach only the passivity control. Ticks in contact allocate nothing.
TEST_P(DeviceConformanceTest, ThePressGivesTheForceOfTheSimulatedOperator) {
  const std::vector<PressTick> press = SimulatedPress();
  const auto [first, last] = ContactOf(press);
  const auto bench = Opened();
  double peak = 0, worst = 0, worst_made = 0;
  long allocations = 0;
  bench->Play(press, last, [&](std::size_t i) {
    const Eigen::Vector3d& sent = bench->rig.loop.record().chain.sent;
    peak = std::max(peak, press[i].sent.norm());
    worst = std::max(worst, (sent - press[i].sent).norm());
    worst_made = std::max(worst_made, (bench->Made() - sent).norm());
    if (i == first + 100) allocations = bench->allocations();
  });
  ASSERT_GT(peak, 1.5);
  EXPECT_LT(worst, 0.01 * peak);
  EXPECT_LT(worst_made, kSlewPerTick) << "the device makes what the loop sends, a tick later";
  EXPECT_EQ(bench->allocations(), allocations);
}

// The device is unplugged at various times of a press, from before the contact to its end: the
// force is zero within 25 ms, the reason is reported, the tool does not move after 40 ms, and the
// closed switch does not engage. After it is plugged in again, there is no force before an
// engagement.
TEST_P(DeviceConformanceTest, UnpluggingAtAnyInstantEndsForceAndMotion) {
  const std::vector<PressTick> press = SimulatedPress(GetParam().speed);
  const auto [first, last] = ContactOf(press);
  const std::size_t begin = first - 50, instants = GetParam().instants;
  std::size_t in_force = 0;
  for (std::size_t k = 0; k < instants; ++k) {
    const auto bench = Opened();
    const std::size_t at = begin + k * (last - begin) / instants;
    bench->Play(press, at);
    ASSERT_EQ(bench->rig.state(), OperatorState::kFollowing) << at;
    if (bench->rig.loop.record().chain.sent.norm() > 0.1) ++in_force;
    bench->Unplug();
    Eigen::Vector3d tip(0, 0, 0);
    for (int ms = 1; ms <= 60; ++ms) {
      const TickRecord& record = bench->Step();
      if (ms >= 25) {
        ASSERT_EQ(bench->Made().norm(), 0) << at << " + " << ms;
        ASSERT_EQ(bench->device->status().output, DeviceOutput::kOff) << at << " + " << ms;
        ASSERT_THAT(FaultInWords(record.device), testing::HasSubstr(GetParam().loss));
      }
      if (ms == 40) tip = bench->rig.slave.tip();
      if (ms > 40) {
        ASSERT_EQ(bench->rig.slave.tip(), tip) << at << " + " << ms;
        ASSERT_FALSE(bench->rig.slave.engaged());
      }
    }
    bench->Replug();
    for (int ms = 0; ms < 50; ++ms) {
      bench->Step();
      ASSERT_NE(bench->rig.state(), OperatorState::kFollowing);
      ASSERT_EQ(bench->Made().norm(), 0);
    }
  }
  EXPECT_GT(in_force, instants / 4) << "the test did not unplug under force";
}

TEST_P(DeviceConformanceTest, TheEndLeavesNoForce) {
  const std::vector<PressTick> press = SimulatedPress(GetParam().speed);
  const auto [first, last] = ContactOf(press);
  const auto bench = Opened();
  bench->Play(press, (first + last) / 2);
  ASSERT_GT(bench->Made().norm(), 0.5);
  bench->device->StopTicks();
  bench->device->DropForce();
  bench->device.reset();
  EXPECT_EQ(bench->Made().norm(), 0);
}

INSTANTIATE_TEST_SUITE_P(Devices, DeviceConformanceTest, testing::ValuesIn(kMembers),
                         [](const auto& member) { return member.param.name; });

}  // namespace
}  // namespace palpate
