// Detects electrodes that are constant, and samples that repeat the last one.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "slave/tactile/signals/signal_pattern.h"

namespace palpate {

// Counts of single electrodes tell more than the RepeatDetector of images could.
class StuckElectrodes {
 public:
  // `patience`: samples; 0: channels may stay the same.
  StuckElectrodes(int patience, int channels)
      : patience_(patience), channels_(static_cast<std::size_t>(channels)) {}

  void Take(const FingerReading& reading) noexcept {
    int moved = 0;  // electrodes
    for (std::size_t i = 0; i < channels_; ++i) {
      const bool is_same = same_[i] > 0 && reading.channels[i] == last_[i];
      moved += is_same ? 0 : 1;
      same_[i] = is_same ? std::min(same_[i] + 1, patience_) : 1;
    }
    repeated_ = moved == 0 ? std::min(repeated_ + 1, kRepeats) : 0;
    changes_ += moved > 0 ? 1 : 0;
    moved_ += moved;
    last_ = reading.channels;
  }
  void Reset() noexcept { *this = StuckElectrodes(patience_, static_cast<int>(channels_)); }
  // The sample repeats the last one, from a fingertip whose noise hardly ever leaves all electrodes
  // constant: in five fingers at 100 Hz 11 to 13 electrodes change from sample to sample.
  [[nodiscard]] bool are_repeated() const noexcept {
    const auto channels = static_cast<std::int64_t>(channels_);
    return repeated_ > 0 && changes_ >= kKnown &&
           moved_ * kElectrodeCount > kMoved * channels * changes_;
  }
  // The same for five samples.
  [[nodiscard]] bool are_frozen() const noexcept { return repeated_ >= kRepeats && are_repeated(); }
  // Electrodes that have read the same for 300 ms: the values expected from the others are better,
  // whether these electrodes work or not.
  [[nodiscard]] Electrodes which() const noexcept { return SameFor(patience_ * 3 / 10); }
  // Electrodes that have read the same for 50 ms, which happens; if their deviation is also large,
  // they are wrong.
  [[nodiscard]] Electrodes still() const noexcept { return SameFor(patience_ / kStill); }
  // All have.
  [[nodiscard]] bool are_all() const noexcept { return count() == static_cast<int>(channels_); }
  // How many have read the same for as long as the patience lasts.
  [[nodiscard]] int count() const noexcept {
    if (patience_ == 0) return 0;
    return static_cast<int>(std::count(same_.begin(), same_.begin() + channels_, patience_));
  }

 private:
  [[nodiscard]] Electrodes SameFor(int samples) const noexcept {
    Electrodes same_for{};
    std::transform(same_.begin(), same_.begin() + kElectrodeCount, same_for.begin(),
                   [&](int same) { return same >= std::max(2, samples); });
    return same_for;
  }

  static constexpr int kRepeats = 4;  // of a sample
  static constexpr int kKnown = 20;   // number of changes before the noise is estimated
  static constexpr int kMoved = 6;    // of 19 channels per change, in the mean
  static constexpr int kStill = 20;   // parts of the patience

  int patience_;
  std::size_t channels_;
  int repeated_ = 0;                      // samples in a row that were as the one before
  std::int64_t changes_ = 0, moved_ = 0;  // samples, electrodes, so far
  std::array<int, kMaxChannels> same_{};  // samples, the newest included
  ChannelValues last_;
};

}  // namespace palpate
