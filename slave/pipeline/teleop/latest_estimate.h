// The newest felt state, where the sensor's thread leaves it and everybody else finds it: with the
// events since they were last asked for, alarms, and how often something comes.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

#include "shared/state/sample_trace.h"
#include "shared/state/slave_state.h"
#include "slave/pipeline/teleop/operator_port.h"
#include "slave/pipeline/teleop/slave.h"

namespace palpate {

// Thread-safe; every call is short.
class LatestEstimate {
 public:
  // `sensor_rate` [Hz] decides when it is stale: after three periods, or 60 ms if that is longer
  // (contracts, wire).
  // `p_S_tip`: where the tip is before anything was sensed [m].
  LatestEstimate(double sensor_rate, const Eigen::Vector3d& p_S_tip);

  // `trace`: when it came so far; the rest is filled in.
  void Put(const ContactEstimate& felt, SampleTrace trace = {});
  void Add(Event event);
  // Logs it too; only the first few are kept.
  void RaiseAlarm(const std::string& text);
  // From now on a sample comes so much later than the sensor could bring it [s], on purpose.
  void SetNap(double nap) { nap_ = nap; }
  // Those that wait look again.
  void Wake() { changed_.notify_all(); }

  [[nodiscard]] ContactEstimate Get() const;
  // The same, stale where it is as of `now`.
  [[nodiscard]] ContactEstimate Fresh(Time now) const;
  // The tool or a fingertip touches the object.
  [[nodiscard]] bool Touches() const;
  // The newest few hundred at most, see Slave.
  [[nodiscard]] std::vector<SampleTrace> TracesSince(Time sensed_at) const;
  Events TakeEvents();
  bool WaitForNewer(Time sensed_at, std::chrono::milliseconds patience);
  // What was felt and what the operator does, as of `now`; no sequence, events or true force.
  [[nodiscard]] SlaveState Compose(const OperatorPort& port, Time now) const;
  // Validity, counts, rate and alarms.
  void Describe(SlaveStatus* status) const;

 private:
  const double stale_after_;    // [s]
  std::atomic<double> nap_{0};  // [s]
  mutable std::mutex mutex_;    // guards what follows
  std::condition_variable changed_;
  ContactEstimate felt_;
  Events events_;
  std::vector<std::string> alarms_;
  std::uint64_t frames_ = 0;
  std::vector<Time> recent_;  // stamps of the last second
  std::deque<SampleTrace> traces_;
};

}  // namespace palpate
