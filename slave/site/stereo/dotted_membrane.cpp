#include "slave/site/stereo/dotted_membrane.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "slave/site/coverage.h"
#include "slave/vision/dots/dot_layout.h"

namespace palpate::site {
namespace {

using Eigen::Vector2d;

constexpr int kCorners = 32;  // of an outline

}  // namespace

DotOutlines OutlinesOf(const PointTracking& points, const MembraneGeometry& membrane) {
  const double radius = points.dot_radius;
  if (!(radius > 0 && radius < membrane.radius)) {
    throw std::invalid_argument(
        fmt::format("sense.points.radius = {:g} m: accepted is > 0, and "
                    "less than the membrane's radius, {:g} m",
                    radius, membrane.radius));
  }
  // An inscribed polygon has less area than its circle.
  const double turn = 2 * std::numbers::pi / kCorners;
  const double corner = radius * std::sqrt(turn / std::sin(turn));
  DotOutlines outlines;
  for (const Vector2d& p_O : DotPlaces(points)) {
    if (!(p_O.norm() + radius < membrane.radius)) {
      throw std::invalid_argument(
          fmt::format("sense.points: the dot at [{:g}, {:g}] m is not wholly on the membrane: "
                      "accepted are dots within {:g} m of its centre",
                      p_O.x(), p_O.y(), membrane.radius - radius));
    }
    auto& outline = outlines.emplace_back();
    for (int k = 0; k < kCorners; ++k) {
      outline.push_back(p_O + corner * Vector2d(std::cos(k * turn), std::sin(k * turn)));
    }
  }
  return outlines;
}

DottedMembrane::DottedMembrane(const MembraneView& view, const DotOutlines& outlines,
                               const Exposure& exposure)
    : view_(view), outlines_(outlines), exposure_(exposure), ground_(view.PlainFace()) {
  exposure_.Blur(ground_);
}

// Blur is linear, and dots do not overlap: blurred coverage is taken off the blurred ground.
const cv::Mat& DottedMembrane::Paint(const Dent& dent) {
  ground_.copyTo(seen_);
  std::vector<Vector2d> outline;
  for (const auto& at_rest : outlines_) {
    outline.clear();
    for (const Vector2d& p_O : at_rest) {
      if (const auto p_I = view_.See(p_O, dent)) outline.push_back(*p_I);
    }
    if (outline.size() < at_rest.size()) continue;
    const cv::Rect window = WindowAround(outline, exposure_.reach() + 1, seen_.size());
    if (window.empty()) continue;
    Coverage coverage(window);
    coverage.Add(outline);
    coverage.Resolve(covered_);
    exposure_.Blur(covered_);
    cv::Mat part = seen_(window);
    part += (kDot - MembraneView::kRubber) * covered_;
  }
  return seen_;
}

}  // namespace palpate::site
