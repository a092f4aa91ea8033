// Examines the link to a slave as an observer. Nothing moves. Only the datagram test takes the
// lease.
#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "master/doctor/finding.h"
#include "master/link/slave_link.h"
#include "shared/telemetry/latency_histogram.h"

namespace palpate {

struct LinkSample {
  LatencyHistogram round_trip_us;             // of consecutive small calls
  double clock_offset = 0;                    // slave's clock minus master's clock [s]
  LatencyHistogram gap_us;                    // between consecutive arrivals of states
  std::uint64_t states = 0, gaps_beyond = 0;  // received; gaps longer than `dead_after`
  double seconds = 0;                         // duration of the measurement [s]
  // Age of the newest state's sample on arrival, by both clocks [s]. nullopt: nothing was sensed
  // yet.
  std::optional<double> age;
  std::string version, phase;  // the phase in words
  std::vector<std::string> alarms;
};

// Calls GetStatus repeatedly, then watches states for `seconds`. A requested `stop` ends both.
// Throws std::runtime_error with the reason if the slave rejects a call or the link fails.
LinkSample MeasureLink(const SlaveLink::Options& options, const RemoteScene& scene, double seconds,
                       const std::stop_token& stop = {});

// Findings from the measured numbers.
Findings CheckLink(const LinkSample& line, const RemoteScene& scene);

// Takes the lease without engaging, for at most `seconds` plus the round trips to begin. The result
// shows whether datagrams were received.
LinkStats TryDatagrams(SlaveLink::Options options, double seconds);
Finding CheckDatagrams(const LinkStats& tried);

// Connects, measures and evaluates the link. Tests datagrams if `options` request them. A failure
// is a finding. A requested `stop` ends it early, and the findings are then invalid.
Findings ExamineLink(const SlaveLink::Options& options, double seconds,
                     const std::stop_token& stop = {});

}  // namespace palpate
