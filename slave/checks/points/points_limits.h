// Limits of the checks of a stereo pair or depth camera, as `check` prints them. Rows are those of
// the robustness suite.
#pragma once

namespace palpate {

struct PointsLimits {
  // First pairs, which show what rays and images are like at rest [-]. [derived: the ten pairs of
  // the rest frame of dots]
  static constexpr int kLearning = 10;

  // Distance of left and right rays.
  // For a camera that has not moved [px]. [tuned: one camera bumped at rest - across]
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
  // Distance of a body's surface, by the size of the body, where that is less than kTrueSize of the
  // distance [-]; its tilt [rad]. The edge that must be seen, by the middle [-], and sigmas.
  static constexpr double kRestOffset = 0.1, kRestTilt = 0.05, kRestEdge = 0.6, kRestSigmas = 5;
  // Depths err alike within patches of this edge [px], see DepthPoints.
  static constexpr double kDepthPatch = 10;
  // Offset of the dots along the surface, by the distance of neighbours [-]. [tuned: rig
  // elsewhere than stated]
  static constexpr double kTruePlace = 0.25;
};

}  // namespace palpate
