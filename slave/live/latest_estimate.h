// The newest contact estimate, shared between the sensing thread and all others, with events since
// the last query, alarms and the sample rate.
#pragma once

#include <atomic>
#include <chrono>
#include <deque>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/sample_trace.h"
#include "shared/state/slave_state.h"
#include "slave/live/operator_port.h"
#include "slave/live/slave.h"

namespace palpate {

// Thread-safe; every call is short.
class LatestEstimate {
 public:
  // `sensor_rate` [Hz] defines when it is stale: after three periods, or 60 ms if that is longer
  // (slave/CHECKS.md). `p_S_tip`: tip position before the first sample [m].
  LatestEstimate(double sensor_rate, const Eigen::Vector3d& p_S_tip);

  // `trace`: timing so far; this function adds the rest.
  void Put(const ContactEstimate& estimate, SampleTrace trace = {});
  void Add(Event event);
  // Logs it as well. Of each `kind`, which is a literal, the newest text and the count are kept.
  void RaiseAlarm(std::string_view kind, const std::string& text);
  // From now on samples are delayed intentionally by this time [s].
  void SetIdleWait(double idle_wait) { idle_wait_ = idle_wait; }
  // Wakes waiting threads.
  void Wake() { changed_.notify_all(); }

  [[nodiscard]] ContactEstimate Get() const;
  // Returns the newest estimate, with kStale if it is too old at `now`.
  [[nodiscard]] ContactEstimate Fresh(Time now) const;
  // Returns whether the tool or a fingertip touches the object according to the last estimate, with
  // any validity.
  [[nodiscard]] bool Touches() const;
  // Returns whether the tool touches, also if the contact is flagged. A lost tip shows no contact,
  // and neither does an estimate whose rest state is wrong, which only a new one can correct.
  [[nodiscard]] bool TouchesAsFarAsKnown() const;
  // Returns at most a few hundred traces, the newest ones; see Slave.
  [[nodiscard]] std::vector<SampleTrace> TracesSince(Time sensed_at) const;
  Events TakeEvents();
  bool WaitForNewer(Time sensed_at, std::chrono::milliseconds timeout);
  // Estimate and operator state as of `now`; without sequence, events and true force.
  [[nodiscard]] SlaveState Compose(const OperatorPort& port, Time now) const;
  // Validity, counts, rate and alarms.
  void Describe(SlaveStatus* status) const;

 private:
  struct Alarm {
    std::string_view kind;
    std::string newest;
    int count = 0;
  };
  const double stale_after_;          // [s]
  std::atomic<double> idle_wait_{0};  // [s]
  // Inherits priority, because threads that request the status are less urgent than the sensing.
  mutable PriorityInheritanceMutex mutex_;  // guards the members below
  PriorityInheritanceCondition changed_;
  ContactEstimate estimate_;
  Events events_;
  std::vector<Alarm> alarms_;
  std::uint64_t frames_ = 0;
  std::vector<Time> recent_;  // stamps of the last second
  std::deque<SampleTrace> traces_;
};

}  // namespace palpate
