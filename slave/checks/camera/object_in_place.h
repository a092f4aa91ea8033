// The object's edge is found, and has moved no farther than is compensated.
#pragma once

#include <cmath>

#include "slave/checks/camera/camera_sample.h"
#include "slave/checks/check.h"

namespace palpate {

class ObjectInPlaceCheck final : public Check<CameraSample> {
 public:
  void Examine(const CameraSample& sample, Findings* findings) noexcept override {
    if (!sample.compares_edge()) return;
    const ObjectSighting& seen = *sample.object;
    if (!seen.known) {
      return findings->Fail(FailedCheck::kRegistration, "the object's edge is not found");
    }
    if (seen.motion.shift.norm() > CameraLimits::kMostShift ||
        std::abs(seen.motion.angle) > CameraLimits::kMostTurn) {
      findings->Fail(FailedCheck::kCameraMotion, "the image has moved too far");
    }
    if (std::abs(seen.motion.growth) > CameraLimits::kMostGrowth) {
      findings->Fail(FailedCheck::kScale, "the image has grown or shrunk: zoom");
    }
  }
};

}  // namespace palpate
