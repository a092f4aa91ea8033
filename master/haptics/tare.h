// What is felt without contact, taken for zero: a fingertip's drift, for one, need not stay in the
// hand.
//
//   f' = f - b,   b: mean of f over kMeasure
//
// A tare must not hide a contact: it is measured only while nobody follows, nothing is touched and
// the force is valid, and refused where it is more than a tenth of the limit. Other settings end
// it.
#pragma once

#include <cstdint>
#include <string_view>

#include <Eigen/Core>

#include "shared/state/slave_state.h"

namespace palpate {

enum class TareState : std::uint8_t {
  kNone,       // nobody asked, or other settings ended it
  kMeasuring,  // asked for
  kDone,
  // Refused, the one before stays:
  kFollowing,  // somebody follows
  kTouching,   // the slave feels a contact
  kNotValid,   // the force is not valid
  kTooLarge,   // more than kLargestShare
};
// For the operator: `tared: ...`, `not tared: ...` with what to do; empty: nothing to say.
std::string_view InWords(TareState state);

// Belongs to the haptic loop; real-time safe.
class Tare {
 public:
  static constexpr double kMeasure = 0.2;       // [s]
  static constexpr double kLargestShare = 0.1;  // of the largest force [-]
  static constexpr int kFewest = 3;             // samples

  void Request() noexcept;
  // Takes the state's forces for as much less; looks at it, while asked, before. `follows`:
  // somebody does; `largest`: the force limit at the tool [N]; `now` [s].
  void Take(SlaveState* state, bool follows, double largest, double now) noexcept;
  void Forget() noexcept { *this = Tare(); }

  [[nodiscard]] TareState state() const noexcept { return state_; }
  [[nodiscard]] const Eigen::Vector3d& bias() const noexcept { return bias_; }  // b [N]

 private:
  void Measure(const SlaveState& state, bool follows, double largest, double now) noexcept;

  TareState state_ = TareState::kNone;
  Eigen::Vector3d bias_{0, 0, 0};
  Eigen::Vector3d sum_{0, 0, 0};
  int count_ = 0;
  double since_ = 0;  // of the first sample [s]
  Time sensed_at_{};  // of the newest
};

}  // namespace palpate
