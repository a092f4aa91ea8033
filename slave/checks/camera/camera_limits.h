// Limits of one camera's checks, as `check` prints them. Rows are those of the robustness suite.
#pragma once

namespace palpate {

struct CameraLimits {
  // First image against the scene.
  // Error of the object's size [-]. [tuned: pixel size wrong, outline wrong]
  static constexpr double kMostScale = 0.02;
  // Residual of the object's outline, rms [px]. [tuned: object elsewhere than told]
  static constexpr double kMostResidual = 2;
  // Distance of the tool's end from the encoder reading [px]. [tuned: the arm's report wrong]
  static constexpr double kToolElsewhere = 1;
  // Error of the tool's width [-]. [tuned: pixel size wrong]
  static constexpr double kToolWidth = 0.12;
  // Edge width, 1: sharp [-]. [tuned: defocus]
  static constexpr double kSharpAtRest = 0.30;

  // Each image.
  // Edge width relative to the first image [-]. [tuned: defocus while pressed, motion blur along x]
  static constexpr double kSharpness = 0.47;
  // Brightest edge, of the largest grey level [-]. [tuned: brighter, glint beside the contact]
  static constexpr double kOverexposed = 1.15;
  // Offset of every other row at the tip [px]. [derived: one pixel is what rounding gives]
  static constexpr int kMostComb = 1;
  // Motion of the image [px], [rad], growth [-]. [tuned: camera bumped at rest - x, camera turned
  // at rest, zoom changed at rest]
  static constexpr double kMostShift = 40, kMostTurn = 0.06, kMostGrowth = 0.03;
  // Indentation that needs no confirmation [px]. [tuned: undisturbed]
  static constexpr double kSmallDent = 1.5;
};

}  // namespace palpate
