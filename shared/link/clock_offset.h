// Offset of another machine's clock, from round trips.
//
//   theta = ((t2 - t1) + (t3 - t4)) / 2     delta = (t4 - t1) - (t3 - t2)     |error| <= delta / 2
//
// t1: own clock when the request was sent; t2: peer's clock when it arrived; t3: peer's clock when
// the answer was sent; t4: own clock when it arrived. Source: NTP, RFC 5905, section 8. The
// estimate uses the smallest delta of the last 32 samples, each enlarged by the possible drift
// since then.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <utility>

#include "shared/state/clock.h"

namespace palpate {

// Base round trip of a link, without queueing: the shortest of the last 10 to 20 s.
class BaseRoundTrip {
 public:
  static constexpr double kUnknown = std::numeric_limits<double>::infinity();

  // Adds the shortest round trip of the last `period` [s]; kUnknown: there was none.
  void Learn(double shortest, double period) noexcept {
    newest_ = std::min(newest_, shortest);
    own_ = std::min(newest_, before_);
    remembered_ += period;
    if (remembered_ < kRemembered) return;
    remembered_ = 0;
    before_ = std::exchange(newest_, kUnknown);
  }
  // Returns whether packets are queued: `shortest` exceeds the base by `queueing` [s] plus
  // `variation` times the base.
  [[nodiscard]] bool Waits(double shortest, double queueing, double variation) const noexcept {
    return shortest < kUnknown && shortest > own_ + queueing + variation * own_;
  }
  [[nodiscard]] double OrZero() const noexcept { return own_ < kUnknown ? own_ : 0; }  // [s]

 private:
  static constexpr double kRemembered = 10;  // [s]; two periods are kept, because links change
  double own_ = kUnknown, newest_ = kUnknown, before_ = kUnknown, remembered_ = 0;
};

// ClockOffset is not thread-safe and does not allocate.
class ClockOffset {
 public:
  static constexpr std::size_t kWindow = 32;
  static constexpr double kDrift = 50e-6;  // largest relative drift of two clocks [s/s]
  static constexpr double kSlew = 5e-3;    // largest rate of change of the offset [s/s]
  // A clock has moved when kLeapSamples samples in a row differ from the offset by their delta plus
  // kLeap [s]. The drift within the window is much smaller, and the accepted age of a state is
  // larger.
  static constexpr double kLeap = 0.1;
  static constexpr int kLeapSamples = 5;

  // Adds a round trip. A negative delta is impossible, so such a sample is ignored.
  void Add(Time t1, Time t2, Time t3, Time t4) noexcept;
  // Returns the peer's clock minus own clock [s]. Changes freely until the window is full, then at
  // most by kSlew, unless a clock has moved. 0 before the first sample.
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
  std::size_t count_ = 0;  // since the start, or since a clock moved
  int far_ = 0;            // newest samples in a row that are far from the offset
  double offset_ = 0, error_ = 0;
  Time updated_at_{};
};

}  // namespace palpate
