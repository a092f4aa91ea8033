// Takes the ticks from the haptic loop's ring, waits for the true force of their instant, and gives
// them to summary and log. Belongs to one slow thread.
#pragma once

#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "master/haptics/record/tick_record.h"
#include "master/haptics/record/tick_summary.h"
#include "master/haptics/spsc_ring.h"
#include "shared/state/clock.h"

namespace palpate {

// log.csv: one row per tick, readable up to the last flush whatever happens.
//
//   t,state,p_M_*,p_S_*,estimated_*,local_*,scaled_*,passive_*,limited_*,sent_*,true_*,age_s,reason
//
// `*` stands for _x, _y, _z. SI; what is unknown is empty; `reason` is joined by `+`;
// `mark` stands there, too, in the tick in which the operator made one. About 0.2 MB per second.
class TickLog {
 public:
  // Begins the file anew. Throws std::runtime_error: it cannot be written.
  explicit TickLog(const std::filesystem::path& file);
  // `t` [s] since the run began.
  void Add(double t, const TickRecord& record, const std::optional<Eigen::Vector3d>& truth);
  // Whole rows reach the file.
  void Flush();
  // Empty, or why rows are missing.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }

 private:
  std::filesystem::path file_;
  std::ofstream out_;
  std::string rows_;         // not yet flushed
  std::uint32_t marks_ = 0;  // so far
  std::string trouble_;
};

// The true force over time, pieced together from the states that carried it: linear between them.
class TruthTrack {
 public:
  // `at` must not lie before the last; an equal one is ignored.
  void Add(Time at, const Eigen::Vector3d& force_S);
  // Truth at `t` [N]; nothing before the first sample, after the last, or between two that lie more
  // than 100 ms apart.
  [[nodiscard]] std::optional<Eigen::Vector3d> At(Time t) const;
  [[nodiscard]] bool empty() const { return samples_.empty(); }
  // A sample at `t` or later has come.
  [[nodiscard]] bool Reaches(Time t) const { return !samples_.empty() && samples_.back().at >= t; }
  // Forgets what At(t) and later do not need.
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
  // A tick waits so long for its true force, beside kTrips round trips [s].
  static constexpr double kPatience = 0.5, kTrips = 1.5;

  // Looks on as ticks are taken, in their order.
  using Onlooker = std::function<void(const TickRecord&)>;

  // `log` may be empty: no log; so may `onlooker`. Throws std::runtime_error: it cannot be written.
  Recorder(SpscRing<TickRecord>* ring, const std::filesystem::path& log, Onlooker onlooker = {});

  // Takes what the ring holds and finishes what is ripe at `now`.
  void Drain(Time now);
  // Takes and finishes everything.
  void Finish();

  [[nodiscard]] const TickSummary& summary() const { return summary_; }
  [[nodiscard]] const TickRecord& newest() const { return newest_; }  // default: none yet
  [[nodiscard]] std::uint64_t taken() const { return taken_; }        // ticks, so far
  [[nodiscard]] std::string trouble() const { return log_ ? log_->trouble() : std::string(); }

 private:
  void Take(const TickRecord& record);
  void FinishFirst();
  // Its true force has come.
  [[nodiscard]] bool IsKnown(const TickRecord& record) const;

  SpscRing<TickRecord>* ring_;
  Onlooker onlooker_;
  std::unique_ptr<TickLog> log_;
  TickSummary summary_;
  TruthTrack truth_;       // over the instant
  TruthTrack placed_;      // over the instant at which what the slave did then was commanded
  double round_trip_ = 0;  // the newest told [s]
  std::deque<TickRecord> waiting_;
  TickRecord newest_;
  Time begin_{};
  std::uint64_t taken_ = 0;
};

}  // namespace palpate
