// A camera's pose from places and their pictures.
#pragma once

#include <vector>

#include "slave/vision/calibration/registration.h"
#include "slave/vision/calibration/robust_fit.h"

namespace palpate {

struct LensPose {
  CameraGuess guess;
  double sum_of_squares = 0;  // of the misses [px^2]
};

// Poses at which the pictures of `which` places miss least, the best first: from OpenCV's SQPnP and
// from its answer turned over as a plane is that looks alike from afar (Oberkampf, DeMenthon and
// Davis, Computer Vision and Image Understanding 63, 1996); a local minimum, if it is another one,
// comes second. Empty: they define none.
std::vector<LensPose> LensPoses(const Lens& lens, const std::vector<TipPlace>& places,
                                const Indices& which);

// How far the picture of `place` is from where it was seen [px]; NaN: it has none.
double LensMiss(const Lens& lens, const Eigen::Isometry3d& X_SC, const TipPlace& place);

}  // namespace palpate
