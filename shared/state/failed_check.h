// The failed check of a state: one code, the one with the highest rank, besides its validity. Each
// check compares a measurement with independent knowledge. slave/CHECKS.md describes the codes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace palpate {

enum class FailedCheck : std::uint8_t {
  kNone,           // no check failed
  kModelRange,     // strain, deflection or force outside the range of model or neural network
  kTip,            // the tip does not match its template, or the match is ambiguous
  kTipCovered,     // a part of the tip is covered
  kArm,            // the measured tip disagrees with the manipulator pose
  kImage,          // blur, noise or brightness differ from the start
  kRegistration,   // the object differs from its rest surface
  kCameraMotion,   // camera or rig moved too far to be compensated
  kScale,          // the object's size in the image differs from the scene's
  kIndentation,    // measured and computed indentation differ
  kEpipolar,       // stereo points are off their epipolar lines
  kInstants,       // cameras, or camera and manipulator, report different times
  kFrozen,         // the same image or sample repeats
  kMisfit,         // no load on this model explains the measured surface
  kRestShape,      // the measured rest surface differs from the scene's
  kElectrode,      // an electrode disagrees with the others
  kRestDrift,      // the baseline has drifted
  kFingerMissing,  // a fingertip sends no data
  kPose,           // contact of a fingertip contradicts its position
  kTransfer,       // the fingertip differs from the training data of its network
  kArmFault,       // the manipulator's driver is silent or reports a fault
};
inline constexpr int kFailedChecks = 21;

// A state reports the failed check with the highest rank, because it causes lower ones. The order
// of the ranks, highest first: no data of this instant, a wrong frame of reference, unusable
// signals, contradictions between them, the range of the model.
constexpr int Rank(FailedCheck check) {
  constexpr std::array kRising{
      FailedCheck::kNone,         FailedCheck::kModelRange,    FailedCheck::kMisfit,
      FailedCheck::kIndentation,  FailedCheck::kTransfer,      FailedCheck::kPose,
      FailedCheck::kArm,          FailedCheck::kTipCovered,    FailedCheck::kTip,
      FailedCheck::kImage,        FailedCheck::kElectrode,     FailedCheck::kRestDrift,
      FailedCheck::kRestShape,    FailedCheck::kScale,         FailedCheck::kRegistration,
      FailedCheck::kCameraMotion, FailedCheck::kEpipolar,      FailedCheck::kInstants,
      FailedCheck::kFrozen,       FailedCheck::kFingerMissing, FailedCheck::kArmFault};
  static_assert(kRising.size() == kFailedChecks);
  int rank = 0;
  while (kRising[static_cast<std::size_t>(rank)] != check) ++rank;
  return rank;
}

}  // namespace palpate
