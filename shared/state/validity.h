// How far a state may be trusted. Ordered from best to worst, so that the worse of two is the
// larger.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace palpate {

enum class Validity : std::uint8_t {
  kValid,         // inside the model's range
  kExtrapolated,  // numbers are given, but strain or deflection lie beyond the model's range
  kPunctured,     // the tool broke through: zero by the puncture cue (paper A, 4.2)
  kStale,         // nothing sensed for too long: the last numbers
  kTrackingLost,  // the eyes lost the tool or the object: the force is unknown
  kFailed,        // no answer: the force is unknown
};

// The force behind this validity is a number, not a question mark.
constexpr bool IsForceKnown(Validity v) {
  return v < Validity::kStale;
}

constexpr Validity Worse(Validity a, Validity b) {
  return std::max(a, b);
}

// As written in CSV files: `valid`, `extrapolated`, `punctured`, `stale`, `tracking_lost`,
// `failed`.
constexpr std::string_view ToString(Validity v) {
  constexpr std::array<std::string_view, 6> kWritten{"valid", "extrapolated",  "punctured",
                                                     "stale", "tracking_lost", "failed"};
  return kWritten[static_cast<std::size_t>(v)];
}

}  // namespace palpate
