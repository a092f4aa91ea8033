#include "master/device/search/driver.h"

#include <chrono>
#include <thread>

namespace palpate {
namespace {

constexpr const char* kNotSeen =
    "plug the device in; deploy/guides/own-haptic-device.md says how to see whether lsusb lists it "
    "and this user may open it";
constexpr auto kPollPeriod = std::chrono::milliseconds(5),
               kStopTimeout = std::chrono::milliseconds(200);

// The status of the first usable reading, or of the last one.
DeviceStatus FirstStatus(HapticDevice* device) {
  DeviceStatus status;
  for (auto left = kStopTimeout; left.count() > 0; left -= kPollPeriod) {
    status = device->Read(Clock::now()).status;
    if (status.fault == DeviceFault::kNone) break;
    std::this_thread::sleep_for(kPollPeriod);
  }
  return status;
}

}  // namespace

void AddLibrary(const LibrarySearch& search, const SharedLibrary& library, DriverReport* report) {
  report->searched.push_back(InWords(search));
  const std::string problem = library.problem();
  if (!library.file().empty()) report->found.push_back(library.file());
  if (!problem.empty()) report->missing.push_back(problem);
}

void AddOpened(const Driver& driver, DriverReport* report) {
  try {
    const auto device = driver.open("");
    const DeviceStatus status = FirstStatus(device.get());
    report->found.push_back(device->description());
    report->found.push_back(InWords(device->capabilities()));
    report->found.push_back(InWords(status));
    const std::string fault = FaultInWords(status);
    if (fault.empty()) {
      report->usable = true;
      return;
    }
    report->missing.push_back("a good reading: " + fault);
    if (report->next.empty()) report->next = NextStepOf(status.fault);
  } catch (const DeviceUnavailable& error) {
    report->missing.push_back(error.reason());
    if (report->next.empty()) report->next = kNotSeen;
  } catch (const std::exception& error) {
    report->missing.emplace_back(error.what());
  }
}

}  // namespace palpate
