// Limits of the checks and compensations of one camera, as `check` prints them.
#pragma once

namespace palpate {

struct CameraLimits {
  static constexpr double kMostScale = 0.02;  // error of the object's size in the first image
  static constexpr double kMostResidual = 2;  // of its outline there, rms [px]
  static constexpr double kToolElsewhere =
      1;  // distance of the tool's end from the encoder reading [px]
  static constexpr double kToolWidth = 0.12;  // by which it may be another one than the scene's
  static constexpr double kArmParts =
      0.3;  // distance of the tip from the encoder reading, after the start [px]
  static constexpr double kSharpAtRest = 0.30;  // edge width in the first image; 1: sharp
  static constexpr double kSharpness = 0.47;    // edge width relative to the first image
  static constexpr double kOverexposed = 1.15;  // of the largest grey level
  static constexpr int kMostComb = 1;  // by which every other row may lie aside at the tip [px]
  static constexpr double kSmallDent = 1.5;  // that needs no confirmation [px]
  // Limits of compensated motion of the camera or object: [px], [rad], [-].
  static constexpr double kMostShift = 40, kMostTurn = 0.06, kMostGrowth = 0.03;
};

}  // namespace palpate
