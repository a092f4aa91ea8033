// Two cameras from pairs of pictures of a board, taken at the same instants.
#pragma once

#include <array>
#include <vector>

#include "slave/vision/calibration/lens_calibration.h"

namespace palpate {

// A board that both cameras see.
struct PairView {
  Corners left, right;
};

struct PairSizes {
  std::array<int, 2> left{}, right{};  // [px]
};

struct PairFit {
  StereoRig rig;                          // with the joint refinement's residual
  double left_rms_px = 0;                 // of each camera alone
  double right_rms_px = 0;                //
  double sigma_focal = 0;                 // the larger of both, relative
  std::vector<double> left_px, right_px;  // rms of each pair in the joint refinement
  // How much worse each pair fits where its board has one pose than where each of its two pictures
  // has a pose of its own: sqrt(joint^2 - own^2), rms over both pictures. What the corners' noise
  // and the lens's misfit do to both fits is not in it; a board that moved between the shots is.
  std::vector<double> rift_px;
  std::vector<Eigen::Isometry3d> X_LB;  // of each pair's board
};

// Each camera by itself, then everything together: both lenses, X_RL and every board's pose by
// least squares of all corners. The corners of a pair are in one order. Throws std::runtime_error
// in words.
PairFit FitPair(const Board& board, const std::vector<PairView>& pairs, const PairSizes& sizes);
// The joint refinement alone, from a rig near the answer.
StereoRig RefinePair(const Board& board, const std::vector<PairView>& pairs,
                     const StereoRig& start);
// The rectification R1, R2, P1, P2, Q that follows from a rig, as OpenCV names it: the same rows of
// both pictures show the same points.
std::vector<NamedMatrix> Rectification(const StereoRig& rig);

struct PairCalibration {
  PairFit fit;                    // of what is used
  std::vector<PairView> views;    // what is used, corners in one order
  std::vector<std::size_t> used;  // of the pairs given, rising; fit's lists are in this order
  struct Dropped {
    std::size_t pair = 0;
    double miss_px = 0;  // how far it is off from what the others agree on, rms
  };
  std::vector<Dropped> dropped;  // pairs that contradict the others
};

// Pairs whose board moved between the two shots, or whose pictures belong to different instants,
// fit each camera but no rigid pair: they are found against the pose most others agree on, then by
// their rift in the joint refinement, and left out. That pose also tells which corner of the right
// board is which (BoardSymmetry), so the cameras may be rolled against each other. Throws
// std::runtime_error in words: fewer than three pairs, or no pose that three agree on.
PairCalibration CalibratePair(const Board& board, const std::vector<PairView>& pairs,
                              const PairSizes& sizes);

}  // namespace palpate
