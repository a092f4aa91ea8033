#include "slave/vision/ncc.h"

#include <cmath>
#include <cstdint>
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
  mean_ = cv::mean(levels_)[0];
  for (const std::int16_t level : pattern_.levels) contrast_ += (level - mean_) * (level - mean_);
}

const ScoreMap& Ncc::Match(const GreyPatch& window) {
  map_.release();
  if (window.width < pattern_.width || window.height < pattern_.height) return map_;
  cv::matchTemplate(AsFloat(window), levels_, map_, cv::TM_CCOEFF_NORMED);
  return map_;
}

double Ncc::At(const GreyPatch& window, int x, int y) const {
  double sum = 0, square = 0, product = 0;
  for (int j = 0; j < pattern_.height; ++j) {
    const std::int16_t *T = pattern_.Row(j), *I = window.Row(y + j) + x;
    for (int i = 0; i < pattern_.width; ++i) {
      sum += I[i];
      square += I[i] * I[i];
      product += (T[i] - mean_) * I[i];
    }
  }
  const double contrast = square - sum * sum / static_cast<double>(pattern_.levels.size());
  return contrast > 0 ? product / std::sqrt(contrast_ * contrast) : 0;
}

}  // namespace palpate
