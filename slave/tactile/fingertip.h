// One fingertip: from counts to its force, contact point and contact state (paper B, III.A).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "shared/state/verdict.h"
#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"
#include "slave/tactile/localise/localiser.h"
#include "slave/tactile/network/force_network.h"
#include "slave/tactile/pattern_check.h"
#include "slave/tactile/rest_trend.h"
#include "slave/tactile/steady_force.h"

namespace palpate {

// Constant electrodes: a real one has noise of about a count. A working electrode does not read the
// same value for this time [s]. The longest stretch in recordings at 100 Hz, fingers at rest and in
// contact, is 0.43 s of 52 s times 19 electrodes; 0.26 s and 0.12 s in others, 0.16 s in fifteen
// seconds of five fingers. A stretch of twice the length is a thousand times as rare.
inline constexpr double kStandsStill = 1;

class StuckElectrodes {
 public:
  explicit StuckElectrodes(int patience) : patience_(patience) {}  // samples

  void Take(const FingerReading& reading) noexcept {
    int moved = 0;  // electrodes
    for (std::size_t i = 0; i < kElectrodeCount; ++i) {
      const bool stands = same_[i] > 0 && reading.electrodes[i] == last_[i];
      moved += stands ? 0 : 1;
      same_[i] = stands ? std::min(same_[i] + 1, patience_) : 1;
    }
    repeated_ = moved == 0 ? std::min(repeated_ + 1, kRepeats) : 0;
    changes_ += moved > 0 ? 1 : 0;
    moved_ += moved;
    last_ = reading.electrodes;
  }
  void Reset() noexcept { *this = StuckElectrodes(patience_); }
  // The sample repeats the last one, from a fingertip whose noise hardly ever leaves all electrodes
  // constant: in five fingers at 100 Hz 11 to 13 electrodes change from sample to sample.
  [[nodiscard]] bool are_repeated() const noexcept {
    return repeated_ > 0 && changes_ >= kKnown && moved_ > kMoved * changes_;
  }
  // The same for five samples.
  [[nodiscard]] bool are_frozen() const noexcept { return repeated_ >= kRepeats && are_repeated(); }
  // Electrodes that have read the same for 300 ms: the values expected from the others are better,
  // whether these electrodes work or not.
  [[nodiscard]] std::array<bool, kElectrodeCount> which() const noexcept {
    return SameFor(patience_ * 3 / 10);
  }
  // Electrodes that have read the same for 50 ms, which happens; if their deviation is also large,
  // they are wrong.
  [[nodiscard]] std::array<bool, kElectrodeCount> still() const noexcept {
    return SameFor(patience_ / kStill);
  }
  // How many have read the same for as long as the patience lasts.
  [[nodiscard]] int count() const noexcept {
    return static_cast<int>(std::ranges::count(same_, patience_));
  }

 private:
  [[nodiscard]] std::array<bool, kElectrodeCount> SameFor(int samples) const noexcept {
    std::array<bool, kElectrodeCount> same_for{};
    std::ranges::transform(same_, same_for.begin(),
                           [&](int same) { return same >= std::max(2, samples); });
    return same_for;
  }

  static constexpr int kRepeats = 4;  // of a sample
  static constexpr int kKnown = 20;   // number of changes before the noise is estimated
  static constexpr int kMoved = 6;    // electrodes per change, in the mean
  static constexpr int kStill = 20;   // parts of the patience

  int patience_;
  int repeated_ = 0;                         // samples in a row that were as the one before
  std::int64_t changes_ = 0, moved_ = 0;     // samples, electrodes, so far
  std::array<int, kElectrodeCount> same_{};  // samples, the newest included
  std::array<float, kElectrodeCount> last_{};
};

// Result of one sample of a fingertip. Frame F. `Verdict`: of the force.
struct FingerTouch : Verdict {
  FingerTouch() : Verdict{Validity::kTrackingLost} {}

  std::optional<Eigen::Vector3d> force_F;  // of the fingertip on the object [N]; nullopt: unknown
  double sigma = 0;                        // rms that its vector may be off by [N]
  TouchPlace place;                        // of this sample; while touching the last usable one
  bool touching = false;
  // Its pressure has changed, which is known before the force; nullopt: the size of such a change
  // is unknown for this fingertip.
  std::optional<bool> stirs;
  std::optional<double> drift;  // of all electrodes together since the baseline [counts]
  bool takes_rest = false;      // it was a sample of the baseline
};

// Samples that are missing for less than 60 ms are made up for when the next one comes, linear
// between both, so that the network's window stays full. So are those that are the last one again,
// where electrodes have noise.
//
// Validity: kTrackingLost while the baseline is measured, until the network's window is full, after
// samples that are missing for 60 ms or are no numbers; kStale, with the last numbers, from the
// third missing one on; before that they stay, with a sigma that grows as fast as the force moved;
// kExtrapolated for forces beyond the largest one learnt, saturated or dead electrodes, touched or
// not, electrodes that stand still, as long as the network's window holds such a sample, a force
// without an active electrode; kFailed without a network. A gap starts the window again, the
// baseline stays.
//
// It touches from the sample on that has an active electrode and a force above half the network's
// error, until for 50 ms no electrode is active or the force is below a quarter of it: soft foam
// lets contacts drop out for a few samples (paper B, V), which must not shake what follows. Without
// a force the electrodes decide alone.
class Fingertip {
 public:
  // `network` null: forces are unknown. The arguments must outlive the fingertip.
  Fingertip(const Tactile& tactile, const ForceNetwork* network, const Localiser& localiser);
  ~Fingertip();
  Fingertip(Fingertip&&) noexcept;

  // Processes the next sample; `after_gap`: samples are missing just before it; `is_clear`: nothing
  // is near enough to touch, so the baseline may be updated. Allocation-free; the sample that
  // completes the baseline runs the network over all stored samples.
  const FingerTouch& Estimate(const FingerReading& reading, bool after_gap,
                              bool is_clear = false) noexcept;
  // Measures the baseline again.
  void Reset() noexcept;

  [[nodiscard]] const FingerTouch& touch() const { return touch_; }
  // Time of the cross-checks of its signals in the last sample [us].
  [[nodiscard]] double checks_us() const { return checks_us_; }
  // The last sample was missing, or the one before again.
  [[nodiscard]] bool misses() const { return missed_ > 0; }

 private:
  void Miss() noexcept;
  void FollowRest(const FingerReading& reading) noexcept;
  void FollowSteps(const FingerReading& reading, bool looks_back) noexcept;
  [[nodiscard]] std::optional<bool> PressureFluctuates() const noexcept;
  TactileSignals Mend(const TactileSignals& change, FingerReading* reading) noexcept;
  void Bridge(const TactileSignals& change, int missed) noexcept;
  void Lose(FailedCheck check, std::string_view why) noexcept;
  void ForgetWindow() noexcept;
  bool Push(const TactileSignals& change) noexcept;
  bool PushKept() noexcept;
  void LearnKeptNoise() noexcept;
  void TakeForce(bool known) noexcept;
  void DecideTouch(const TouchPlace& place) noexcept;
  void NoteFlaws(const TouchPlace& place) noexcept;
  void CheckEstimate() noexcept;
  void FlagPattern() noexcept;
  [[nodiscard]] double SigmaOf(const Eigen::Vector3d& force_F) const noexcept;
  void Widen(double by) noexcept;

  const Localiser* localiser_;
  NetworkInfo network_;
  std::unique_ptr<ForceEstimate> estimate_;  // null: no network
  std::vector<double> outputs_;
  RestTrend rest_;
  StuckElectrodes stuck_;
  std::optional<PatternCheck> pattern_;          // for networks that know their pattern
  SteadyForce steady_;                           // for networks that know their pattern
  TactileSignals rest_average_{};                // of changes while clear [counts]
  int miss_patience_;                            // samples
  int release_patience_;                         // samples
  double rate_;                                  // of the samples [Hz]
  std::array<float, kElectrodeCount> before_{};  // electrodes of the last sample
  std::vector<FingerReading> kept_;              // ring of readings whose baseline is not known yet
  std::size_t kept_count_ = 0, kept_next_ = 0;
  int missed_ = 0, quiet_ = 0;
  TactileSignals last_{};            // signals that the network processed last
  double pressure_ = 0;              // above its rest, averaged over some samples [counts]
  double steps_ = 0;                 // of all electrodes together, lately
  Eigen::Vector3d pace_F_{0, 0, 0};  // of the force, averaged over some samples [N/sample]
  double step_ = 0;                  // of the force, in the last sample [N]
  double leap_ = 0;                  // of the last sample, beyond the pace [N]
  int flawed_left_ =
      0;  // samples until the window contains no faulty one; the window size: this one is
  double checks_us_ = 0;
  FingerTouch touch_;
};

}  // namespace palpate
