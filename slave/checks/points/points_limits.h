// Limits of the checks of a stereo pair or depth camera. Rows in the evidence are those of the
// robustness suite.
#pragma once

namespace palpate {

struct PointsLimits {
  // Number of first pairs that determine the baseline of rays and images [-]. [derived: the ten
  // pairs of the rest frame of dots]
  static constexpr int kLearning = 10;

  // Distance of left and right rays. It must be below this limit for a camera that has not moved
  // [px]. [tuned: one camera bumped at rest - across]
  static constexpr double kMaxOffset = 0.5;
  // At rest, in addition to the rig's own rms [px]. [tuned: rig turned against the scene]
  static constexpr double kMaxAtRest = 0.5;
  // Largest offset at rest of a simulated pair, whose rig is the scene's [px]. [tuned: baseline
  // wrong]
  static constexpr double kMaxAtRestOfExactRig = 0.02;
  // Delay of the right image beyond its timestamp [image periods]. [tuned: right image late, left
  // image late]
  static constexpr double kMaxLag = 0.2;

  // At rest against the scene.
  // Error of distances [-]. [tuned: distance of the dots wrong, depth scaled; forces rise with
  // the third power]
  static constexpr double kTrueSize = 0.015;
  // Limits of a body's surface at rest: distance relative to the size of the body, if that is less
  // than kTrueSize of the distance [-]; tilt [rad]; visible share of the edge relative to that of
  // the centre [-]; number of sigmas.
  static constexpr double kRestOffset = 0.1, kRestTilt = 0.05, kRestEdge = 0.6, kRestSigmas = 5;
  // Edge of patches within which depth errors are equal [px], see DepthPoints.
  static constexpr double kDepthPatch = 10;
  // Offset of the dots along the surface, relative to the distance of neighbours [-]. [tuned: rig
  // elsewhere than stated]
  static constexpr double kTruePlace = 0.25;
};

}  // namespace palpate
