// Detects electrodes that are constant, and samples that repeat the last one.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "slave/tactile/signals/signal_pattern.h"

namespace palpate {

// Counts of single electrodes show more than the RepeatDetector of images could.
class StuckElectrodes {
 public:
  // `max_constant`: number of samples; 0: channels may be constant. `are_electrodes` false: the
  // usual number of repetitions per channel is learnt at rest.
  StuckElectrodes(int max_constant, int channels, bool are_electrodes = true)
      : max_constant_(max_constant),
        channels_(static_cast<std::size_t>(channels)),
        are_electrodes_(are_electrodes) {}

  // `is_rest`: the sample belongs to the baseline.
  void Take(const FingerReading& reading, bool is_rest = false) noexcept {
    int moved = 0;  // electrodes
    for (std::size_t i = 0; i < channels_; ++i) {
      const bool is_same = same_[i] > 0 && reading.channels[i] == last_[i];
      moved += is_same ? 0 : 1;
      same_[i] = is_same ? std::min(same_[i] + 1, std::max(max_constant_, 2)) : 1;
      rest_repeats_[i] += is_rest && is_same ? 1 : 0;
    }
    if (is_rest) LearnRest();
    repeated_ = moved == 0 ? std::min(repeated_ + 1, kMaxRepeats) : 0;
    changes_ += moved > 0 ? 1 : 0;
    moved_ += moved;
    last_ = reading.channels;
  }
  // Restarts. A sensor that had noise before is expected to have it again.
  void Reset() noexcept {
    const double known = std::min(known_share_, share_);
    *this = StuckElectrodes(max_constant_, static_cast<int>(channels_), are_electrodes_);
    known_share_ = known;
  }
  // Returns whether the sample repeats the last one. With noise all electrodes are hardly ever
  // constant: in five fingers at 100 Hz 11 to 13 electrodes change from sample to sample.
  [[nodiscard]] bool are_repeated() const noexcept {
    if (!are_electrodes_) return repeated_ > 0 && share() < kHardlyEver;
    const auto channels = static_cast<std::int64_t>(channels_);
    return repeated_ > 0 && changes_ >= kKnown &&
           moved_ * kElectrodeCount > kMoved * channels * changes_;
  }
  // Returns whether all electrodes are constant for five samples. For a sensor without electrodes
  // the number of samples is so large that noise cannot cause it. If the noise at rest is below the
  // resolution, it cannot decide, because all channels may then be constant between two steps.
  [[nodiscard]] bool are_frozen() const noexcept {
    if (are_electrodes_) return repeated_ >= kRepeats && are_repeated();
    return share() < kCoarse && repeated_ >= kRepeats &&
           repeated_ * std::log(share()) < std::log(kNever);
  }
  // Electrodes that have read the same for 300 ms: the values expected from the others are better,
  // whether these electrodes work or not.
  [[nodiscard]] Electrodes which() const noexcept { return SameFor(max_constant_ * 3 / 10); }
  // Returns the electrodes that were constant for 50 ms. This may happen by chance; if their
  // deviation is also large, they are faulty.
  [[nodiscard]] Electrodes still() const noexcept { return SameFor(max_constant_ / kStill); }
  // Returns whether all electrodes have read the same for `max_constant` samples.
  [[nodiscard]] bool are_all() const noexcept { return count() == static_cast<int>(channels_); }
  // Returns the number of electrodes that have read the same for `max_constant` samples.
  [[nodiscard]] int count() const noexcept {
    if (max_constant_ == 0) return 0;
    return static_cast<int>(std::count(same_.begin(), same_.begin() + channels_, max_constant_));
  }

 private:
  // Returns the share of the samples at rest in which the channel that changes most often repeats
  // itself.
  [[nodiscard]] double share() const noexcept { return std::min(known_share_, share_); }
  void LearnRest() noexcept {
    ++rest_;
    const int least = *std::min_element(rest_repeats_.begin(), rest_repeats_.begin() + channels_);
    share_ = (least + 1.0) / (rest_ + 1.0);  // an upper bound, because the samples are few
  }
  [[nodiscard]] Electrodes SameFor(int samples) const noexcept {
    Electrodes same_for{};
    std::transform(same_.begin(), same_.begin() + kElectrodeCount, same_for.begin(),
                   [&](int same) { return same >= std::max(2, samples); });
    return same_for;
  }

  static constexpr int kRepeats = 4;  // repetitions that make a sample frozen
  static constexpr int kMaxRepeats = 1000;
  // Fraction of repeated samples below which a repetition counts as a missing sample.
  static constexpr double kHardlyEver = 0.05;
  static constexpr double kCoarse = 0.2;  // from here on the noise is below the resolution
  static constexpr double kNever = 1e-9;  // probability of a frozen sample by noise
  static constexpr int kKnown = 20;       // number of changes before the noise is estimated
  static constexpr int kMoved = 6;        // of 19 channels per change, in the mean
  static constexpr int kStill = 20;       // part of `max_constant`

  int max_constant_;
  std::size_t channels_;
  bool are_electrodes_;
  int rest_ = 0;                                  // samples of the baseline
  std::array<int, kMaxChannels> rest_repeats_{};  // repetitions in them
  double share_ = 1, known_share_ = 1;            // of this baseline, of earlier ones
  int repeated_ = 0;                              // consecutive samples that equal the one before
  std::int64_t changes_ = 0, moved_ = 0;          // numbers of changed samples and electrodes
  std::array<int, kMaxChannels> same_{};          // number of equal samples, with the newest
  ChannelValues last_;
};

}  // namespace palpate
