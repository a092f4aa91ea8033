// Two cameras from pairs of pictures of a board, taken at the same instants.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "slave/vision/calibration/lens_calibration.h"

namespace palpate {

// A board that both cameras see; corners aligned.
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
  std::vector<Eigen::Isometry3d> X_LB;    // of each pair's board
};

// Each camera by itself, then everything together: both lenses, X_RL and every board's pose by
// least squares of all corners. Throws std::runtime_error in words.
PairFit FitPair(const Board& board, const std::vector<PairView>& pairs, const PairSizes& sizes);

struct PairCalibration {
  PairFit fit;                    // of what is used
  std::vector<std::size_t> used;  // rising; fit's lists are in this order
  struct Dropped {
    std::size_t pair = 0;
    double residual_px = 0;
  };
  std::vector<Dropped> dropped;  // pairs that contradict the others
};

// Pairs whose board moved between the two shots, or whose pictures belong to different instants,
// fit each camera but no rigid pair: they are found against the pose most others agree on, then
// against the joint refinement, and left out. Throws std::runtime_error in words: fewer than three
// pairs, or no pose that three agree on.
PairCalibration CalibratePair(const Board& board, const std::vector<PairView>& pairs,
                              const PairSizes& sizes);

}  // namespace palpate
