// Reductions of an image, and selection of windows of texture in it.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace palpate {

// A grey image and its reductions by two: the pyramid in which windows are searched from coarse to
// fine.
class ImagePyramid {
 public:
  // `levels` >= 1; fewer if the image would become smaller than 32 px. Throws
  // std::invalid_argument: not 8 bit, neither grey nor BGR, smaller than 32 px.
  ImagePyramid(const cv::Mat& first, int levels);

  // Loads an image of the first one's size and type; otherwise returns false without a change.
  // Real-time safe.
  bool Read(const cv::Mat& image) noexcept;

  [[nodiscard]] int levels() const { return static_cast<int>(levels_.size()); }
  [[nodiscard]] const cv::Mat& operator[](int level) const {  // 8 bit grey
    return levels_[static_cast<std::size_t>(level)];
  }

 private:
  int type_ = 0;
  std::vector<cv::Mat> levels_;
};

// Automatic selection of windows: centres [px] of at most `count` windows of `edge` px whose
// structure tensor (sum of grad grad^T over the window) has the largest smaller eigenvalues: J. Shi
// and C. Tomasi, CVPR 1994. At least `apart` from each other, with a window inside the image; best
// first. Empty: no texture, or an unusable image (not 8 bit, neither grey nor BGR).
std::vector<Eigen::Vector2d> ChooseWindows(const cv::Mat& image, int count, int edge, double apart);

}  // namespace palpate
