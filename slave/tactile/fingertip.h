// Fingertip converts the counts of one fingertip to its force, contact point and contact state
// (paper B, III.A).
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/state/verdict.h"
#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"
#include "slave/tactile/baseline.h"
#include "slave/tactile/channel_signals.h"
#include "slave/tactile/localise/localiser.h"
#include "slave/tactile/signal_model.h"
#include "slave/tactile/stuck_electrodes.h"
#include "slave/tactile/window_force.h"

namespace palpate {

// Result of one sample of a fingertip. Frame F. `Verdict`: of the force, before the checks.
struct FingerTouch : Verdict {
  FingerTouch() : Verdict{Validity::kTrackingLost} {}

  std::optional<Eigen::Vector3d> force_F;  // of the fingertip on the object [N]; nullopt: unknown
  double sigma = 0;                        // rms error of the force vector [N]
  TouchPlace place;                        // of this sample; while touching the last usable one
  bool touching = false;
  std::optional<double> drift;  // of all electrodes together since the baseline [counts]
  bool is_baseline = false;     // the sample belongs to the baseline
};

// Samples that are missing for less than 60 ms are interpolated linearly when the next one comes,
// so that the network's window stays full. So are repeated samples, if electrodes have noise.
//
// Validity: kTrackingLost while the baseline is measured, until the network's window is full, and
// after samples that are missing for 60 ms or are not finite; kStale, with the last numbers, from
// the third missing sample on; before that the last numbers, with a sigma that grows with the rate
// of the force; kFailed without a network; else kValid, subject to the checks
// (MakeFingertipChecks). A gap restarts the window, but not the baseline.
//
// Contact begins with a sample that has an active electrode and a force above half the network's
// error. It ends when for 50 ms no electrode is active or the force is below a quarter of that
// error, because on soft foam contacts are lost for a few samples (paper B, V). Without a force
// only the electrodes decide.
class Fingertip {
 public:
  // `network` null: forces are unknown. The arguments must outlive the fingertip.
  Fingertip(const Tactile& tactile, const ForceNetwork* network, const Localiser& localiser);

  // Processes the next sample; `after_gap`: samples are missing just before it; `is_clear`: contact
  // is impossible, so the baseline may be updated. Allocation-free; the sample that completes the
  // baseline runs the network over all stored samples.
  const FingerTouch& Estimate(const FingerReading& reading, bool after_gap,
                              bool is_clear = false) noexcept;
  // Measures the baseline again.
  void Reset() noexcept;

  [[nodiscard]] const FingerTouch& touch() const { return touch_; }
  // Returns the time of the cross-checks of its signals in the last sample [us].
  [[nodiscard]] double checks_us() const { return checks_us_; }
  // The last sample was missing, or the one before again.
  [[nodiscard]] bool misses() const { return missed_ > 0; }

  // The functions below return the inputs of the checks.
  [[nodiscard]] const NetworkInfo& network() const { return force_.network(); }
  [[nodiscard]] const StuckElectrodes& stuck() const { return stuck_; }
  // Null: the network contains no pattern of its signals.
  [[nodiscard]] const SignalModel* signals() const { return model_ ? &*model_ : nullptr; }
  // Returns the signals of a sensor without electrodes.
  [[nodiscard]] const ChannelSignals* channels() const {
    return channel_signals_ ? &*channel_signals_ : nullptr;
  }
  // Returns why the baseline of a sensor without electrodes is flagged, one clause; empty: it is
  // not.
  [[nodiscard]] std::string_view baseline_fault() const { return baseline_fault_; }
  // Above its baseline, averaged over some samples [counts].
  [[nodiscard]] double pressure() const { return pressure_; }
  // The network's window contains a sample with electrodes that do not work.
  [[nodiscard]] bool holds_flaw() const { return flawed_left_ > 0; }

 private:
  void Miss() noexcept;
  // Returns false while the baseline is not known.
  bool UpdateBaseline(const FingerReading& reading, bool is_clear) noexcept;
  [[nodiscard]] TouchPlace PlaceOf(const TactileSignals& change,
                                   const FingerReading& reading) const noexcept;
  void EstimateForce(const TactileSignals& change, bool is_full) noexcept;
  [[nodiscard]] bool PressureRises() const noexcept;
  TactileSignals Correct(const TactileSignals& change, FingerReading* reading) noexcept;
  void Lose(FailedCheck check, std::string_view why) noexcept;
  void ForgetWindow() noexcept;
  void Keep(const FingerReading& reading) noexcept;
  bool PushKept() noexcept;
  void ExamineBaseline() noexcept;
  void LearnKeptNoise() noexcept;
  void DecideTouch(const TouchPlace& place) noexcept;
  void NoteFlaws(const TouchPlace& place) noexcept;
  [[nodiscard]] Verdict VerdictOfForce() const noexcept;
  void Widen(double by) noexcept;

  const Localiser* localiser_;
  WindowForce force_;
  Baseline baseline_;
  StuckElectrodes stuck_;
  std::optional<SignalModel> model_;  // only for networks with a pattern of their signals
  std::optional<ChannelSignals> channel_signals_;  // for such networks without electrodes
  std::string_view baseline_fault_;
  std::size_t channels_;
  int max_missed_;                   // samples
  int release_samples_;              // samples
  std::vector<FingerReading> kept_;  // ring of readings whose baseline is not known yet
  std::size_t kept_count_ = 0, kept_next_ = 0;
  int missed_ = 0, quiet_ = 0;
  double pressure_ = 0;
  // Samples until the window contains no faulty one; the window size: this one is.
  int flawed_left_ = 0;
  double checks_us_ = 0;
  FingerTouch touch_;
};

}  // namespace palpate
