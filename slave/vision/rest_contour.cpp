#include "slave/vision/rest_contour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "slave/vision/edge_path.h"
#include "slave/vision/snake.h"

namespace palpate {
namespace {

constexpr int kSettleRounds = 60;
// Sigmas of the blurred images in which the snake settles before the original one [px]: for a start
// detected in the image and for one given by a person.
constexpr std::array kFoundBlurs = {1.5};
constexpr std::array kGivenBlurs = {4.0, 2.0, 1.0};
constexpr int kMinImage = 16;  // edge [px]
// Largest ratio of the image's sides: the search reduces the longer one to 160 px, so the shorter
// one has 16.
constexpr int kMaxRatio = 10;
// Limits for the snake at the start relative to its start curve.
// Smallest closedness of an edge around a start given by a person.
constexpr double kMinStartClosed = 0.7;
// Factor by which the given curve may be weaker than another one around it, in strength and
// closedness.
constexpr double kGivenIsBetter = 1.1;
// Roundness of the outline: 0.64 and more of real embryos, up to 0.61 of flares, rims, rings and
// torn shells.
// [-] [tuned: StartsFromAPolygonOfTheScene]
constexpr double kMinClear = 0.625;
constexpr double kMinSettled = 0.4, kMaxSettled = 2.0;

// Returns an 8-bit grey image for the search at the start.
cv::Mat AsGrey8(const cv::Mat& image, const GreyFormat& format) {
  GreyPatch grey;
  format.Read(image, cv::Rect(cv::Point(), image.size()), grey);
  const cv::Mat levels(grey.height, grey.width, CV_16SC1, grey.levels.data());
  cv::Mat grey8;
  levels.convertTo(grey8, CV_8U, 1 / format.levels_per_255());
  return grey8;
}

// Returns the start curves: the detected one, or the one given by a person and, if that is
// inaccurate, the edge around it.
std::vector<Curve> StartCurves(const ContourTracking& options, const cv::Mat& first,
                               const GreyFormat& format, double tool_width, bool clockwise_I) {
  const auto [shorter, longer] = std::minmax(first.cols, first.rows);
  if (shorter < kMinImage || longer > kMaxRatio * shorter) {
    throw std::runtime_error("no contour found: the image is " + std::to_string(first.cols) +
                             " x " + std::to_string(first.rows) + " px: expected edges of " +
                             std::to_string(kMinImage) + " px or more, none longer than " +
                             std::to_string(kMaxRatio) + " times the other");
  }
  const bool given = !options.start.empty();
  Curve start = given ? options.start : FindObject(AsGrey8(first, format), tool_width);
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
  if (given && !CrossesItself(starts.front())) {
    EdgePath around = FollowEdgeAround(AsGrey8(first, format), starts.front());
    if (around.closedness > kMinStartClosed) starts.push_back(std::move(around.curve));
  }
  for (Curve& curve : starts) {
    // With x to the right and y down a positive area is clockwise as displayed.
    if ((CurveArea(curve) > 0) != clockwise_I) std::reverse(curve.begin(), curve.end());
  }
  return starts;
}

// A snake is attracted only within the blur of an edge, so the image is blurred, first strongly,
// then less.
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
  if (!(change > kMinSettled && change < kMaxSettled) || CrossesItself(snake.points())) {
    throw std::runtime_error("the contour collapsed, intersected itself or left its start (area " +
                             std::to_string(change) +
                             " of the start's): give another sense.contour.start or weights");
  }
  return snake.points();
}

Curve MeasureClearEdge(const cv::Mat& first, const GreyFormat& format, CurveView outline) {
  Curve edge = RefineContour(first, format, outline);
  const double wanted = CurveLength(outline) / RefinementOptions().spacing;
  if (static_cast<double>(edge.size()) < kMinClear * wanted) {
    throw std::runtime_error(
        "the contour found no clear edge on most of its length: give another "
        "sense.contour.start");
  }
  return edge;
}

}  // namespace

RestContour FindRestContour(const ContourTracking& options, const cv::Mat& first,
                            const GreyFormat& format, double tool_width, bool clockwise_I) {
  const std::vector<Curve> starts = StartCurves(options, first, format, tool_width, clockwise_I);
  const bool given = !options.start.empty();
  const cv::Mat grey8 = AsGrey8(first, format);
  RestContour best;
  double most = -1;
  std::string why;
  for (std::size_t k = 0; k < starts.size(); ++k) {
    const bool by_person = given && k == 0;
    try {
      Curve outline = Settle(options, first, format, starts[k],
                             by_person ? std::span<const double>(kGivenBlurs) : kFoundBlurs);
      Curve edge = MeasureClearEdge(first, format, outline);
      const EdgePath path = MeasureEdge(grey8, outline);
      const double worth = path.strength * path.closedness * (k == 0 ? kGivenIsBetter : 1);
      if (worth > most) best = {std::move(outline), std::move(edge)}, most = worth;
    } catch (const std::runtime_error& error) {
      if (why.empty()) why = error.what();
    }
  }
  if (best.outline.empty()) throw std::runtime_error(why);
  return best;
}

}  // namespace palpate
