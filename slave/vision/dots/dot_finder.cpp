#include "slave/vision/dots/dot_finder.h"

#include <algorithm>
#include <exception>
#include <numbers>
#include <optional>

#include <opencv2/imgproc.hpp>

#include "shared/text/text.h"

namespace palpate {
namespace {

// Darkest and lightest level are found on a raster, in a square about as wide as two dots.
// [px], [raster] [tuned: CentroidsOfEllipsesWithoutNoiseAreExact]
constexpr int kRaster = 4, kSquare = 9;
// Margin around the region of a dot, so that its window contains background on all sides [px].
// [tuned: LightThatFallsAcrossTheImageLosesNoDot]
constexpr int kMargin = 3;

bool IsGrey(const cv::Mat& image) {
  return image.dims == 2 && image.type() == CV_8UC1 && !image.empty();
}

bool TouchesEdge(const cv::Rect& box, const cv::Size& size) {
  return box.x == 0 || box.y == 0 || box.x + box.width == size.width ||
         box.y + box.height == size.height;
}

}  // namespace

DotFinder::DotFinder(const Params& params) : params_(params) {
  const DotShapeLimits& limits = params.limits;
  Require(limits.area_min >= 5, "area_min", limits.area_min, "at least 5 px^2");
  Require(limits.area_max > limits.area_min, "area_max", limits.area_max, "more than area_min");
  Require(limits.axes_ratio_min > 0 && limits.axes_ratio_min <= 1, "axes_ratio_min",
          limits.axes_ratio_min, "0 < ratio <= 1");
  Require(limits.contrast_min >= 1 && limits.contrast_min <= 255, "contrast_min",
          limits.contrast_min, "1 to 255");
}

bool DotFinder::Find(const cv::Mat& image, std::vector<Dot>* dots) noexcept try {
  dots->clear();
  if (!IsGrey(image)) return false;
  Binarise(image);
  // Uses contours, because connectedComponentsWithStats takes 20 times as long and starts threads.
  std::vector<cv::Vec4i> hierarchy;  // the last entry is the region that contains this hole
  cv::findContours(binary_, regions_, hierarchy, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  for (std::size_t k = 0; k < regions_.size() && dots->size() < params_.most; ++k) {
    if (hierarchy[k][3] >= 0) continue;
    const cv::Rect box = cv::boundingRect(regions_[k]);
    if (!MayBeDot(box, image.size())) continue;
    if (const auto dot = Measure(image, box)) dots->push_back(*dot);
  }
  return true;
} catch (const std::exception&) {
  dots->clear();
  return false;
}

// The threshold is halfway between the darkest and the lightest level nearby. The mean in
// cv::adaptiveThreshold fails where the background becomes lighter beside a dot.
void DotFinder::Binarise(const cv::Mat& image) {
  const cv::Size raster((image.cols + kRaster - 1) / kRaster, (image.rows + kRaster - 1) / kRaster);
  const auto square = [](int edge) {
    return cv::getStructuringElement(cv::MORPH_RECT, {edge, edge});
  };
  const auto extreme = [&](int operation, cv::Mat* out) {
    cv::morphologyEx(image, *out, operation, square(kRaster + 1));
    cv::resize(*out, *out, raster, 0, 0, cv::INTER_NEAREST);
    cv::morphologyEx(*out, *out, operation, square(kSquare));
  };
  cv::Mat darkest, lightest, threshold;
  extreme(cv::MORPH_ERODE, &darkest);
  extreme(cv::MORPH_DILATE, &lightest);
  cv::addWeighted(darkest, 0.5, lightest, 0.5, 0, threshold);
  const bool dark = params_.tone == DotTone::kDark;
  threshold.setTo(dark ? 0 : 255, lightest - darkest < params_.limits.contrast_min);
  cv::resize(threshold, threshold, image.size(), 0, 0, cv::INTER_NEAREST);
  cv::compare(image, threshold, binary_, dark ? cv::CMP_LT : cv::CMP_GT);
}

bool DotFinder::MayBeDot(const cv::Rect& box, const cv::Size& image) const {
  const DotShapeLimits& limits = params_.limits;
  const double area = std::numbers::pi / 4 * box.area();
  const double ratio = 1.0 * std::min(box.width, box.height) / std::max(box.width, box.height);
  return area >= limits.area_min && area <= 2 * limits.area_max && ratio >= limits.axes_ratio_min &&
         !TouchesEdge(box, image);
}

// Uses as threshold the level halfway between the darkest and the lightest one around the region.
std::optional<Dot> DotFinder::Measure(const cv::Mat& image, const cv::Rect& box) {
  const cv::Rect around(box.x - kMargin, box.y - kMargin, box.width + 2 * kMargin,
                        box.height + 2 * kMargin);
  const cv::Rect window = around & cv::Rect({}, image.size());
  double darkest = 0, lightest = 0;
  cv::minMaxLoc(image(window), &darkest, &lightest);
  if (lightest - darkest < params_.limits.contrast_min) return std::nullopt;
  const int threshold = static_cast<int>(darkest + lightest + 1) / 2;
  const bool dark = params_.tone == DotTone::kDark;
  cv::threshold(image(window), binary_, threshold - 1, 255,
                dark ? cv::THRESH_BINARY_INV : cv::THRESH_BINARY);
  cv::findContours(binary_, inner_, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  for (std::size_t k = 0; k < inner_.size(); ++k) {
    if (TouchesEdge(cv::boundingRect(inner_[k]), window.size())) continue;
    region_ = cv::Mat::zeros(window.size(), CV_8UC1);
    cv::drawContours(region_, inner_, static_cast<int>(k), cv::Scalar(255), cv::FILLED);
    const auto ellipse = EllipseOf(cv::moments(region_, true), window.tl(), params_.limits);
    if (!ellipse) continue;
    return RefineDot(image, *ellipse, threshold, params_.tone, params_.limits);
  }
  return std::nullopt;
}

}  // namespace palpate
