// How far another machine's clock is from ours, from round trips.
//
//   theta = ((t2 - t1) + (t3 - t4)) / 2     delta = (t4 - t1) - (t3 - t2)     |error| <= delta / 2
//
// t1 our clock when the request left, t2 theirs when it came, t3 theirs when the answer left, t4
// ours when it came. Source: NTP, RFC 5905, section 8. The sample with the smallest delta of the
// last 32 is believed, each aged by what two clocks may drift apart.
#pragma once

#include <array>
#include <cstddef>

#include "shared/state/clock.h"

namespace palpate {

// One thread. Allocation-free.
class ClockOffset {
 public:
  static constexpr std::size_t kWindow = 32;
  static constexpr double kDrift = 50e-6;  // of one clock against the other [s/s]
  static constexpr double kSlew = 5e-3;    // how fast the offset may change [s/s]

  // Adds a round trip. One whose delta is negative is no round trip of these clocks and is left
  // out.
  void Add(Time t1, Time t2, Time t3, Time t4) noexcept;
  // Their clock minus ours [s]. Jumps while the window first fills; slews from then on. 0 before
  // the first sample.
  [[nodiscard]] double seconds() const noexcept { return offset_; }
  // How far `seconds` may be from the truth at the last sample [s], by the sample believed.
  [[nodiscard]] double error() const noexcept { return error_; }
  [[nodiscard]] bool known() const noexcept { return count_ > 0; }

 private:
  struct Sample {
    double theta = 0, delta = 0;  // [s]
    Time at{};
  };

  std::array<Sample, kWindow> samples_{};
  std::size_t count_ = 0;  // since the start
  double offset_ = 0, error_ = 0;
  Time updated_at_{};
};

}  // namespace palpate
