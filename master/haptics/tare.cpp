#include "master/haptics/tare.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

namespace palpate {
namespace {

bool Touches(const SlaveState& state) {
  const auto fingers = std::span(state.fingers).first(static_cast<std::size_t>(state.finger_count));
  return state.local_model.in_contact ||
         std::ranges::any_of(fingers, [](const FingerState& finger) { return finger.in_contact; });
}

}  // namespace

std::string_view InWords(TareState state) {
  constexpr std::array<std::string_view, 7> kWords{
      "",
      "",
      "tared: the present force counts as zero",
      "not tared: disengage first (clutch)",
      "not tared: the tool is in contact: retract it",
      "not tared: the force is not valid",
      "not tared: the force without contact exceeds a tenth of the force limit: check the sensor"};
  return kWords[static_cast<std::size_t>(state)];
}

void Tare::Request(std::uint32_t count) noexcept {
  if (std::exchange(asked_, count) == count) return;
  state_ = TareState::kMeasuring;
  count_ = 0;
  sum_.setZero();
}

void Tare::Take(SlaveState* state, bool follows, double largest, double now) noexcept {
  if (state_ == TareState::kMeasuring) Measure(*state, follows, largest, now);
  if (state->force) *state->force -= bias_;
  if (state->local_model.in_contact) state->local_model.force -= bias_;
}

void Tare::Measure(const SlaveState& state, bool follows, double largest, double now) noexcept {
  if (follows) state_ = TareState::kFollowing;
  if (!state.force || state.validity != Validity::kValid) state_ = TareState::kNotValid;
  if (Touches(state)) state_ = TareState::kTouching;
  if (state_ != TareState::kMeasuring || state.sensed_at == sensed_at_) return;
  sensed_at_ = state.sensed_at;
  if (count_++ == 0) since_ = now;
  sum_ += *state.force;
  if (now - since_ < kMeasure || count_ < kMinSamples) return;
  const Eigen::Vector3d mean = sum_ / count_;
  state_ = mean.norm() <= kMaxShare * largest ? TareState::kDone : TareState::kTooLarge;
  if (state_ == TareState::kDone) bias_ = mean;
}

}  // namespace palpate
