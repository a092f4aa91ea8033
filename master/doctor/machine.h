// Whether this machine can run a haptic loop.
#pragma once

#include <filesystem>
#include <stop_token>

#include "master/doctor/finding.h"
#include "master/haptics/periodic.h"

namespace palpate {

// A bare loop at 1 kHz under the haptic loop's priority, for `seconds`, and what it may lock and
// claim. Takes that long, or until `stop` is asked for.
Findings ExamineTimer(double seconds, const std::stop_token& stop = {});
// Processors: how many, at which pace, by which clock. `sys`: where the system tells of itself.
Findings ExamineProcessors(const std::filesystem::path& sys = "/sys");

// What a bare loop's numbers mean for a hand: periods missed and late wake-ups.
Finding CheckTimer(const PeriodicStats& bare);

}  // namespace palpate
