#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "shared/statistics/robust.h"
#include "slave/vision/rest_contour.h"

namespace palpate {
namespace {

using PixelChain = std::vector<cv::Point>;

// Larger images are searched at this size [px]. [tuned: PicturesWithoutAnObjectAreRefused]
constexpr double kWorkingEdge = 480;
// Against noise and fine texture [px]. [tuned: PicturesWithoutAnObjectAreRefused]
constexpr double kBlur = 1.5;
constexpr int kThresholds = 32;  // between the darkest and the brightest percent
constexpr double kSmallest = 0.001, kLargest = 0.7;  // area, part of the image
// Area / area of the convex hull. [-] [tuned: PicturesWithoutAnObjectAreRefused]
constexpr double kLeastSolidity = 0.8;
constexpr double kLeastRoundness = 0.35;  // 4 pi area / length^2 of the hull: no bar
constexpr double kLeastAgreement = 0.5;   // of the edge's sign along the outline, 0 to 1
constexpr double kLeastEdge = 1;          // mean gradient across the outline [grey levels / px]
// Circles are searched at this size [px]. [tuned: PicturesWithoutAnObjectAreRefused]
constexpr double kCircleEdge = 160;
// Of cv::HoughCircles at that size: gradient of an edge [levels over 2 px], votes, distance of
// centres and least radius [px]. [tuned: DrosophilaEmbryosAreFound]
constexpr double kCircleGradient = 30, kCircleVotes = 10, kCirclesApart = 5;
constexpr int kSmallestRadius = 4;
constexpr std::size_t kCircles = 24;  // considered beside the regions

// Grey levels below which lie 1 % and 99 % of the pixels.
cv::Vec2i Percentiles(const cv::Mat& image) {
  std::array<int, 256> histogram{};
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) ++histogram[image.at<uchar>(y, x)];
  }
  const double total = static_cast<double>(image.total());
  cv::Vec2i levels(0, 255);
  double below = 0;
  for (int level = 0; level < 256; ++level) {
    if (below < 0.01 * total) levels[0] = level;
    if (below < 0.99 * total) levels[1] = level;
    below += histogram[static_cast<std::size_t>(level)];
  }
  return levels;
}

bool TouchesBorder(const PixelChain& outline, const cv::Size& size) {
  const cv::Rect box = cv::boundingRect(outline);
  return box.x <= 1 || box.y <= 1 || box.x + box.width >= size.width - 1 ||
         box.y + box.height >= size.height - 1;
}

// How strong the edge across the outline is, light to dark or dark to light all round: where the
// sign changes, the parts cancel, and a strong piece counts no more than twice the median, so that
// a line the outline happens to cross does not make it an object.
double EdgeAcross(const PixelChain& outline, const cv::Mat& gx, const cv::Mat& gy) {
  constexpr std::size_t kSpan = 3;  // points to either side that tell the tangent
  const std::size_t n = outline.size();
  std::vector<double> across, magnitude;
  for (std::size_t i = 0; i < n; ++i) {
    const cv::Point2d tangent = outline[(i + kSpan) % n] - outline[(i + n - kSpan % n) % n];
    const double length = std::max(cv::norm(tangent), 1e-9);
    across.push_back((gx.at<float>(outline[i]) * tangent.y - gy.at<float>(outline[i]) * tangent.x) /
                     length);
    magnitude.push_back(std::abs(across.back()));
  }
  const double middle = MedianOf(magnitude);
  double sum = 0;
  int balance = 0;
  for (const double g : across) {
    sum += std::clamp(g, -2 * middle, 2 * middle);
    balance += g > 0 ? 1 : -1;
  }
  const double agreement = balance / static_cast<double>(n);  // of the signs, -1 to 1
  if (std::abs(agreement) < kLeastAgreement) return 0;
  return std::abs(sum) / static_cast<double>(n) * agreement * agreement;
}

class Search {
 public:
  Search(const cv::Mat& image, double tool_width) : size_(image.size()), tool_width_(tool_width) {
    cv::GaussianBlur(image, smooth_, {}, kBlur);
    cv::Sobel(smooth_, gx_, CV_32F, 1, 0, 3, 0.125);
    cv::Sobel(smooth_, gy_, CV_32F, 0, 1, 3, 0.125);
    const int cut = std::max(3, 2 * static_cast<int>(std::ceil(0.25 * tool_width)) + 1);
    tool_kernel_ = cv::getStructuringElement(cv::MORPH_ELLIPSE, {cut, cut});
    small_kernel_ = cv::getStructuringElement(cv::MORPH_ELLIPSE, {3, 3});
  }

  // The best outline; empty: none.
  PixelChain Run() {
    const cv::Vec2i range = Percentiles(smooth_);
    for (int k = 1; k < kThresholds; ++k) {
      const double level = range[0] + (range[1] - range[0]) * (k / double{kThresholds});
      for (const int type : {cv::THRESH_BINARY, cv::THRESH_BINARY_INV}) {
        cv::threshold(smooth_, mask_, level, 255, type);
        Consider(mask_, small_kernel_, 1);
        // What is no wider than the tool goes; at half the size, for a kernel that wide is dear.
        cv::resize(mask_, half_, (mask_.size() + cv::Size(1, 1)) / 2, 0, 0, cv::INTER_NEAREST);
        Consider(half_, tool_kernel_, 2);
      }
    }
    ConsiderCircles();
    return best_;
  }

 private:
  // The regions of `mask`, a pixel of which is `scale` of the image's wide.
  void Consider(const cv::Mat& mask, const cv::Mat& kernel, int scale) {
    cv::morphologyEx(mask, opened_, cv::MORPH_OPEN, kernel);
    std::vector<PixelChain> outlines;
    cv::findContours(opened_, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    for (PixelChain& outline : outlines) {
      for (cv::Point& p : outline) p *= scale;
      Offer(outline);
    }
  }

  // Embryos that touch each other or their bed are no regions of their own, but still round.
  void ConsiderCircles() {
    const double scale = std::min(1.0, kCircleEdge / std::max(size_.width, size_.height));
    cv::Mat small;
    cv::resize(smooth_, small, {}, scale, scale, cv::INTER_AREA);
    std::vector<cv::Vec3f> circles;  // best first
    cv::HoughCircles(small, circles, cv::HOUGH_GRADIENT, 1, kCirclesApart, kCircleGradient,
                     kCircleVotes, kSmallestRadius, std::min(small.cols, small.rows) / 2);
    circles.resize(std::min(circles.size(), kCircles));
    for (const cv::Vec3f& circle : circles) {
      const double radius = circle[2] / scale;
      if (radius <= tool_width_) continue;  // fits the tool itself
      const cv::Point centre(cvRound((circle[0] + 0.5) / scale - 0.5),
                             cvRound((circle[1] + 0.5) / scale - 0.5));
      PixelChain outline;
      cv::ellipse2Poly(centre, cv::Size(cvRound(radius), cvRound(radius)), 0, 0, 360, 4, outline);
      Offer(outline);
    }
  }

  void Offer(const PixelChain& outline) {
    const double score = Score(outline);
    if (score <= best_score_) return;
    best_score_ = score;
    best_ = outline;
  }

  double Score(const PixelChain& outline) const {
    const double area = cv::contourArea(outline);
    const double part = area / static_cast<double>(size_.area());
    if (part < kSmallest || part > kLargest || TouchesBorder(outline, size_)) return 0;
    PixelChain hull;
    cv::convexHull(outline, hull);
    const double solidity = area / cv::contourArea(hull);
    if (solidity < kLeastSolidity) return 0;
    const double around = cv::arcLength(hull, true);
    if (4 * std::numbers::pi * area < kLeastRoundness * around * around) return 0;
    const double edge = EdgeAcross(outline, gx_, gy_);
    return edge < kLeastEdge ? 0 : edge * solidity * solidity * std::sqrt(area);
  }

  cv::Size size_;
  double tool_width_;
  cv::Mat smooth_, gx_, gy_, mask_, half_, opened_, tool_kernel_, small_kernel_;
  double best_score_ = 0;
  PixelChain best_;
};

}  // namespace

Curve FindObject(const cv::Mat& image, double tool_width) {
  const double scale = std::min(1.0, kWorkingEdge / std::max(image.cols, image.rows));
  cv::Mat working = image;
  if (scale < 1) cv::resize(image, working, {}, scale, scale, cv::INTER_AREA);
  const PixelChain outline = Search(working, tool_width * scale).Run();
  if (outline.empty()) {
    throw std::runtime_error(
        "no contour found: no closed region lies completely in the image; give "
        "sense.contour.start");
  }
  // Pixel centres: the working image's (0, 0) is the middle of the first block.
  const double fx = static_cast<double>(image.cols) / working.cols;
  const double fy = static_cast<double>(image.rows) / working.rows;
  Curve curve;
  for (const cv::Point& p : outline) {
    curve.emplace_back(fx * (p.x + 0.5) - 0.5, fy * (p.y + 0.5) - 0.5);
  }
  return curve;
}

}  // namespace palpate
