#include "slave/pipeline/points/points_overlay.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <opencv2/imgproc.hpp>
#include <spdlog/fmt/fmt.h>

#include "shared/wire/enum_names.h"
#include "slave/pipeline/base/overlay_text.h"

namespace palpate {
namespace {

const cv::Scalar kSeenColour(80, 200, 80), kLostColour(60, 60, 240), kLoadColour(40, 140, 255);
// Sizes of the drawing: radius of the full-scale ring relative to the image's height [-], largest
// drawn share of full scale [-], step for projecting the direction of a force [m]. [by definition]
constexpr double kRing = 0.1, kMaxShare = 1.5, kShortStep = 1e-3;

// Limits points far outside to coordinates that can be drawn and are still outside.
cv::Point NearestDrawable(const Eigen::Vector2d& p) {
  const Eigen::Vector2d near = p.cwiseMax(-1e4).cwiseMin(1e4);
  return {static_cast<int>(std::lround(near.x())), static_cast<int>(std::lround(near.y()))};
}

std::string ForceText(const PointsOverlay& overlay) {
  if (!overlay.force) return "force unknown";
  return fmt::format("{:.3g} N +- {:.2g}  {}", *overlay.force, overlay.sigma, overlay.validity);
}

double ShareOf(const PointsOverlay& overlay, double full_scale) {
  const bool has_share = overlay.force && *overlay.force > 0 && full_scale > 0;
  return has_share ? std::fmin(kMaxShare, *overlay.force / full_scale) : 0;
}

}  // namespace

PointsOverlay MakePointsOverlay(const SurfacePointTracker& tracker, const SurfaceObservation& seen,
                                const ContactEstimate& estimate) {
  PointsOverlay overlay;
  for (std::size_t i = 0; i < seen.points.size(); ++i) {
    const Eigen::Vector2d p_I = tracker.PlaceInImage(i);
    if (p_I.allFinite()) {
      overlay.seen_I.push_back(p_I);
      continue;
    }
    const bool was_seen = !seen.points[i].p_S.isZero(0);
    const auto last_I = tracker.Project(seen.points[i].p_S);
    if (was_seen && last_I) overlay.lost_I.push_back(*last_I);
  }
  overlay.radius_px = tracker.radius_px();
  overlay.windows = tracker.stage() != "dots";
  overlay.validity = ToString(estimate.validity);
  const bool has_place = seen.found && (estimate.depth > 0 || !estimate.force);
  if (has_place && estimate.validity != Validity::kTrackingLost) {
    overlay.place_I = tracker.Project(estimate.p_S_contact);
  }
  if (!estimate.force) return overlay;
  overlay.force = estimate.force->norm();
  overlay.sigma = estimate.sigma;
  if (!(*overlay.force > 0) || !overlay.place_I) return overlay;
  const auto ahead =
      tracker.Project(estimate.p_S_contact + kShortStep * estimate.force->normalized());
  const auto aside =
      tracker.Project(estimate.p_S_contact + kShortStep * estimate.force->unitOrthogonal());
  if (!ahead || !aside) return overlay;
  // The arrow is foreshortened relative to the length of the same force normal to the line of
  // sight.
  const double full_length = (*aside - *overlay.place_I).norm();
  if (full_length > 0) overlay.along_I = (*ahead - *overlay.place_I) / full_length;
  return overlay;
}

cv::Mat AsImage(const cv::Mat& image) {
  if (image.depth() != CV_16U) return image;
  cv::Mat grey;
  cv::normalize(image, grey, 0, 255, cv::NORM_MINMAX, CV_8U, image > 0);
  return grey;
}

cv::Mat DrawPoints(const cv::Mat& image, const PointsOverlay& overlay, double full_scale) {
  cv::Mat drawn;
  cv::cvtColor(AsImage(image), drawn, cv::COLOR_GRAY2BGR);
  const int radius = std::max(2, static_cast<int>(std::lround(overlay.radius_px)));
  for (const Eigen::Vector2d& p : overlay.seen_I) {
    const cv::Point centre = NearestDrawable(p);
    OnAnyImage(kSeenColour, 1, [&](const cv::Scalar& colour, int thickness) {
      if (overlay.windows) {
        cv::rectangle(drawn, centre - cv::Point(radius, radius), centre + cv::Point(radius, radius),
                      colour, thickness);
      } else {
        cv::circle(drawn, centre, radius + 2, colour, thickness, cv::LINE_AA);
      }
      cv::drawMarker(drawn, centre, colour, cv::MARKER_CROSS, 5, thickness);
    });
  }
  for (const Eigen::Vector2d& p : overlay.lost_I) {
    OnAnyImage(kLostColour, 1, [&](const cv::Scalar& colour, int thickness) {
      cv::drawMarker(drawn, NearestDrawable(p), colour, cv::MARKER_TILTED_CROSS, 2 * radius,
                     thickness, cv::LINE_AA);
    });
  }
  if (overlay.place_I) {
    const double share = ShareOf(overlay, full_scale);
    const double sigma_share = share > 0 ? share * overlay.sigma / *overlay.force : 0;
    const cv::Point place = NearestDrawable(*overlay.place_I);
    const auto ring = [&](double of_force, const cv::Scalar& colour, int thickness) {
      const int radius = static_cast<int>(std::lround(kRing * image.rows * of_force));
      if (radius > 1) cv::circle(drawn, place, radius, colour, thickness, cv::LINE_AA);
    };
    OnAnyImage(kLoadColour, 2, [&](const cv::Scalar& colour, int thickness) {
      cv::drawMarker(drawn, place, colour, cv::MARKER_CROSS, 21, thickness, cv::LINE_AA);
      ring(share, colour, thickness);
    });
    for (const double side : {-1.0, 1.0}) ring(share + side * sigma_share, kLoadColour, 1);
    const Eigen::Vector2d end = *overlay.place_I + 0.2 * image.rows * share * overlay.along_I;
    DrawArrow({overlay.place_I->x(), overlay.place_I->y()}, {end.x(), end.y()},
              0.2 * image.rows * sigma_share * overlay.along_I.norm(), kLoadColour, &drawn);
  }
  DrawText(ForceText(overlay), kLoadColour, &drawn);
  return drawn;
}

}  // namespace palpate
