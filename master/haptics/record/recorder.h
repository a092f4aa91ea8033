// Takes the ticks from the haptic loop's ring, waits for the true force of their instant, and gives
// them to summary and log. Belongs to one slow thread.
#pragma once

#include <deque>
#include <filesystem>
#include <memory>

#include "master/haptics/record/tick_log.h"
#include "master/haptics/record/tick_summary.h"
#include "master/haptics/record/truth_track.h"
#include "master/haptics/spsc_ring.h"

namespace palpate {

class Recorder {
 public:
  static constexpr double kPatience = 0.5;  // a tick waits so long for its true force [s]

  // `log` may be empty: no log. Throws std::runtime_error: it cannot be written.
  Recorder(SpscRing<TickRecord>* ring, const std::filesystem::path& log);

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

  SpscRing<TickRecord>* ring_;
  std::unique_ptr<TickLog> log_;
  TickSummary summary_;
  TruthTrack truth_;
  std::deque<TickRecord> waiting_;
  TickRecord newest_;
  Time begin_{};
  std::uint64_t taken_ = 0;
};

}  // namespace palpate
