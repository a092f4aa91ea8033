// Validity of a state, ordered from best to worst, so that the worse of two is the larger.
#pragma once

#include <algorithm>
#include <cstdint>

namespace palpate {

enum class Validity : std::uint8_t {
  kValid,         // no check failed
  kExtrapolated,  // a number is given, but outside of the model's range or a check failed
  kPunctured,     // the tool broke through: the force is zero (paper A, 4.2)
  kStale,         // no sample for too long: the last numbers
  kTrackingLost,  // tool or object cannot be tracked: the force is unknown
  kFailed,        // no solution: the force is unknown
};

// Returns whether the force is known with this validity.
constexpr bool IsForceKnown(Validity v) {
  return v < Validity::kStale;
}

constexpr Validity Worse(Validity a, Validity b) {
  return std::max(a, b);
}

}  // namespace palpate
