// Calibration of a lens or a stereo pair from images of a board, and the verdict whether it may be
// trusted: a small residual shows that the numbers fit these images, not that other images would
// give the same ones.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "slave/vision/calibration/board.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

// A view of the board by one camera, or by both at the same time.
struct BoardView {
  Corners left, right;  // right: of pairs
};

struct ImageSizes {
  std::array<int, 2> left{}, right{};  // [px]; right: of pairs
};

struct Calibration {
  bool is_pair = false;
  StereoRig rig;                              // one camera: `left`
  std::vector<std::size_t> used;              // indices of the used views, rising
  std::vector<std::array<double, 2>> rms_px;  // of their left and right images
  struct Dropped {
    std::size_t view = 0;
    std::string why;
  };
  std::vector<Dropped> dropped;
  // Relative standard deviation of the baseline (one camera: of the focal length), by the jackknife
  // (Efron and Tibshirani, An Introduction to the Bootstrap, 1993, ch. 11).
  double sigma = 0;
  std::vector<std::string> reasons;  // why it cannot be trusted; empty: it may
};

// Least squares of the reprojection by OpenCV, k1 k2 p1 p2; k3 stays 0, because boards seldom reach
// the image corners, which are needed to distinguish it from k2. For pairs each camera is fitted
// separately, then both lenses, X_RL and all poses of the board together. Views are dropped if they
// repeat another one, or if their error is three times the median (blurred, bent, or another
// board), and pairs if one pose of the board fits worse than a pose for each camera (the board
// moved between the exposures). Throws std::runtime_error with a sentence: fewer than three views,
// views that determine no lens or no pair, or for a pair a board that looks the same after half a
// turn.
Calibration Calibrate(const Board& board, const std::vector<BoardView>& views,
                      const ImageSizes& sizes);

}  // namespace palpate
