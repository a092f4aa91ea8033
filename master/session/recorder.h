// Reads ticks from the haptic loop's ring, waits for the true force of the same instant, and passes
// them to summary and log. Used by one slow thread.
#pragma once

#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "palpate/v1/recording.pb.h"

#include "master/haptics/spsc_ring.h"
#include "master/haptics/tick_record.h"
#include "master/session/tick_summary.h"
#include "shared/state/clock.h"

namespace palpate {

// log.csv: one row per tick, readable up to the last flush even after a crash.
//
//   t,state,p_M_*,p_S_*,estimated_*,local_*,scaled_*,passive_*,limited_*,sent_*,true_*,age_s,reason
//
// `*` means x, y, z. SI units; unknown values are
// empty. `reason` has reasons joined by `+`, and `mark` in the tick of a mark. About 0.2 MB per
// second.
class TickLog {
 public:
  // Overwrites the file. Throws std::runtime_error if it cannot write.
  explicit TickLog(const std::filesystem::path& file);
  // `t` [s] since the run began.
  void Add(double t, const TickRecord& record, const std::optional<Eigen::Vector3d>& truth);
  // Writes complete rows to the file.
  void Flush();
  // The reason of missing rows; empty: none.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }

 private:
  std::filesystem::path file_;
  std::ofstream out_;
  v1::ForceTick tick_;       // the last one
  std::string rows_;         // not yet flushed
  std::uint32_t marks_ = 0;  // so far
  std::string trouble_;
};

// The true force over time from the states that carry it, linear between them.
class TruthTrack {
 public:
  // Adds a sample. `at` must not be before the last; an equal time is ignored.
  void Add(Time at, const Eigen::Vector3d& force_S);
  // True force at `t` [N]; empty outside of the samples, or between two that are more than 100 ms
  // apart.
  [[nodiscard]] std::optional<Eigen::Vector3d> At(Time t) const;
  [[nodiscard]] bool empty() const { return samples_.empty(); }
  // Returns whether there is a sample at `t` or later.
  [[nodiscard]] bool Reaches(Time t) const { return !samples_.empty() && samples_.back().at >= t; }
  // Forgets samples that At(t) and later times do not need.
  void DropBefore(Time t);

 private:
  struct Sample {
    Time at;
    Eigen::Vector3d force;
  };
  std::deque<Sample> samples_;
};

class Recorder {
 public:
  // A tick waits kMaxWait [s] plus kTrips round trips for its true force.
  static constexpr double kMaxWait = 0.5, kTrips = 1.5;

  // Called for each tick, in order.
  using TickObserver = std::function<void(const TickRecord&)>;

  // `log` and `observer` may be empty. Throws std::runtime_error if the log cannot be written.
  Recorder(SpscRing<TickRecord>* ring, const std::filesystem::path& log,
           TickObserver observer = {});

  // Reads the ring and completes ticks whose wait has ended at `now`.
  void Drain(Time now);
  // Reads and completes all ticks.
  void Finish();

  [[nodiscard]] const TickSummary& summary() const { return summary_; }
  [[nodiscard]] const TickRecord& newest() const {
    return newest_;
  }                                                             // default-constructed: none yet
  [[nodiscard]] std::uint64_t taken() const { return taken_; }  // number of ticks so far
  [[nodiscard]] std::string trouble() const { return log_ ? log_->trouble() : std::string(); }

 private:
  void Take(const TickRecord& record);
  void FinishFirst();
  // Returns whether the true force of `record` is known.
  [[nodiscard]] bool IsKnown(const TickRecord& record) const;

  SpscRing<TickRecord>* ring_;
  TickObserver observer_;
  std::unique_ptr<TickLog> log_;
  TickSummary summary_;
  TruthTrack truth_;       // over the time of the sample
  TruthTrack placed_;      // over the time of the command that the slave executed then
  double round_trip_ = 0;  // the newest known [s]
  std::deque<TickRecord> waiting_;
  TickRecord newest_;
  Time begin_{};
  std::uint64_t taken_ = 0;
};

}  // namespace palpate
