#include "master/haptics/sane_state.h"

#include <algorithm>
#include <span>

#include "master/haptics/renderer.h"

namespace palpate {

bool IsWithin(const Eigen::Vector3d& v, double limit) {
  return v.allFinite() && v.cwiseAbs().maxCoeff() <= limit;
}

namespace {

constexpr double kLargestForce = 1e9;  // larger forces are invalid [N]

bool IsSane(const FingerState& finger) {
  return IsWithin(finger.p_S_contact.cast<double>(), kFarthest) &&
         (!finger.force || IsWithin(finger.force->cast<double>(), kLargestForce));
}

}  // namespace

bool IsSane(const SlaveState& state) {
  if (state.finger_count < 0 || state.finger_count > kMaxFingers) return false;
  const auto fingers = std::span(state.fingers).first(static_cast<std::size_t>(state.finger_count));
  return std::ranges::all_of(fingers, [](const FingerState& finger) { return IsSane(finger); }) &&
         IsWithin(state.p_S_tip, kFarthest) && IsWithin(state.offset, kFarthest) &&
         (!state.force || IsWithin(*state.force, kLargestForce)) &&
         (!state.true_force || IsWithin(*state.true_force, kLargestForce)) &&
         (!state.local_model.known() || IsSane(state.local_model));
}

}  // namespace palpate
