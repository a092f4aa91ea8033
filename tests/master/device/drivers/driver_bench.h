// A driver with its fake library, a haptic loop and a virtual slave, all on the fake's injected
// clock.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "master/device/dhd/dhd_device.h"
#include "master/device/sim_hand.h"
#include "master/device/touch/touch_device.h"
#include "tests/master/device/fakes/fake_library.h"
#include "tests/master/haptics/rig.h"
#include "tests/support/allocation_count.h"
#include "tests/support/paths.h"

namespace palpate {

constexpr double kBenchTick = 0.001;  // [s]
constexpr double kSlewPerTick = 0.2;  // [N]
constexpr double kForceLimit = 3.3;   // of the master [N]

// One tick of a press.
struct PressTick {
  Eigen::Vector3d p_M{0, 0, 0}, sent{0, 0, 0};
  bool engaged = false;
};

// The simulated operator's press against the virtual slave's wall, 4 s, at a peak `speed` [m/s].
inline std::vector<PressTick> SimulatedPress(double speed = 0.020) {
  Rig rig({}, RenderMode::kLocal, kForceLimit, kSlewPerTick);
  SimHand hand(0.004, speed);
  std::vector<PressTick> ticks;
  for (int i = 0; i < 4000; ++i) {
    const TickRecord& record = rig.Tick(hand);
    ticks.push_back(
        {record.p_M, record.chain.sent,
         record.state == OperatorState::kAligning || record.state == OperatorState::kFollowing});
  }
  return ticks;
}

// What the tests need to know of a driver.
struct BenchKind {
  std::string name, folder, file;
  Eigen::Vector3d (*to_device)(const Eigen::Vector3d& m);  // frame M to that of the fake
  Eigen::Vector3d (*to_M)(const Eigen::Vector3d& d);
  std::unique_ptr<HapticDevice> (*open)(const std::string& folder, std::function<Time()> clock);
};
inline BenchKind TouchBench() {
  const auto same = [](const Eigen::Vector3d& p) { return p; };
  return {
      "touch",
      "hd",
      "libHD.so",
      same,
      same,
      [](const std::string& folder, std::function<Time()> clock) -> std::unique_ptr<HapticDevice> {
        return TouchDevice::Open({"", {folder}, std::move(clock)});
      }};
}
inline BenchKind DhdBench() {
  return {"dhd",
          "dhd",
          "libdhd.so",
          [](const Eigen::Vector3d& m) { return Eigen::Vector3d(m.z(), m.x(), m.y()); },
          [](const Eigen::Vector3d& d) { return Eigen::Vector3d(d.y(), d.z(), d.x()); },
          [](const std::string& folder, std::function<Time()>) -> std::unique_ptr<HapticDevice> {
            return DhdDevice::Open({std::nullopt, {folder}, false});
          }};
}

// The fake's hand follows `press` from where it is.
inline void FollowPress(const BenchKind& kind, const fakes::Library& fake,
                        const std::vector<PressTick>& press) {
  std::vector<FakeKnot> knots;
  for (std::size_t i = 0; i < press.size(); ++i) {
    const Eigen::Vector3d d = kind.to_device(press[i].p_M);
    knots.push_back({kBenchTick * static_cast<double>(i + 1), d.x(), d.y(), d.z()});
  }
  fake.follow(knots.data(), static_cast<int>(knots.size()));
}

class DriverBench {
 public:
  explicit DriverBench(BenchKind kind)
      : kind_(std::move(kind)),
        fake(kind_.folder, kind_.file),
        rig({}, RenderMode::kLocal, kForceLimit, kSlewPerTick) {
    fake.set_clock(0);
    fake.set_option("resolution", "1e-7");  // so that forces compare
    fake.place(0, 0, 0);
  }
  ~DriverBench() {
    if (device) device->StopTicks();
    device.reset();
  }
  DriverBench(const DriverBench&) = delete;
  DriverBench& operator=(const DriverBench&) = delete;

  void Open() {
    device = kind_.open(BinaryPath("/fakes/" + kind_.folder), [this] { return Now(); });
    device->LowerForceLimit(kForceLimit);
    driven_ = device->StartTicks(&tick_);
  }
  [[nodiscard]] Time Now() const { return Time{std::chrono::hours(1)} + Seconds(fake.now()); }
  void Place(const Eigen::Vector3d& p_M) {
    const Eigen::Vector3d d = kind_.to_device(p_M);
    fake.place(d.x(), d.y(), d.z());
  }
  // One millisecond. Where the device's own thread is silent, the loop's takes over.
  const TickRecord& Step() {
    const long before = OwnAllocationCount();
    fake.step(kBenchTick);
    const bool silent = SecondsBetween(driven_at_, Now()) >= Device::kLetGoAfter;
    if (!driven_ || silent) Tick(Now());
    allocations_ += OwnAllocationCount() - before;
    return rig.loop.record();
  }
  // By driver, fake and haptic loop so far, without the virtual slave.
  [[nodiscard]] long allocations() const { return allocations_; }
  // The newest command that the device took: when [s], and its force [N].
  [[nodiscard]] std::pair<double, Eigen::Vector3d> Asked() const {
    double f[3] = {};
    const double t = fake.last_command(f);
    return {t, kind_.to_M({f[0], f[1], f[2]})};
  }
  // Force that the motors make now, M [N].
  [[nodiscard]] Eigen::Vector3d Made() const {
    double f[3] = {};
    fake.last_force(f);
    return kind_.to_M({f[0], f[1], f[2]});
  }
  // Plays `press` with the switch as its operator had it, until `ticks`.
  void Play(const std::vector<PressTick>& press, std::size_t ticks,
            const std::function<void(std::size_t)>& each = {}) {
    FollowPress(kind_, fake, press);
    for (std::size_t i = 0; i < ticks; ++i) {
      if (i == 0 || press[i].engaged != press[i - 1].engaged) {
        fake.press(0, press[i].engaged ? 1 : 0, 0);
      }
      Step();
      if (each) each(i);
    }
  }

 private:
  void Tick(Time now) {
    rig.now = now;
    const long before = OwnAllocationCount();
    rig.slave.Step(now, &rig.commands, &rig.states);
    allocations_ -= OwnAllocationCount() - before;
    device->WriteForce(rig.loop.Tick(device->Read(now), now));
    TickRecord drained;
    while (rig.records.Pop(&drained)) {
    }
  }

  const BenchKind kind_;
  bool driven_ = false;
  long allocations_ = 0;
  Time driven_at_{};
  const Device::Tick tick_ = [this](Time now) {
    driven_at_ = now;
    Tick(now);
  };

 public:
  fakes::Library fake;
  Rig rig;
  std::unique_ptr<HapticDevice> device;
};

}  // namespace palpate
