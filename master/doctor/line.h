// What the line to a slave allows: nothing moves. Seen as an observer, unless datagrams are tried.
#pragma once

#include <optional>
#include <stop_token>
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
  std::string version, phase;  // the phase in words
  std::vector<std::string> alarms;
};

// Calls GetStatus often, then watches states for `seconds`, each until `stop` is asked for. Throws
// std::runtime_error: in words what the slave refused, or that the line broke.
LineSample MeasureLine(const SlaveLink::Options& options, const RemoteScene& scene, double seconds,
                       const std::stop_token& stop = {});

// What the numbers mean for a hand.
Findings CheckLine(const LineSample& line, const RemoteScene& scene);

// Holds the lease for as long as it takes, at most `seconds` and what the line needs, engages
// nobody, and tells whether datagrams came.
LinkStats TryDatagrams(SlaveLink::Options options, double seconds);
Finding CheckDatagrams(const LinkStats& tried);

// Connects, measures, judges; tries datagrams if `options` ask for them. What fails is a finding.
// Ends early where `stop` is asked for, and what it found is nothing then.
Findings ExamineLine(const SlaveLink::Options& options, double seconds,
                     const std::stop_token& stop = {});

}  // namespace palpate
