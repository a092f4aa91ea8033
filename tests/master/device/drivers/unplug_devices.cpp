// Unplugs each device with force feedback ten times in real time, in the middle of a press against
// a virtual slave, and prints how long its force and the tool's motion last. The devices are fakes.
//
//   unplug_devices [PRESSES]
//
// Times are from the unplugging [ms]: `told` until a tick has the fault, `force` until the driver
// renders none, `moved` until the tool's last motion. `engaged` counts presses in which the switch
// that stayed closed engaged after the device was back. Exit code 1: a line does not hold.
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <mutex>

#include "master/device/haply/haply_device.h"
#include "shared/link/thread_priority.h"
#include "tests/master/device/drivers/driver_bench.h"
#include "tests/master/device/drivers/haply_service.h"

namespace palpate {
namespace {

using std::chrono::milliseconds;

constexpr double kForceWithin = 25, kStillAfter = 40;         // the lines [ms]
constexpr double kPressSpeed = 0.080;                         // [m/s]
constexpr milliseconds kBefore(200), kAway(250), kBack(200);  // of a press

// A fake, as this program uses it.
struct Handle {
  std::string name;
  std::function<std::unique_ptr<HapticDevice>()> open;
  std::function<void(const std::vector<PressTick>&)> follow;
  std::function<void(bool)> press;  // the switch
  std::function<void(bool)> plug;
};

Handle HandleOf(const BenchKind& kind) {
  const auto fake = std::make_shared<fakes::Library>(kind.folder, kind.file);
  fake->set_option("grip_stiffness", "inf");
  const std::vector<std::filesystem::path> folders{BinaryPath("/fakes/" + kind.folder)};
  const auto open = [kind, folders]() -> std::unique_ptr<HapticDevice> {
    if (kind.name == "dhd") return DhdDevice::Open({std::nullopt, folders});
    return TouchDevice::Open({"", folders});
  };
  return {kind.name, open,
          [kind, fake](const std::vector<PressTick>& press) { FollowPress(kind, *fake, press); },
          [fake](bool closed) { fake->press(0, closed ? 1 : 0, 0); },
          [fake](bool in) { in ? fake->replug() : fake->unplug(); }};
}

Handle HandleOfHaply(const std::string& api) {
  const auto service = std::make_shared<HaplyService>(api);
  service->Ask("set grip_stiffness inf");
  service->Ask("set gain 1");
  return {"haply " + api, [service] { return HaplyDevice::Open({service->port()}); },
          [service](const std::vector<PressTick>& press) { FollowPress(*service, press, 0); },
          [service](bool closed) { service->Ask(closed ? "press 0 1" : "press 0 0"); },
          [service](bool in) { service->Ask(in ? "replug" : "unplug"); }};
}

// A haptic loop and a slave, each on its own thread in real time.
class LiveLoop {
 public:
  explicit LiveLoop(HapticDevice* device)
      : slave_thread_([this](const std::stop_token& stop) { RunSlave(stop); }),
        loop_thread_([this, device](const std::stop_token& stop) {
          MakeThreadRealtime(kHapticPriority);
          loop_.Run(*device, std::chrono::hours(1), stop);
        }) {}

  // Sees each tick of the next `length`.
  void Watch(milliseconds length, const std::function<void(const TickRecord&)>& each) {
    const Time end = Clock::now() + length;
    while (Clock::now() < end) {
      TickRecord record;
      while (records_.Pop(&record)) each(record);
      std::this_thread::sleep_for(milliseconds(1));
    }
  }
  // When the tool moved last, and whether it is engaged.
  std::pair<Time, bool> tool() {
    const std::scoped_lock lock(mutex_);
    return {moved_at_, slave_.engaged()};
  }

 private:
  void RunSlave(const std::stop_token& stop) {
    MakeThreadRealtime(kLinkPriority);
    for (Time wake = Clock::now(); !stop.stop_requested(); wake += kHapticPeriod) {
      WaitUntil(wake);
      const std::scoped_lock lock(mutex_);
      const Eigen::Vector3d before = slave_.tip();
      slave_.Step(Clock::now(), &commands_, &states_);
      if (slave_.tip() != before) moved_at_ = Clock::now();
    }
  }

  LatestValue<ReceivedState> states_;
  LatestValue<OperatorCommand> commands_;
  SpscRing<TickRecord> records_{1024};
  HapticLoop loop_{{RenderMode::kLocal, {}, kForceLimit, kSlewPerTick},
                   {&states_, &commands_, &records_}};
  std::mutex mutex_;
  VirtualSlave slave_{VirtualSlave::Options()};
  Time moved_at_{};
  std::jthread slave_thread_, loop_thread_;  // last: they use the rest
};

struct Unplugging {
  double told = INFINITY, force = INFINITY, moved = 0;  // [ms]
  double force_before = 0;                              // [N]
  bool engaged_again = false;
  std::string words;
};

Unplugging UnplugOnce(const Handle& handle, const std::vector<PressTick>& press, milliseconds at) {
  const auto device = handle.open();
  device->LowerForceLimit(kForceLimit);
  handle.press(false);
  LiveLoop live(device.get());
  Unplugging result;
  const auto nothing = [](const TickRecord&) {};
  live.Watch(kBefore, nothing);
  handle.follow(press);
  handle.press(true);
  live.Watch(at, [&](const TickRecord& tick) { result.force_before = tick.chain.sent.norm(); });
  const Time unplugged = Clock::now();
  handle.plug(false);
  live.Watch(kAway, [&](const TickRecord& tick) {
    const double ms = 1e3 * SecondsBetween(unplugged, tick.at);
    if (tick.device.fault == DeviceFault::kNone) return;
    if (ms < result.told) result.words = FaultInWords(tick.device);
    result.told = std::min(result.told, ms);
    if (tick.device.output == DeviceOutput::kOff) result.force = std::min(result.force, ms);
  });
  result.moved = std::max(0.0, 1e3 * SecondsBetween(unplugged, live.tool().first));
  handle.plug(true);
  live.Watch(kBack, [&](const TickRecord& tick) {
    if (tick.state == OperatorState::kFollowing) result.engaged_again = true;
  });
  return result;
}

// The press from the tick before its engagement on.
std::vector<PressTick> PressToPlay() {
  std::vector<PressTick> press = SimulatedPress(kPressSpeed);
  const auto engaged = std::ranges::find_if(press, [](const PressTick& t) { return t.engaged; });
  press.erase(press.begin(), engaged - 1);
  return press;
}

// Whether the lines hold.
bool Measure(const Handle& handle, int presses) {
  const std::vector<PressTick> press = PressToPlay();
  const auto first =
      std::ranges::find_if(press, [](const PressTick& t) { return t.sent.norm() > 0; });
  const auto last =
      std::find_if(first, press.end(), [](const PressTick& t) { return t.sent.norm() == 0; });
  double told = 0, force = 0, moved = 0;
  int in_force = 0, engaged = 0;
  std::map<std::string, int> words;
  for (int k = 0; k < presses; ++k) {
    const auto at = (first - press.begin()) + k * (last - first) / presses;
    const Unplugging one = UnplugOnce(handle, press, milliseconds(at));
    told = std::max(told, one.told);
    force = std::max(force, one.force);
    moved = std::max(moved, one.moved);
    in_force += one.force_before > 0.1 ? 1 : 0;
    engaged += one.engaged_again ? 1 : 0;
    ++words[one.words];
  }
  std::printf("%-10s %7d %8d %9.1f %10.1f %10.1f %8d  ", handle.name.c_str(), presses, in_force,
              told, force, moved, engaged);
  for (const auto& [text, count] : words) std::printf(" %dx \"%s\"", count, text.c_str());
  std::printf("\n");
  return force <= kForceWithin && moved <= kStillAfter && engaged == 0 && !words.contains("");
}

int Run(int presses) {
  std::printf("%-10s %7s %8s %9s %10s %10s %8s   message\n", "device", "presses", "in force",
              "told [ms]", "force [ms]", "moved [ms]", "engaged");
  bool held = true;
  for (const BenchKind& kind : {TouchBench(), DhdBench()})
    held = Measure(HandleOf(kind), presses) && held;
  for (const char* api : {"3.1", "3.5"}) held = Measure(HandleOfHaply(api), presses) && held;
  std::printf("largest of each; accepted: force %.0f ms, moved %.0f ms, engaged 0: %s\n",
              kForceWithin, kStillAfter, held ? "held" : "NOT HELD");
  return held ? 0 : 1;
}

}  // namespace
}  // namespace palpate

int main(int count, char** arguments) {
  return palpate::Run(count > 1 ? std::atoi(arguments[1]) : 10);
}
