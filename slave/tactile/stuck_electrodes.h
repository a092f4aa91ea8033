// Detects electrodes that are constant, and samples that repeat the last one.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "slave/tactile/signals/signal_pattern.h"

namespace palpate {

// Constant electrodes: a real one has noise of about a count. A working electrode does not read the
// same value for this time [s]. The longest stretch in recordings at 100 Hz, fingers at rest and in
// contact, is 0.43 s of 52 s times 19 electrodes; 0.26 s and 0.12 s in others, 0.16 s in fifteen
// seconds of five fingers. A stretch of twice the length is a thousand times as rare.
inline constexpr double kConstant = 1;

// Counts of single electrodes tell more than the RepeatDetector of images could.
class StuckElectrodes {
 public:
  explicit StuckElectrodes(int patience) : patience_(patience) {}  // samples

  void Take(const FingerReading& reading) noexcept {
    int moved = 0;  // electrodes
    for (std::size_t i = 0; i < kElectrodeCount; ++i) {
      const bool is_same = same_[i] > 0 && reading.electrodes[i] == last_[i];
      moved += is_same ? 0 : 1;
      same_[i] = is_same ? std::min(same_[i] + 1, patience_) : 1;
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
  [[nodiscard]] Electrodes which() const noexcept { return SameFor(patience_ * 3 / 10); }
  // Electrodes that have read the same for 50 ms, which happens; if their deviation is also large,
  // they are wrong.
  [[nodiscard]] Electrodes still() const noexcept { return SameFor(patience_ / kStill); }
  // How many have read the same for as long as the patience lasts.
  [[nodiscard]] int count() const noexcept {
    return static_cast<int>(std::ranges::count(same_, patience_));
  }

 private:
  [[nodiscard]] Electrodes SameFor(int samples) const noexcept {
    Electrodes same_for{};
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

}  // namespace palpate
