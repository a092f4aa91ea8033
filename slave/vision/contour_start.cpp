#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/statistics/robust.h"
#include "slave/vision/rest_contour.h"

namespace palpate {
namespace {

// Circles are searched at this size [px]. [tuned: ImagesWithoutAnObjectAreRefused]
constexpr double kCircleEdge = 160;
constexpr int kDirections = 32;
constexpr double kRadiusStep = 1.08, kMinRadius = 0.02;
constexpr double kMinVote = 0.15;  // 1 would be a strong edge all round

struct RoundEdge {
  Eigen::Vector2d centre{0, 0};  // [px]
  double radius = 0;             // [px]
};

struct Vote {
  cv::Point centre;
  double radius = 0, vote = 0;
};

// The gradient with its magnitude compressed to 0 ... 1, so that one strong edge does not outweigh
// many weak ones.
struct BentGradient {
  cv::Mat x, y;  // CV_32F
};
BentGradient Bent(const cv::Mat& image) {
  cv::Mat gx, gy;
  cv::Sobel(image, gx, CV_32F, 1, 0, 3, 0.125);
  cv::Sobel(image, gy, CV_32F, 0, 1, 3, 0.125);
  cv::Mat magnitude;
  cv::magnitude(gx, gy, magnitude);
  const auto half = static_cast<float>(2 * cv::mean(magnitude)[0] + 0.1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const float scale = 1 / (magnitude.at<float>(y, x) + half);
      gx.at<float>(y, x) *= scale;
      gy.at<float>(y, x) *= scale;
    }
  }
  return {gx, gy};
}

struct Rim {
  std::array<cv::Point, kDirections> offsets;
  std::array<cv::Vec2f, kDirections> normals;
  explicit Rim(double radius) {
    for (std::size_t k = 0; k < kDirections; ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / kDirections;
      normals[k] = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
      offsets[k] = {cvRound(radius * normals[k][0]), cvRound(radius * normals[k][1])};
    }
  }
};

// Sums the outward gradient along the rim for the centres `from` to `to` of row `y`, one direction
// at a time so that compilers can vectorise over centres.
void SumAlongRim(const BentGradient& gradient, const Rim& rim, int y, int from, int to,
                 float* sums) {
  std::fill(sums + from, sums + to, 0.0F);
  for (std::size_t k = 0; k < kDirections; ++k) {
    const float* gx = gradient.x.ptr<float>(y + rim.offsets[k].y) + rim.offsets[k].x;
    const float* gy = gradient.y.ptr<float>(y + rim.offsets[k].y) + rim.offsets[k].x;
    const float nx = rim.normals[k][0], ny = rim.normals[k][1];
    for (int x = from; x < to; ++x) sums[x] += gx[x] * nx + gy[x] * ny;
  }
}

// Returns the best radius for every centre.
std::vector<Vote> VoteEverywhere(const BentGradient& gradient) {
  const int cols = gradient.x.cols, rows = gradient.x.rows;
  std::vector<Vote> best(gradient.x.total());
  std::vector<float> sums(static_cast<std::size_t>(cols));
  const double largest = 0.5 * std::min(cols, rows) - 1;
  for (double r = std::max(3.0, kMinRadius * std::max(cols, rows)); r < largest; r *= kRadiusStep) {
    const Rim rim(r);
    const int margin = static_cast<int>(r) + 1;
    // Factor for larger circles, which are less likely.
    const double scale = std::sqrt(r / kCircleEdge * 8);
    for (int y = margin; y < rows - margin; ++y) {
      SumAlongRim(gradient, rim, y, margin, cols - margin, sums.data());
      for (int x = margin; x < cols - margin; ++x) {
        const double vote = std::abs(sums[static_cast<std::size_t>(x)]) / kDirections * scale;
        Vote& here = best[static_cast<std::size_t>(y * cols + x)];
        if (vote > here.vote) here = {{x, y}, r, vote};
      }
    }
  }
  return best;
}

// Returns at most `count` circles that are completely in `image` (8 bit grey, smoothed), best
// first: those along which most of the gradient points outwards, or inwards. Each direction counts
// at most once, independent of the strength of its edge. Every centre and radius (from 2 % of the
// longer edge on, in steps of 8 %) is tested at 160 px: about 20 ms.
std::vector<RoundEdge> FindRoundEdges(const cv::Mat& image, std::size_t count) {
  const double scale = std::min(1.0, kCircleEdge / std::max(image.cols, image.rows));
  cv::Mat working = image;
  if (scale < 1) cv::resize(image, working, {}, scale, scale, cv::INTER_AREA);
  std::vector<Vote> votes = VoteEverywhere(Bent(working));
  std::sort(votes.begin(), votes.end(),
            [](const Vote& a, const Vote& b) { return a.vote > b.vote; });
  std::vector<Vote> kept;
  for (const Vote& vote : votes) {
    if (kept.size() == count || vote.vote < kMinVote) break;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const Vote& other) {
      return cv::norm(vote.centre - other.centre) < 0.15 * other.radius + 1;
    });
    if (!known) kept.push_back(vote);
  }
  std::vector<RoundEdge> circles;
  for (const Vote& vote : kept) {
    circles.push_back({{(vote.centre.x + 0.5) / scale - 0.5, (vote.centre.y + 0.5) / scale - 0.5},
                       vote.radius / scale});
  }
  return circles;
}

using PixelChain = std::vector<cv::Point>;

// Larger images are searched at this size [px]. [tuned: ImagesWithoutAnObjectAreRefused]
constexpr double kWorkingEdge = 480;
// Blur against noise and fine texture [px]. [tuned: ImagesWithoutAnObjectAreRefused]
constexpr double kStartBlur = 1.5;
constexpr int kThresholds = 32;                     // between the darkest and the brightest percent
constexpr double kMinArea = 0.001, kMaxArea = 0.7;  // area, part of the image
// Area / area of the convex hull. [-] [tuned: ImagesWithoutAnObjectAreRefused]
constexpr double kMinSolidity = 0.8;
constexpr double kMinRoundness = 0.35;  // 4 pi area / length^2 of the hull: no bar
constexpr double kMinAgreement = 0.5;   // agreement of the edge's sign along the outline, 0 to 1
constexpr double kMinGradient = 1;      // mean gradient across the outline [grey levels / px]
constexpr std::size_t kCircles = 24;    // circles considered in addition to regions

// Returns the 1 % and 99 % quantiles of the grey levels.
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

// Returns the strength of the edge across the outline, light to dark or dark to light all round.
// Parts with opposite signs cancel, and a strong part counts at most twice the median, so that a
// line that the outline crosses does not make it an object.
double EdgeAcross(const PixelChain& outline, const cv::Mat& gx, const cv::Mat& gy) {
  constexpr std::size_t kSpan = 3;  // points on either side that define the tangent
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
  if (std::abs(agreement) < kMinAgreement) return 0;
  return std::abs(sum) / static_cast<double>(n) * agreement * agreement;
}

class Search {
 public:
  Search(const cv::Mat& image, double tool_width) : size_(image.size()), tool_width_(tool_width) {
    cv::GaussianBlur(image, smooth_, {}, kStartBlur);
    cv::Sobel(smooth_, gx_, CV_32F, 1, 0, 3, 0.125);
    cv::Sobel(smooth_, gy_, CV_32F, 0, 1, 3, 0.125);
    const int cut = std::max(3, 2 * static_cast<int>(std::ceil(0.25 * tool_width)) + 1);
    tool_kernel_ = cv::getStructuringElement(cv::MORPH_ELLIPSE, {cut, cut});
    small_kernel_ = cv::getStructuringElement(cv::MORPH_ELLIPSE, {3, 3});
  }

  // Returns the best outline; empty: none.
  PixelChain Run() {
    const cv::Vec2i range = Percentiles(smooth_);
    for (int k = 1; k < kThresholds; ++k) {
      const double level = range[0] + (range[1] - range[0]) * (k / double{kThresholds});
      for (const int type : {cv::THRESH_BINARY, cv::THRESH_BINARY_INV}) {
        cv::threshold(smooth_, mask_, level, 255, type);
        Consider(mask_, small_kernel_, 1);
        // Removes regions that are no wider than the tool. The image has half its size, because
        // such a wide kernel is expensive.
        cv::resize(mask_, half_, (mask_.size() + cv::Size(1, 1)) / 2, 0, 0, cv::INTER_NEAREST);
        Consider(half_, tool_kernel_, 2);
      }
    }
    ConsiderCircles();
    return best_;
  }

 private:
  // Evaluates the regions of `mask`, one pixel of which is `scale` image pixels wide.
  void Consider(const cv::Mat& mask, const cv::Mat& kernel, int scale) {
    cv::morphologyEx(mask, opened_, cv::MORPH_OPEN, kernel);
    std::vector<PixelChain> outlines;
    cv::findContours(opened_, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    for (PixelChain& outline : outlines) {
      for (cv::Point& p : outline) p *= scale;
      Offer(outline);
    }
  }

  // Considers circles, because embryos that touch each other or their bed are not separate regions,
  // but round.
  void ConsiderCircles() {
    for (const RoundEdge& circle : FindRoundEdges(smooth_, kCircles)) {
      if (circle.radius <= tool_width_) continue;  // fits the tool itself
      PixelChain outline;
      cv::ellipse2Poly(cv::Point(cvRound(circle.centre.x()), cvRound(circle.centre.y())),
                       cv::Size(cvRound(circle.radius), cvRound(circle.radius)), 0, 0, 360, 4,
                       outline);
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
    if (part < kMinArea || part > kMaxArea || TouchesBorder(outline, size_)) return 0;
    PixelChain hull;
    cv::convexHull(outline, hull);
    const double solidity = area / cv::contourArea(hull);
    if (solidity < kMinSolidity) return 0;
    const double around = cv::arcLength(hull, true);
    if (4 * std::numbers::pi * area < kMinRoundness * around * around) return 0;
    const double edge = EdgeAcross(outline, gx_, gy_);
    return edge < kMinGradient ? 0 : edge * solidity * solidity * std::sqrt(area);
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
  // Converts pixel centres: (0, 0) of the reduced image is the centre of the first block.
  const double fx = static_cast<double>(image.cols) / working.cols;
  const double fy = static_cast<double>(image.rows) / working.rows;
  Curve curve;
  for (const cv::Point& p : outline) {
    curve.emplace_back(fx * (p.x + 0.5) - 0.5, fy * (p.y + 0.5) - 0.5);
  }
  return curve;
}

}  // namespace palpate
