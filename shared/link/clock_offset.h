// Offset of another machine's clock, from round trips.
//
//   theta = ((t2 - t1) + (t3 - t4)) / 2     delta = (t4 - t1) - (t3 - t2)     |error| <= delta / 2
//
// t1: own clock when the request was sent; t2: peer's clock when it arrived; t3: peer's clock when
// the answer was sent; t4: own clock when it arrived. Source: NTP, RFC 5905, section 8. The
// estimate uses the smallest delta of the last 32 samples, each enlarged by the possible drift
// since then.
#pragma once

#include <array>
#include <cstddef>

#include "shared/state/clock.h"

namespace palpate {

// Not thread-safe. Does not allocate.
class ClockOffset {
 public:
  static constexpr std::size_t kWindow = 32;
  static constexpr double kDrift = 50e-6;  // largest relative drift of two clocks [s/s]
  static constexpr double kSlew = 5e-3;    // largest rate of change of the offset [s/s]

  // Adds a round trip. A negative delta is impossible, so such a sample is ignored.
  void Add(Time t1, Time t2, Time t3, Time t4) noexcept;
  // Peer's clock minus own clock [s]. Changes freely until the window is full, then at most by
  // kSlew. 0 before the first sample.
  [[nodiscard]] double seconds() const noexcept { return offset_; }
  // Largest error of `seconds` at the last sample [s].
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
