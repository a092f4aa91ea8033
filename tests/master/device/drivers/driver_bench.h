// A driver that uses a fake of its vendor's library.
#pragma once

#include <string>

#include "master/device/dhd/dhd_device.h"
#include "master/device/touch/touch_device.h"
#include "tests/master/device/drivers/device_bench.h"
#include "tests/master/device/fakes/fake_library.h"
#include "tests/support/allocation_count.h"
#include "tests/support/paths.h"

namespace palpate {

// Properties of a driver that the tests need.
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

class DriverBench final : public DeviceBench {
 public:
  explicit DriverBench(BenchKind kind) : kind_(std::move(kind)), fake(kind_.folder, kind_.file) {
    fake.set_clock(0);
    fake.set_option("resolution", "1e-7");  // so that forces can be compared
    fake.place(0, 0, 0);
  }
  ~DriverBench() override {
    if (device) device->StopTicks();
    device.reset();
  }

  void Open() override {
    device = kind_.open(BinaryPath("/fakes/" + kind_.folder), [this] { return Now(); });
    device->LowerForceLimit(kForceLimit);
    driven_ = device->StartTicks(&tick_);
  }
  [[nodiscard]] Time Now() const { return Time{std::chrono::hours(1)} + Seconds(fake.now()); }
  void Place(const Eigen::Vector3d& p_M) {
    const Eigen::Vector3d d = kind_.to_device(p_M);
    fake.place(d.x(), d.y(), d.z());
  }
  void Follow(const std::vector<PressTick>& press) override {
    std::vector<FakeKnot> knots;
    for (std::size_t i = 0; i < press.size(); ++i) {
      const Eigen::Vector3d d = kind_.to_device(press[i].p_M);
      knots.push_back({kBenchTick * static_cast<double>(i + 1), d.x(), d.y(), d.z()});
    }
    fake.follow(knots.data(), static_cast<int>(knots.size()));
  }
  void Switch(bool is_closed) override { fake.press(0, is_closed ? 1 : 0, 0); }
  void Unplug() override { fake.unplug(); }
  void Replug() override { fake.replug(); }
  // If the device's own thread makes no tick, the loop's thread makes it.
  const TickRecord& Step() override {
    const long before = OwnAllocationCount();
    fake.step(kBenchTick);
    const bool silent = SecondsBetween(driven_at_, Now()) >= Device::kLetGoAfter;
    if (!driven_ || silent) Tick(Now());
    allocations_ += OwnAllocationCount() - before;
    return rig.loop.record();
  }
  // Counts the allocations of the fake as well.
  [[nodiscard]] long allocations() const override { return allocations_; }
  // Returns time [s] and force [N] of the newest command that the device accepted.
  [[nodiscard]] std::pair<double, Eigen::Vector3d> Asked() const {
    double f[3] = {};
    const double t = fake.last_command(f);
    return {t, kind_.to_M({f[0], f[1], f[2]})};
  }
  [[nodiscard]] Eigen::Vector3d Made() const override {
    double f[3] = {};
    fake.last_force(f);
    return kind_.to_M({f[0], f[1], f[2]});
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
};

}  // namespace palpate
