#include "master/commands/axes_command.h"

#include <chrono>
#include <cstdio>
#include <thread>

#include "master/device/device.h"
#include "master/haptics/periodic.h"
#include "master/haptics/tick_drive.h"
#include "master/motion/axis_wizard.h"
#include "shared/link/latest_value.h"

namespace palpate {
namespace {

constexpr double kForever = 1e6;  // [s]
constexpr auto kPoll = std::chrono::milliseconds(5);

void Say(const std::string& sentence) {
  if (sentence.empty()) return;
  std::puts(sentence.c_str());
  std::fflush(stdout);
}

}  // namespace

int FindAxes(const std::string& device_name, const std::function<bool()>& stopped) {
  constexpr double kPressDepth = 0.005, kPressSpeed = 0.02;  // of the simulated operator [m], [m/s]
  const auto device = OpenDevice(device_name, kPressDepth, kPressSpeed);
  Say("device " + device->description());
  LatestValue<DeviceReading> readings;
  TickDrive drive(*device, [&](Time now) {
    readings.Put(device->Read(now));
    device->WriteForce(Eigen::Vector3d::Zero());
    return !device->finished();
  });
  std::jthread haptic([&](const std::stop_token& stop) {
    PeriodicStats unused;
    drive.Run(Seconds(kForever), stop, &unused);
  });
  AxisWizard wizard;
  const Time begin = Clock::now();
  DeviceFault fault = DeviceFault::kNone;
  while (!wizard.axes() && !stopped()) {
    std::this_thread::sleep_for(kPoll);
    if (const DeviceReading* reading = readings.Take()) {
      if (reading->status.fault == DeviceFault::kNone) {
        Say(wizard.Add(reading->p_M, SecondsBetween(begin, Clock::now())));
      } else if (reading->status.fault != fault) {
        Say(FaultInWords(reading->status) + ". " + std::string(NextStepOf(reading->status.fault)));
      }
      fault = reading->status.fault;
    } else if (device->finished()) {
      break;
    }
  }
  haptic.request_stop();
  haptic.join();
  drive.Stop();
  device->DropForce();
  if (!wizard.axes()) return 1;
  Say("connect HOST:PORT --device " + device_name + " --axes=" + ToString(*wizard.axes()) +
      (wizard.axes()->is_mirrored() ? "   (mirrored: check the three motions)" : ""));
  return 0;
}

}  // namespace palpate
