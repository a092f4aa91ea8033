// Calibration of a stereo pair from pairs of images of a board, taken at the same times.
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
  double sigma_focal = 0;                 // the larger of both, relative
  std::vector<double> left_px, right_px;  // rms of each pair in the joint refinement
  // Excess residual of each pair with one pose of the board over a separate pose for each image:
  // sqrt(joint^2 - own^2), rms over both images. Noise of the corners and misfit of the lens
  // cancel; motion of the board between the exposures does not.
  std::vector<double> rift_px;
  std::vector<Eigen::Isometry3d> X_LB;  // of each pair's board
};

// Each camera separately, then everything together: both lenses, X_RL and every board's pose by
// least squares of all corners. The corners of a pair have the same order. Throws
// std::runtime_error with a sentence.
PairFit FitPair(const Board& board, const std::vector<PairView>& pairs, const PairSizes& sizes);
// Only the joint refinement, from a rig near the result.
StereoRig RefinePair(const Board& board, const std::vector<PairView>& pairs,
                     const StereoRig& start);
// The rectification R1, R2, P1, P2, Q of a rig, in OpenCV's terms: the same rows of both images
// show the same points.
std::vector<NamedMatrix> Rectification(const StereoRig& rig);

struct PairCalibration {
  PairFit fit;                  // of the used pairs
  std::vector<PairView> views;  // the used pairs, corners in the same order
  std::vector<std::size_t>
      used;  // indices of the used pairs, rising; the lists of fit have this order
  struct Dropped {
    std::size_t pair = 0;
    double miss_px = 0;  // deviation from the pose that the others agree on, rms
  };
  std::vector<Dropped> dropped;  // pairs that contradict the others
};

// Pairs whose board moved between the exposures, or whose images are of different times, fit each
// camera but no rigid pair. They are found against the pose that most pairs agree on, then by their
// excess residual in the joint refinement, and excluded. That pose also determines the order of the
// right board's corners (OrdersOf), so the cameras may be rolled against each other. Throws
// std::runtime_error with a sentence: fewer than three pairs, or no pose that three agree on.
PairCalibration CalibratePair(const Board& board, const std::vector<PairView>& pairs,
                              const PairSizes& sizes);

}  // namespace palpate
