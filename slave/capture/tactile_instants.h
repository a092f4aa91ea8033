// When the frames of a recording are due, and between which of its samples each lies.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include <Eigen/Geometry>

#include "slave/capture/tactile_recording.h"

namespace palpate {

struct TactileInstant {
  double t = 0;            // [s], of the recording's clock
  std::size_t before = 0;  // index of the sample at or before it
  double share = 0;        // of the sample after `before`, 0 to less than 1
  bool after_gap = false;
};

// The typical time between two samples [s]: the median. 0: fewer than two samples.
double MedianPeriod(const std::vector<double>& t);

// Throws std::runtime_error `file: ...`: a sample every `period` [s] is less than a quarter of
// `rate` [Hz]; what lies between such samples would be made up.
void RefuseSlow(const std::filesystem::path& file, double period, double rate);

// Instants 1 / `rate` [Hz] apart; after a gap longer than `largest_gap` [s], anew from the first
// sample behind it.
std::vector<TactileInstant> SteadyInstants(const std::vector<double>& t, double rate,
                                           double largest_gap);
// Every sample as it is, and instants about `period` [s] apart where samples are missing: that is,
// where the two samples before and behind a long step do not make up for it. A stamp that comes
// late is followed by one that seems early, and nothing is missing. `period`: the typical one.
std::vector<TactileInstant> InstantsOfSamples(const std::vector<double>& t, double period,
                                              double largest_gap);

// What the fingers read at `instant`, linear between samples.
TactileFrame FrameAt(const TactileRecording& recording, const TactileInstant& instant);
// `share` of the way from one reading to another, 0 to 1; a pose where both have one.
FingerReading Between(const FingerReading& from, const FingerReading& to, double share) noexcept;
// Linear in place, spherically linear in rotation.
Eigen::Isometry3d Between(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
                          double share) noexcept;

}  // namespace palpate
