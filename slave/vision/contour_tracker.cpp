#include "slave/vision/contour_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/vision/edge_path.h"

namespace palpate {
namespace {

constexpr int kSettleRounds = 60;  // at start
// Before it settles in the picture itself, in blurred ones: sigma [px], for a start found in the
// picture and for one given by a person.
constexpr std::array kFoundBlurs = {1.5};
constexpr std::array kGivenBlurs = {4.0, 2.0, 1.0};
constexpr int kTrackRounds = 4;    // per picture: the contour may move as many pixels
constexpr int kLeastPicture = 16;  // edge [px]
// How far the tracked contour may change before it is no longer believed.
// Of the area at rest. [-] [tuned: StartsFromACircleOrAPolygonOfTheScene]
constexpr double kLeastArea = 0.5, kMostArea = 1.6;
// Of the length at rest. [-] [tuned: StartsFromACircleOrAPolygonOfTheScene]
constexpr double kMostLength = 1.8;
constexpr double kMostSpacing = 4;      // longest side / mean side
constexpr double kLeastStrength = 0.3;  // of the mean gradient under the points
// At start, the snake against the shape it started from.
constexpr double kLeastClosed = 0.7;    // of an edge around a start that a person gave
constexpr double kGivenIsBetter = 1.1;  // than another around it, in strength and closedness
// Of the outline: 0.64 and more of real embryos, up to 0.61 of flares, rims, rings and torn shells.
// [-] [tuned: StartsFromACircleOrAPolygonOfTheScene]
constexpr double kLeastClear = 0.625;
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

// Where to start: at what was found, or what a person gave and, if that is far off, at the edge
// around it.
std::vector<Curve> StartCurves(const ContourTracking& options, const cv::Mat& first,
                               const GreyFormat& format, double tool_width, bool clockwise_I) {
  if (std::min(first.cols, first.rows) < kLeastPicture) {
    throw std::runtime_error("no contour found: the image is " + std::to_string(first.cols) +
                             " x " + std::to_string(first.rows) + " px: accepted are edges of " +
                             std::to_string(kLeastPicture) + " px or more");
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
  std::vector<Curve> starts = {std::move(start)};
  const bool given = !std::holds_alternative<std::monostate>(options.start);
  if (given && !CrossesItself(starts.front())) {
    EdgePath around = FollowEdgeAround(AsGrey8(first, format), starts.front());
    if (around.closedness > kLeastClosed) starts.push_back(std::move(around.curve));
  }
  for (Curve& curve : starts) {
    // Positive area in axes x right, y down is clockwise to the eye.
    if ((CurveArea(curve) > 0) != clockwise_I) std::reverse(curve.begin(), curve.end());
  }
  return starts;
}

}  // namespace

ContourTracker::ContourTracker(const ContourTracking& options, const cv::Mat& first,
                               const GreyFormat& format, double tool_width, bool clockwise_I)
    : ContourTracker(options, first, format,
                     StartCurves(options, first, format, tool_width, clockwise_I)) {}

ContourTracker::ContourTracker(const ContourTracking& options, const cv::Mat& first,
                               const GreyFormat& format, const std::vector<Curve>& starts)
    : snake_(format, {options.alpha, options.beta, options.gamma}, starts.front(),
             options.control_points) {
  const bool given = !std::holds_alternative<std::monostate>(options.start);
  const cv::Mat grey8 = AsGrey8(first, format);
  std::optional<ContourTracker> best;
  double most = 0;
  std::string why;
  for (std::size_t k = 0; k < starts.size(); ++k) {
    try {
      ContourTracker settled = *this;
      settled.snake_.Restart(Resample(starts[k], options.control_points));
      settled.Begin(first, format,
                    given && k == 0 ? std::span<const double>(kGivenBlurs) : kFoundBlurs);
      const EdgePath edge = MeasureEdge(grey8, settled.settled_);
      const double worth = edge.strength * edge.closedness * (k == 0 ? kGivenIsBetter : 1);
      if (!best || worth > most) best = std::move(settled), most = worth;
    } catch (const std::runtime_error& error) {
      if (why.empty()) why = error.what();
    }
  }
  if (!best) throw std::runtime_error(why);
  *this = *std::move(best);
}

void ContourTracker::Begin(const cv::Mat& first, const GreyFormat& format,
                           std::span<const double> blurs) {
  const double start_area = CurveArea(snake_.points());
  Settle(first, blurs);
  settled_ = snake_.points();
  rest_area_ = CurveArea(settled_);
  rest_length_ = CurveLength(settled_);
  rest_strength_ = snake_.mean_strength();
  const double change = rest_area_ / start_area;
  if (!(change > kLeastSettled && change < kMostSettled) || CrossesItself(settled_) || !IsSound()) {
    throw std::runtime_error("the contour collapsed, intersected itself or left its start (area " +
                             std::to_string(change) +
                             " of the start's): give another sense.contour.start or weights");
  }
  rest_ = RefineContour(first, format, settled_);
  const double wanted = rest_length_ / RefinementOptions().spacing;
  if (static_cast<double>(rest_.size()) < kLeastClear * wanted) {
    throw std::runtime_error(
        "the contour found no clear edge on most of its length: give another "
        "sense.contour.start");
  }
}

// A snake sees no farther than the edge's blur; so the first picture is blurred, much, then less.
void ContourTracker::Settle(const cv::Mat& first, std::span<const double> blurs) {
  cv::Mat blurred;
  for (const double blur : blurs) {
    cv::GaussianBlur(first, blurred, {}, blur);
    snake_.AdaptTo(blurred);
    snake_.Creep(blurred, kSettleRounds);
  }
  snake_.AdaptTo(first);
  snake_.Creep(first, kSettleRounds);
}

bool ContourTracker::IsSound() const noexcept {
  const Curve& points = snake_.points();
  const double area = CurveArea(points) / rest_area_;
  const double length = CurveLength(points);
  double longest = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    longest = std::max(longest, (points[(i + 1) % points.size()] - points[i]).norm());
  }
  return area > kLeastArea && area < kMostArea && length < kMostLength * rest_length_ &&
         longest < kMostSpacing * length / static_cast<double>(points.size()) &&
         snake_.mean_strength() >= kLeastStrength * rest_strength_ &&
         TurningNumber(points) == (rest_area_ > 0 ? 1 : -1);
}

std::span<const Eigen::Vector2d> ContourTracker::Track(const cv::Mat& image) noexcept {
  snake_.Creep(image, kTrackRounds);
  if (IsSound()) return snake_.points();
  Restart();
  return {};
}

}  // namespace palpate
