// What the line to a slave allows, seen as an observer: nothing moves.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "master/doctor/finding.h"
#include "master/link/slave_link.h"
#include "shared/telemetry/latency_histogram.h"

namespace palpate {

struct LineSample {
  LatencyHistogram round_trip_us;             // of small calls, one after the other
  double clock_offset = 0;                    // the slave's clock minus ours [s]
  LatencyHistogram gap_us;                    // between two states as they came
  std::uint64_t states = 0, gaps_beyond = 0;  // that came; gaps longer than `dead_after`
  double seconds = 0;                         // of watching [s]
  double age = 0;  // of the newest state's sample when it came, by the slave's clock and ours [s]
  std::string version, phase;
  std::vector<std::string> alarms;
};

// Calls GetStatus often, then watches states for `seconds`. Throws std::runtime_error: in words
// what the slave refused, or that the line broke.
LineSample MeasureLine(const SlaveLink::Options& options, const RemoteScene& scene, double seconds);

// What the numbers mean for a hand.
Findings JudgeLine(const LineSample& line, const RemoteScene& scene);

// Connects, measures, judges. What fails is a finding.
Findings ExamineLine(const SlaveLink::Options& options, double seconds);

}  // namespace palpate
