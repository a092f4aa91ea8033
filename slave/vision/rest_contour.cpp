#include "slave/vision/rest_contour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/vision/snake.h"

namespace palpate {
namespace {

constexpr int kSettleRounds = 60;
// Before it settles in the image itself, in blurred ones: sigma, for a start found in the image and
// for one given by a person [px].
constexpr std::array kFoundBlurs = {1.5};
constexpr std::array kGivenBlurs = {4.0, 2.0, 1.0};
constexpr int kLeastImage = 16;  // edge [px] [derived: StartsThatLeadNowhereAreRefused]
// Of the outline: 0.64 and more of real embryos, up to 0.61 of flares, rims, rings and torn shells.
// [-] [tuned: StartsFromACircleOrAPolygonOfTheScene]
constexpr double kLeastClear = 0.625;
constexpr double kGradientBlur = 1.5;  // against noise and fine texture [px]
constexpr double kLeastSettled = 0.4, kMostSettled = 2.0;

Curve CircleCurve(const ContourTracking::Circle& circle) {
  Curve curve;
  for (int k = 0; k < 360; ++k) {
    const double angle = k * std::numbers::pi / 180;
    curve.push_back(circle.centre +
                    circle.radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return curve;
}

// 8 bit grey, for the search at start.
cv::Mat AsGrey8(const cv::Mat& image, const GreyFormat& format) {
  GreyPatch grey;
  format.Read(image, cv::Rect(cv::Point(), image.size()), grey);
  const cv::Mat levels(grey.height, grey.width, CV_16SC1, grey.levels.data());
  cv::Mat grey8;
  levels.convertTo(grey8, CV_8U, 1 / format.levels_per_255());
  return grey8;
}

// Where to start: at what was found, or what a person gave.
Curve StartCurve(const ContourTracking& options, const cv::Mat& first, const GreyFormat& format,
                 double tool_width, bool clockwise_I) {
  if (std::min(first.cols, first.rows) < kLeastImage) {
    throw std::runtime_error("no contour found: the image is " + std::to_string(first.cols) +
                             " x " + std::to_string(first.rows) + " px: accepted are edges of " +
                             std::to_string(kLeastImage) + " px or more");
  }
  Curve start;
  if (const auto* circle = std::get_if<ContourTracking::Circle>(&options.start)) {
    start = CircleCurve(*circle);
  } else if (const auto* polygon = std::get_if<ContourTracking::Polygon>(&options.start)) {
    start = polygon->points;
  } else {
    start = FindObject(AsGrey8(first, format), tool_width);
  }
  for (const Eigen::Vector2d& p : start) {
    const bool inside = p.x() >= 0 && p.y() >= 0 && p.x() <= first.cols - 1 &&
                        p.y() <= first.rows - 1;  // false for NaN
    if (!inside) throw std::runtime_error("sense.contour.start lies outside the image");
  }
  if (start.size() < 3 || std::abs(CurveArea(start)) < options.control_points) {
    throw std::runtime_error("sense.contour.start is too small for " +
                             std::to_string(options.control_points) + " control points");
  }
  // Positive area in axes x right, y down is clockwise to the eye.
  if ((CurveArea(start) > 0) != clockwise_I) std::reverse(start.begin(), start.end());
  return start;
}

// A snake sees no farther than the edge's blur; so the image is blurred, much, then less.
Curve Settle(const ContourTracking& options, const cv::Mat& first, const GreyFormat& format,
             CurveView start, std::span<const double> blurs) {
  Snake snake(format, {options.alpha, options.beta, options.gamma}, start, options.control_points);
  const double start_area = CurveArea(snake.points());
  cv::Mat blurred;
  for (const double blur : blurs) {
    cv::GaussianBlur(first, blurred, {}, blur);
    snake.AdaptTo(blurred);
    snake.Creep(blurred, kSettleRounds);
  }
  snake.AdaptTo(first);
  snake.Creep(first, kSettleRounds);
  const double change = CurveArea(snake.points()) / start_area;
  if (!(change > kLeastSettled && change < kMostSettled) || CrossesItself(snake.points())) {
    throw std::runtime_error("the contour collapsed, intersected itself or left its start (area " +
                             std::to_string(change) +
                             " of the start's): give another sense.contour.start or weights");
  }
  return snake.points();
}

// The gradient, with its magnitude bent to 0 ... 1.
class BentGradient {
 public:
  explicit BentGradient(const cv::Mat& image) {
    cv::Mat smooth;
    cv::GaussianBlur(image, smooth, {}, kGradientBlur);
    cv::Sobel(smooth, gx_, CV_32F, 1, 0, 3, 0.125);
    cv::Sobel(smooth, gy_, CV_32F, 0, 1, 3, 0.125);
    cv::magnitude(gx_, gy_, magnitude_);
    half_ = static_cast<float>(2 * cv::mean(magnitude_)[0] + 0.1);
  }
  // Along the unit vector `n`; 0 outside the image.
  [[nodiscard]] float Along(const Eigen::Vector2d& p, const Eigen::Vector2d& n) const {
    const bool inside =
        p.x() >= 1 && p.y() >= 1 && p.x() < gx_.cols - 1 && p.y() < gx_.rows - 1;  // false for NaN
    if (!inside) return 0;
    const cv::Point at(cvRound(p.x()), cvRound(p.y()));
    const auto g = gx_.at<float>(at) * static_cast<float>(n.x()) +
                   gy_.at<float>(at) * static_cast<float>(n.y());
    return g / (magnitude_.at<float>(at) + half_);
  }

 private:
  cv::Mat gx_, gy_, magnitude_;
  float half_ = 0;
};

Curve MeasureClearEdge(const cv::Mat& first, const GreyFormat& format, CurveView outline) {
  Curve edge = RefineContour(first, format, outline);
  const double wanted = CurveLength(outline) / RefinementOptions().spacing;
  if (static_cast<double>(edge.size()) < kLeastClear * wanted) {
    throw std::runtime_error(
        "the contour found no clear edge on most of its length: give another "
        "sense.contour.start");
  }
  return edge;
}

}  // namespace

RestContour FindRestContour(const ContourTracking& options, const cv::Mat& first,
                            const GreyFormat& format, double tool_width, bool clockwise_I) {
  const bool given = !std::holds_alternative<std::monostate>(options.start);
  const Curve start = StartCurve(options, first, format, tool_width, clockwise_I);
  RestContour contour;
  contour.outline = Settle(options, first, format, start,
                           given ? std::span<const double>(kGivenBlurs) : kFoundBlurs);
  contour.edge = MeasureClearEdge(first, format, contour.outline);
  return contour;
}

EdgeQuality MeasureEdge(const cv::Mat& image, CurveView outline) {
  constexpr int kPoints = 128;     // along the outline
  constexpr double kAnEdge = 0.2;  // bent gradient of an edge, not of texture [-]
  const BentGradient gradient(image);
  const Curve even = Resample(outline, kPoints);
  EdgeQuality best;
  for (const double sign : {-1.0, 1.0}) {
    EdgeQuality quality;
    for (std::size_t i = 0; i < even.size(); ++i) {
      const Eigen::Vector2d t =
          even[(i + 1) % even.size()] - even[(i + even.size() - 1) % even.size()];
      const Eigen::Vector2d n = Eigen::Vector2d(t.y(), -t.x()).stableNormalized();
      const double edge = sign * gradient.Along(even[i], n);
      quality.strength += edge / kPoints;
      quality.closedness += edge > kAnEdge ? 1.0 / kPoints : 0;
    }
    if (quality.strength > best.strength) best = quality;
  }
  return best;
}

}  // namespace palpate
