// What the checks of one camera see, and put right, as `check` tells it.
#pragma once

namespace palpate {

struct CameraLimits {
  static constexpr double kMostScale = 0.02;   // of the object's size in the first picture
  static constexpr double kMostResidual = 2;   // of its outline there, rms [px]
  static constexpr double kToolElsewhere = 1;  // its end from where the manipulator says [px]
  static constexpr double kToolWidth = 0.12;   // by which it may be another one than the scene's
  static constexpr double kArmParts = 0.3;     // tip from where the manipulator says, later on [px]
  static constexpr double kSharpAtRest = 0.30;  // edges of the first picture; 1: sharp
  static constexpr double kSharpness = 0.47;    // the same in parts of the first picture's
  static constexpr double kOverexposed = 1.15;  // of the largest grey level
  static constexpr int kMostComb = 1;  // by which every other row may lie aside at the tip [px]
  static constexpr double kSmallDent = 1.5;  // that needs no confirmation [px]
  // What is put right of the camera's or the object's motion: [px], [rad], [-].
  static constexpr double kMostShift = 40, kMostTurn = 0.06, kMostGrowth = 0.03;
};

}  // namespace palpate
