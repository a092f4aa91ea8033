#include "slave/vision/dots/dot_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <string>

namespace palpate {
namespace {

bool IsGrey(const cv::Mat& image) noexcept {
  return image.dims == 2 && image.type() == CV_8UC1 && image.data != nullptr && image.cols > 0 &&
         image.rows > 0;
}

void Require(bool met, const std::string& what, double value, const std::string& accepted) {
  if (!met) {
    throw std::invalid_argument(what + " = " + std::to_string(value) + ": accepted is " + accepted);
  }
}

bool TouchesEdge(const Blob& blob, const cv::Mat& image) noexcept {
  return blob.left == 0 || blob.top == 0 || blob.right == image.cols - 1 ||
         blob.bottom == image.rows - 1;
}

// The darkest and the lightest value.
std::array<int, 2> Extremes(const cv::Mat& image) noexcept {
  std::uint8_t darkest = 255, lightest = 0;
  for (int y = 0; y < image.rows; ++y) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(y);
    for (int x = 0; x < image.cols; ++x) {
      darkest = std::min(darkest, row[x]);
      lightest = std::max(lightest, row[x]);
    }
  }
  return {darkest, lightest};
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
  dots->reserve(params_.most);
  if (!thresholds_.Fit(image, static_cast<int>(params_.limits.contrast_min))) return true;
  bits_.resize(static_cast<std::size_t>(image.cols + 63) / 64);
  labeller_.Begin(image.cols);
  for (int y = 0; y < image.rows; ++y) {
    DarkBits(image.ptr<std::uint8_t>(y), image.cols, thresholds_.Row(y), bits_.data());
    labeller_.AddRow(y, bits_.data(), params_.tone == DotTone::kLight);
  }
  for (const Blob& blob : labeller_.Finish()) {
    if (dots->size() == params_.most) break;
    if (TouchesEdge(blob, image)) continue;
    const auto ellipse = EllipseOf(blob, params_.limits);
    if (!ellipse) continue;
    const int threshold = thresholds_.At(static_cast<int>(ellipse->centre.x()),
                                         static_cast<int>(ellipse->centre.y()));
    const auto dot = RefineDot(image, *ellipse, threshold, params_.tone, params_.limits);
    if (dot) dots->push_back(*dot);
  }
  return true;
} catch (const std::exception&) {
  dots->clear();
  return false;
}

bool DotFinder::Track(const cv::Mat& image, const std::vector<ExpectedDot>& expected,
                      std::vector<SightedDot>* sighted) noexcept try {
  sighted->assign(expected.size(), {});
  if (!IsGrey(image)) return false;
  bits_.resize(static_cast<std::size_t>(image.cols + 63) / 64);
  one_threshold_.resize(static_cast<std::size_t>(image.cols + 15) / 16);
  for (std::size_t k = 0; k < expected.size(); ++k) (*sighted)[k] = Look(image, expected[k]);
  return true;
} catch (const std::exception&) {
  sighted->clear();
  return false;
}

// A window about the place, with one threshold for all of it.
SightedDot DotFinder::Look(const cv::Mat& image, const ExpectedDot& expected) {
  const Eigen::Vector2d place = expected.place;
  const Eigen::Array2d reach = expected.extent.array() + expected.search + 1;
  const double far = 1e6;
  if (!(place.cwiseAbs().maxCoeff() < far && reach.abs().maxCoeff() < far)) return {};
  const int left = std::max(0, static_cast<int>(std::floor(place.x() - reach.x())));
  const int top = std::max(0, static_cast<int>(std::floor(place.y() - reach.y())));
  const int right = std::min(image.cols, static_cast<int>(std::ceil(place.x() + reach.x())) + 1);
  const int bottom = std::min(image.rows, static_cast<int>(std::ceil(place.y() + reach.y())) + 1);
  if (right - left < 3 || bottom - top < 3) return {};
  const cv::Mat window = image(cv::Rect(left, top, right - left, bottom - top));
  const auto [darkest, lightest] = Extremes(window);
  if (lightest - darkest < params_.limits.contrast_min) return {};
  const int threshold = (darkest + lightest + 1) / 2;
  std::fill(one_threshold_.begin(), one_threshold_.end(), static_cast<std::uint8_t>(threshold));
  labeller_.Begin(window.cols);
  for (int y = 0; y < window.rows; ++y) {
    DarkBits(window.ptr<std::uint8_t>(y), window.cols, one_threshold_.data(), bits_.data());
    labeller_.AddRow(y, bits_.data(), params_.tone == DotTone::kLight);
  }
  SightedDot nearest;
  double distance = expected.search;
  for (const Blob& blob : labeller_.Finish()) {
    if (TouchesEdge(blob, window)) continue;
    auto ellipse = EllipseOf(blob, params_.limits);
    if (!ellipse) continue;
    ellipse->centre += Eigen::Vector2d(left, top);
    const double off = (ellipse->centre - place).cwiseAbs().maxCoeff();
    if (!(off <= distance)) continue;
    const auto dot = RefineDot(image, *ellipse, threshold, params_.tone, params_.limits);
    if (!dot) continue;
    if (expected.area > 0 && !(dot->area < 2 * expected.area && dot->area > expected.area / 2)) {
      continue;
    }
    nearest = {true, *dot};
    distance = off;
  }
  return nearest;
}

}  // namespace palpate
