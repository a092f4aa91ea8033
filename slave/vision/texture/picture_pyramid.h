// A grey picture and its halves, quarters, ...: what windows of texture are looked for in, coarse
// to fine.
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

namespace palpate {

class PicturePyramid {
 public:
  // `levels` >= 1; fewer where the picture would shrink below 32 px. Throws std::invalid_argument:
  // not 8 bit, neither grey nor BGR, smaller than 32 px.
  PicturePyramid(const cv::Mat& first, int levels);

  // Takes a picture in, of the first one's size and type; false (and nothing changed) otherwise.
  // Real-time safe.
  bool Read(const cv::Mat& picture) noexcept;

  [[nodiscard]] int levels() const { return static_cast<int>(levels_.size()); }
  [[nodiscard]] const cv::Mat& operator[](int level) const {  // 8 bit grey
    return levels_[static_cast<std::size_t>(level)];
  }

 private:
  int type_ = 0;
  std::vector<cv::Mat> levels_;
};

}  // namespace palpate
