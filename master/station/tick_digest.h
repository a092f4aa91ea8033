// Reduces 1000 ticks a second for a page: the newest tick, a hundred samples a second for the
// charts, and counters.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <vector>

#include "master/haptics/tick_record.h"
#include "shared/state/sample_trace.h"

namespace palpate {

// A sample of ten milliseconds. Forces are magnitudes [N].
struct TickSample {
  std::uint64_t number = 0;      // rises by one per sample
  double t = 0;                  // of its last tick [s]
  double scaled = 0;             // M, of the last tick
  double sent = 0;               // M, the largest
  Eigen::Vector3d p_M{0, 0, 0};  // of the last tick [m]
  double age = -1;               // largest age of the newest state [s]; negative: none yet
  double round_trip = 0;         // the newest [s]; 0: none yet
  double longest_tick = 0;       // between two ticks [s]
  double energy = 0;             // of the last tick [J]; NaN: unknown
  // Commanded and last measured tool position of the last tick [m]; NaN: unknown.
  Eigen::Vector3d p_S{0, 0, 0}, p_S_tip{0, 0, 0};
};

class TickDigest {
 public:
  struct Moment {
    bool any = false;  // at least one tick was added
    double t = 0;      // of the newest tick, as in the log [s]
    Time begin{};      // when t is 0, master's clock
    TickRecord newest;
    double rate = 0;                  // over the last second [Hz]; 0: unknown yet
    std::uint64_t missed = 0;         // missed deadlines since the start
    double late_share = 0;            // share of the last 10 s with a late state [-]
    double round_trip = 0;            // the newest [s]; 0: none yet
    std::vector<TickSample> samples;  // the newest quarter of a second
  };

  // Adds a tick, in order. Returns its time, as in the log [s]. Called by one thread.
  double Add(const TickRecord& tick);
  [[nodiscard]] Moment Newest() const;                 // thread-safe
  [[nodiscard]] std::vector<TickSample> Past() const;  // of the last 10 s; thread-safe
  // Forgets all ticks; t then starts at `begin`. Thread-safe.
  void Restart(Time begin);

 private:
  static constexpr double kPeriod = 0.001, kSampleEvery = 0.010, kLate = 0.030;  // [s]
  static constexpr std::size_t kSamplesKept = 1000;
  static constexpr std::ptrdiff_t kSamplesOfMoment = 25;
  static constexpr std::size_t kSeconds = 10;
  struct Second {
    int ticks = 0, late = 0;
  };

  void Count(const TickRecord& tick, double since_last);
  void Sample(const TickRecord& tick, double since_last);

  mutable std::mutex mutex_;  // guards the members below
  Moment moment_;             // without the samples
  TickSample open_;           // unfinished sample
  std::deque<TickSample> samples_;
  std::deque<Second> seconds_;                  // complete seconds
  Second second_;                               // unfinished second
  double second_since_ = 0, sample_since_ = 0;  // their start times [s]
};

// End-to-end latency: the stages from the sample to the force of one tick.
// Duration of each stage [s]. Their sum is `total`.
struct HandTrace {
  std::uint64_t sample = 0, state = 0;  // numbers of the sample and of the state
  double t = 0;                         // of the tick, as in the log [s]
  double capture = 0;                   // from exposure or touch until the slave has the sample
  double sensing = 0;                   // vision or tactile processing
  double model = 0;
  double wait = 0;  // until the state is sent
  // Time on the link according to the clock offset, which may be wrong by half a round trip.
  double wire = 0;
  double tick = 0;  // from arrival of the state to the tick
  double total = 0;
};

// nullopt: the tick used no state, or a state of another sample.
std::optional<HandTrace> TraceOf(const TickRecord& tick, double t, const SampleTrace& sample);

}  // namespace palpate
