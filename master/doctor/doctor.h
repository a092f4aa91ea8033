// `palpate-master doctor`: examines link, clock, priorities and device, and advises changes.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>

#include "master/doctor/finding.h"
#include "master/haptics/periodic.h"
#include "master/link/slave_link.h"

namespace palpate {

class Device;

// Finding about an open device.
Finding FoundOf(const Device& device);
// Findings about the device, this machine and, if `line` is set, the link, as an observer of the
// slave. Bad findings come last. Measures twice for `seconds`. A requested `stop` ends it early,
// and the findings are then invalid.
Findings Examine(Finding device, const std::optional<SlaveLink::Options>& line, double seconds,
                 const std::stop_token& stop = {});

struct DoctorOptions {
  std::optional<SlaveLink::Options> line;  // nullopt: examine this machine only
  std::string device;                      // empty: none
  double seconds = 2;                      // duration of each measurement [s], > 0
};

// Prints the findings, bad ones last. Returns 0 without a bad finding, else 1.
int RunDoctor(const DoctorOptions& options);

// Whether this machine can run a haptic loop.
//
// Runs an empty loop at 1 kHz with the priority of the haptic loop for `seconds`, and checks the
// permission for priority and locked memory. A requested `stop` ends it early.
Findings ExamineTimer(double seconds, const std::stop_token& stop = {});
// Number of processors, frequency governor and clock source, read below `sys`.
Findings ExamineProcessors(const std::filesystem::path& sys = "/sys");

// Finding about missed periods and late wake-ups of an empty loop.
Finding CheckTimer(const PeriodicStats& bare);

}  // namespace palpate
