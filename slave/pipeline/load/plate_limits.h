// Limits of the fit of a load on a flat membrane. Rows are those of the robustness suite.
#pragma once

#include <cstddef>

#include "slave/checks/load/load_limits.h"

namespace palpate {

struct PlateLimits {
  // Largest number of points; of more points, this number at equal steps is used [-]. [tuned:
  // surface_estimator_test, a force from 1681 points]
  static constexpr std::size_t kMaxPoints = 128;
  // Points of a motion or an outlier [-]. [derived: four of a load, and one to spare]
  static constexpr int kMinPoints = 5;

  // Outliers. Fits with softened weights [-], scatter at which weights fall [sigma]. [tuned:
  // surface_flags_test, dots out of place]
  static constexpr int kSoftRounds = 6;
  static constexpr double kSoft = 2;  // [sigma] [tuned: surface_flags_test, dots out of place]
  // Error of the model relative to the largest deflection [-]. [derived: that of the check of the
  // fit]
  static constexpr double kModelError = LoadLimits::kModelError;
  // Solutions of the plate for fits with the same rim [-]. [recorded: a compensated rig needs up to
  // 650, a moved rim 1000; points of a mirrored image took seconds] [tuned:
  // AMovedRimIsFlaggedAndNotTurnedIntoForce]
  static constexpr long kMaxPresses = 1300;

  // A moved rim or rig. It is sought if more points are left out [-], or the residual is larger
  // [-]; and found if the residual falls to this share [-]. [tuned: surface_flags_test, a moved
  // rim, a bumped rig]
  static constexpr double kManyLeftOut = 0.15, kPoorFit = 2, kClearlyBetter = 0.7;
  // Model error of a rim motion relative to the depth, and shift and contraction of the points
  // along the plate by a contact relative to the depth [-]. [tuned: surface_flags_test, a moved
  // rim, a bumped rig, points that move apart]
  static constexpr double kRimShare = 0.02, kSidewaysShare = 0.1, kGrowthShare = 0.03;
  // Compensated rigid motion of rig or membrane [m]: along the plate, normal to it, and at the rim
  // by a tilt. Rotation of the cameras about themselves raises nothing. [tuned: rig bumped at rest]
  static constexpr double kMaxSlide = 4e-3, kMaxRise = 0.3e-3, kMaxTilt = 1.5e-3;
  // Images that determine the rim's motion, and that are remembered [-]. [tuned: rig bumped at
  // rest, 10 px: 2.3 % rms]
  static constexpr int kRestFrames = 5, kMaxRestFrames = 100;

  // Uncertainty. Error of the plate's shape around a load, divided by the depth [-]. [tuned:
  // AnIndentationOfAnotherTensionIsFlaggedOrIncreasesSigma]
  static constexpr double kLawsShape = 0.9e-3;
  // Weight of a new image in the scatter without contact [-]. [derived: the mean of about ten
  // images]
  static constexpr double kForgetsRest = 0.1;
  // In the scatter of the points the reported sigmas count as kReportedWeight points. Errors beyond
  // the noise are common to kPointsPerError points [-]. [recorded: 79.6 and 96.6 % of fifty random
  // presses within one and two sigma]
  static constexpr double kReportedWeight = 20, kPointsPerError = 4;
};

}  // namespace palpate
