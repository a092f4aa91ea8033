#include "slave/vision/ncc.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace palpate {
namespace {

constexpr int kChunk = 512;  // products that fit in 32 bits. [by definition: GreyPatch]

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
  std::int64_t sum = 0, square = 0, product = 0;
  for (int j = 0; j < pattern_.height; ++j) {
    const std::int16_t *T = pattern_.Row(j), *I = window.Row(y + j) + x;
    for (int i = 0; i < pattern_.width; i += kChunk) {
      std::int32_t of_sum = 0, of_square = 0, of_product = 0;
      const int end = std::min(i + kChunk, pattern_.width);
      for (int k = i; k < end; ++k) {
        of_sum += I[k];
        of_square += I[k] * I[k];
        of_product += T[k] * I[k];
      }
      sum += of_sum, square += of_square, product += of_product;
    }
  }
  const auto level = static_cast<double>(sum);
  const double contrast =
      static_cast<double>(square) - level * level / static_cast<double>(pattern_.levels.size());
  const double common = static_cast<double>(product) - mean_ * level;
  return contrast > 0 ? common / std::sqrt(contrast_ * contrast) : 0;
}

}  // namespace palpate
