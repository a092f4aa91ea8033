// Windows worth tracking, where nobody named any.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace palpate {

// Centres [px] of at most `count` windows of `edge` px whose structure tensor (sum of grad grad^T
// over the window) has the largest lesser eigenvalues: J. Shi and C. Tomasi, CVPR 1994. At least
// `apart` from each other and a window inside the picture; best first. Empty: no texture, or
// nothing to read (not 8 bit, neither grey nor BGR).
std::vector<Eigen::Vector2d> ChooseWindows(const cv::Mat& picture, int count, int edge,
                                           double apart);

}  // namespace palpate
