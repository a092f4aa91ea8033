#include "slave/pipeline/camera/register_object.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "slave/checks/camera/camera_limits.h"
#include "slave/vision/closed_curve.h"
#include "slave/vision/contour_registration.h"

namespace palpate {
namespace {

using Limits = CameraLimits;

constexpr double kScaleSigmas = 3;
constexpr double kOtherObject = 0.3;  // relative difference in size from which it is another object

// Converts a loop in S to an outline in O.
Outline ToOutline(const std::vector<Eigen::Vector2d>& loop_S, const Eigen::Isometry3d& X_SO) {
  const Eigen::Isometry3d X_OS = X_SO.inverse();
  Outline outline;
  for (const Eigen::Vector2d& p : loop_S) {
    outline.outer.emplace_back((X_OS * Eigen::Vector3d(p.x(), p.y(), 0)).head<2>());
  }
  return outline;
}

void RequireCredible(const Scene& scene, const OutlineFit& fit, std::size_t points) {
  const auto refuse = [&](const std::string& why) {
    throw std::runtime_error(fmt::format("{}: object.geometry: {}", scene.file.string(), why));
  };
  const double larger = fit.scale - 1;
  const double least = std::max(Limits::kMaxScale, kScaleSigmas * fit.scale_sigma);
  if (std::abs(larger) > least && std::abs(larger) < kOtherObject) {
    refuse(
        fmt::format("the object in the first image is {:.1f} % {} than in the scene: expected "
                    "{:g} %: check camera.pixel ({:g} um would fit) and the sizes",
                    100 * std::abs(larger), larger > 0 ? "larger" : "smaller",
                    100 * Limits::kMaxScale, 1e6 * scene.sense.Find<Camera>()->pixel / fit.scale));
  }
  if (!fit.found) {
    refuse(
        fmt::format("the outline in the first image does not fit it ({} of {} contour points "
                    "agree): check object.pose, camera.pixel and sense.contour.start",
                    fit.inliers, points));
  }
  if (fit.rms_px > Limits::kMaxResidual) {
    refuse(
        fmt::format("the outline in the first image deviates from it by {:.1f} px rms: expected "
                    "{:g} px: check its shape and sense.contour.start",
                    fit.rms_px, Limits::kMaxResidual));
  }
}

Registration FromImage(const Scene& scene, CurveView contour_I, const CameraView& view) {
  const Curve smooth_I = Smoothed(contour_I, scene.sense.Find<ContourTracking>()->control_points);
  const std::vector<Eigen::Vector2d> loop_S = ToSlave(smooth_I, view);
  Registration found;
  found.X_SO = scene.object.X_SO;
  // The origin of O is the centre of the detected outline, so that `fixed: arc` refers to it.
  found.X_SO.translation().head<2>() = Centroid(loop_S);
  found.seen = std::make_shared<const Outline>(ToOutline(loop_S, found.X_SO));
  found.measured = true;
  found.points = static_cast<int>(contour_I.size());
  const OutlineFit fit = FitOutline(*found.seen, found.X_SO, contour_I, view);
  found.rms_px = fit.rms_px;
  found.sigma = fit.sigma_px * view.pixel();
  return found;
}

}  // namespace

Registration RegisterObject(const Scene& scene, CurveView contour_I, const CameraView& view,
                            ObjectPlace place) {
  if (std::holds_alternative<ImageContourGeometry>(scene.object.geometry)) {
    return FromImage(scene, contour_I, view);
  }
  Registration found;
  found.X_SO = scene.object.X_SO;
  if (contour_I.empty()) return found;
  const Outline outline = OutlineOf(scene.object.geometry);
  if (place == ObjectPlace::kAnywhere) {
    const Eigen::Vector2d c_O = Centroid(outline.outer);
    const Eigen::Vector3d c_S = found.X_SO * Eigen::Vector3d(c_O.x(), c_O.y(), 0);
    found.X_SO.translation().head<2>() += Centroid(ToSlave(contour_I, view)) - c_S.head<2>();
  }
  const OutlineFit fit = FitOutline(outline, found.X_SO, contour_I, view);
  RequireCredible(scene, fit, contour_I.size());
  found.measured = true;
  found.X_SO = fit.X_SO;
  found.rms_px = fit.rms_px;
  found.points = fit.inliers;
  found.sigma = fit.sigma_px * view.pixel();
  return found;
}

}  // namespace palpate
