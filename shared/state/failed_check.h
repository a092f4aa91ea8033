// Which of its own checks a state fell short of: one code, the worst, beside its validity. The
// sense compares what it sees with what it knows otherwise; what disagrees is named here.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace palpate {

enum class FailedCheck : std::uint8_t {
  kNone,           // none failed
  kModelRange,     // strain, deflection or force beyond what the model or network is made for
  kTip,            // the tip does not look as it did, or its place is not unique
  kTipCovered,     // a part of the tip is hidden or overlaid
  kArm,            // the tip is not where the manipulator says
  kPicture,        // blur, noise or light are not as at the start
  kRegistration,   // the object is not where its rest surface says
  kCameraMotion,   // a camera or its rig has moved farther than can be put right
  kScale,          // the object's size in the picture is not the scene's
  kDent,           // the dent seen is not the dent computed
  kEpipolar,       // two eyes do not see the same points on their epipolar lines
  kInstants,       // two eyes, or arm and eye, tell of different instants
  kFrozen,         // the same picture or sample comes again
  kMisfit,         // no load on this model gives the surface seen
  kRestShape,      // the surface at rest is not the scene's
  kElectrode,      // an electrode disagrees with the others
  kRestDrift,      // the rest values have drifted
  kFingerMissing,  // a fingertip sends nothing
  kPose,           // a fingertip touches where the object is not, or the reverse
  kTransfer,       // the fingertip does not answer as those its network learnt from
  kArmFault,       // the arm does not move the tool: its driver is silent or tells of a fault
};
inline constexpr int kFailedChecks = 21;

// As written in CSV files; empty: none.
constexpr std::string_view ToString(FailedCheck check) {
  constexpr std::array<std::string_view, kFailedChecks> kWritten{
      "",           "model_range",    "tip",          "tip_covered",
      "arm",        "picture",        "registration", "camera_motion",
      "scale",      "dent",           "epipolar",     "instants",
      "frozen",     "misfit",         "rest_shape",   "electrode",
      "rest_drift", "finger_missing", "pose",         "transfer",
      "arm_fault"};
  return kWritten[static_cast<std::size_t>(check)];
}

}  // namespace palpate
