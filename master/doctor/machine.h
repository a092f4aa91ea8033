// Whether this machine can run a haptic loop.
#pragma once

#include <filesystem>
#include <stop_token>

#include "master/doctor/finding.h"
#include "master/haptics/periodic.h"

namespace palpate {

// Runs an empty loop at 1 kHz with the priority of the haptic loop for `seconds`, and checks the
// permission for priority and locked memory. A requested `stop` ends it early.
Findings ExamineTimer(double seconds, const std::stop_token& stop = {});
// Number of processors, frequency governor and clock source, read below `sys`.
Findings ExamineProcessors(const std::filesystem::path& sys = "/sys");

// Finding about missed periods and late wake-ups of an empty loop.
Finding CheckTimer(const PeriodicStats& bare);

}  // namespace palpate
