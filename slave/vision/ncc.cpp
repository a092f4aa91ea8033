#include "slave/vision/ncc.h"

#include <stdexcept>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace palpate {
namespace {

cv::Mat AsFloat(const GreyPatch& patch) {
  cv::Mat levels;
  patch.Mat().convertTo(levels, CV_32F);
  return levels;
}

}  // namespace

Ncc::Ncc(GreyPatch pattern) : pattern_(std::move(pattern)) {
  if (pattern_.levels.empty()) throw std::invalid_argument("the template is empty");
  if (!(VarianceOf(pattern_) > 0)) throw std::invalid_argument("the template has no contrast");
  levels_ = AsFloat(pattern_);
}

const ScoreMap& Ncc::Match(const GreyPatch& window) {
  map_.release();
  if (window.width < pattern_.width || window.height < pattern_.height) return map_;
  cv::matchTemplate(AsFloat(window), levels_, map_, cv::TM_CCOEFF_NORMED);
  return map_;
}

}  // namespace palpate
