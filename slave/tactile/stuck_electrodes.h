// Electrodes that stand still: a real one has noise of about a count.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "slave/capture/tactile_frame.h"

namespace palpate {

// For so long an electrode that works does not read the same [s]. The longest stretch in recordings
// at 100 Hz, fingers at rest and touching, is 0.43 s of 52 s times 19 electrodes; 0.26 s and 0.12 s
// in others, 0.16 s in fifteen seconds of five fingers, where a stretch twice as long is a thousand
// times as rare.
inline constexpr double kStandsStill = 1;

class StuckElectrodes {
 public:
  explicit StuckElectrodes(int patience) : patience_(patience) {}  // samples

  void Take(const FingerReading& reading) noexcept {
    for (std::size_t i = 0; i < kElectrodeCount; ++i) {
      const bool stands = same_[i] > 0 && reading.electrodes[i] == last_[i];
      same_[i] = stands ? std::min(same_[i] + 1, patience_) : 1;
    }
    last_ = reading.electrodes;
  }
  void Reset() noexcept { same_.fill(0); }
  // How many have read the same for as long as the patience lasts.
  [[nodiscard]] int count() const noexcept {
    return static_cast<int>(std::ranges::count(same_, patience_));
  }

 private:
  int patience_;
  std::array<int, kElectrodeCount> same_{};  // samples, the newest included
  std::array<float, kElectrodeCount> last_{};
};

}  // namespace palpate
