// Tare subtracts the force without contact, for example the drift of a fingertip.
//
//   f' = f - b,   b: mean of f over kMeasure
//
// A tare must not hide a contact. It is measured only while the operator is disengaged, nothing is
// touched and the force is valid. It is rejected above a tenth of the force limit. A change of
// settings removes it.
#pragma once

#include <cstdint>
#include <string_view>

#include <Eigen/Core>

#include "shared/state/slave_state.h"

namespace palpate {

enum class TareState : std::uint8_t {
  kNone,       // not requested, or removed by a change of settings
  kMeasuring,  // requested
  kDone,
  // Rejected; the previous tare stays:
  kFollowing,  // the operator is engaged
  kTouching,   // the tool is in contact
  kNotValid,   // the force is not valid
  kTooLarge,   // more than kMaxShare
};
// Text for the operator: `tared: ...`, or `not tared: ...` with the next step; may be empty.
std::string_view InWords(TareState state);

// Used by the haptic loop. Real-time safe.
class Tare {
 public:
  static constexpr double kMeasure = 0.2;   // [s]
  static constexpr double kMaxShare = 0.1;  // of the largest force [-]
  static constexpr int kMinSamples = 3;     // samples

  // `count`: requests so far. A new one starts a measurement.
  void Request(std::uint32_t count) noexcept;
  // Measures, if requested, and then subtracts the tare from the forces of `state`. `follows`: the
  // operator is engaged; `largest`: force limit at the tool [N]; `now` [s].
  void Take(SlaveState* state, bool follows, double largest, double now) noexcept;
  void Forget() noexcept {
    const std::uint32_t asked = asked_;
    *this = Tare();
    asked_ = asked;
  }

  [[nodiscard]] TareState state() const noexcept { return state_; }
  [[nodiscard]] const Eigen::Vector3d& bias() const noexcept { return bias_; }  // b [N]

 private:
  void Measure(const SlaveState& state, bool follows, double largest, double now) noexcept;

  std::uint32_t asked_ = 0;
  TareState state_ = TareState::kNone;
  Eigen::Vector3d bias_{0, 0, 0};
  Eigen::Vector3d sum_{0, 0, 0};
  int count_ = 0;
  double since_ = 0;  // time of the first sample [s]
  Time sensed_at_{};  // of the newest sample
};

}  // namespace palpate
