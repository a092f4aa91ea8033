#include "slave/site/points/dotted_membrane.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "slave/site/coverage.h"
#include "slave/vision/dots/dot_layout.h"

namespace palpate::site {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kCorners = 32;      // of an outline
constexpr double kNearby = 0.05;  // where the tilt is taken, in radii from a dot's middle

}  // namespace

PrintedDots DotsOn(const MembraneGeometry& membrane, const PointTracking& points) {
  const PrintedDots dots{DotPlaces(points), points.dot_radius};
  if (!(dots.radius > 0 && dots.radius < membrane.radius)) {
    throw std::invalid_argument(
        fmt::format("sense.points.radius = {:g} m: accepted is > 0, and "
                    "less than the membrane's radius, {:g} m",
                    dots.radius, membrane.radius));
  }
  for (const Vector2d& p_O : dots.places_O) {
    if (p_O.norm() + dots.radius < membrane.radius) continue;
    throw std::invalid_argument(
        fmt::format("sense.points: the dot at [{:g}, {:g}] m is not wholly on the membrane: "
                    "accepted are dots within {:g} m of its centre",
                    p_O.x(), p_O.y(), membrane.radius - dots.radius));
  }
  return dots;
}

DottedMembrane::DottedMembrane(const MembraneView& view, const PrintedDots& dots,
                               const Exposure& exposure)
    : view_(view), dots_(dots), exposure_(exposure), ground_(view.PlainFace()) {
  exposure_.Blur(ground_);
}

// A polygon with the area of its disc: an inscribed one has less.
bool DottedMembrane::Outline(const Vector2d& p_O, const Dent& dent,
                             std::vector<Vector2d>* outline) const {
  const double nearby = kNearby * dots_.radius, turn = 2 * std::numbers::pi / kCorners;
  const auto along = [&](const Vector2d& way) -> Vector3d {
    return view_.Place(p_O + nearby * way, dent) - view_.Place(p_O - nearby * way, dent);
  };
  const Vector3d x = along({1, 0}).normalized(), n = x.cross(along({0, 1})).normalized();
  const Vector3d y = n.cross(x), middle = view_.Place(p_O, dent);
  const double corner = dots_.radius * std::sqrt(turn / std::sin(turn));
  outline->clear();
  for (int k = 0; k < kCorners; ++k) {
    const Vector3d p = middle + corner * (std::cos(k * turn) * x + std::sin(k * turn) * y);
    const auto p_I = Project(view_.lens, view_.X_CO * p);
    if (!p_I) return false;
    outline->push_back(*p_I);
  }
  return true;
}

// Blur is linear, and dots do not overlap: blurred coverage is taken off the blurred ground.
const cv::Mat& DottedMembrane::Paint(const Dent& dent) {
  ground_.copyTo(seen_);
  std::vector<Vector2d> outline;
  for (const Vector2d& p_O : dots_.places_O) {
    if (!Outline(p_O, dent, &outline)) continue;
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
