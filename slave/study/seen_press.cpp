#include "slave/study/seen_press.h"

#include <cmath>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "slave/mechanics/plate/plate_surface.h"
#include "slave/pipeline/points/surface_point_tracker.h"
#include "slave/reference/membrane/pressed_membrane.h"
#include "slave/vision/dots/dot_layout.h"
#include "slave/vision/stereo/rig.h"

namespace palpate::study {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kImages = 5;  // images from rest to full depth; each fit starts from the previous one
constexpr double kStep = 0.2;    // of the full depth, between two solutions of the solid [-]
constexpr double kInView = 0.9;  // visible part of the radius with texture or depth images [-]
// Radii that differ by less, relative to the membrane's radius, share one solution [-]. [derived:
// rounding]
constexpr double kSameRadius = 1e-6;

// Returns the printed dots, or positions spread over a membrane without dots.
std::vector<Vector2d> PlacesOfPoints(const Scene& scene, double radius) {
  const auto* points = scene.sense.Find<PointTracking>();
  if (points != nullptr && points->track == PointTracking::Track::kDots) return DotPlaces(*points);
  std::vector<Vector2d> places;
  for (const Vector3d& p_O : MembraneGrid(radius).nodes) {
    if (p_O.norm() <= kInView * radius) places.emplace_back(p_O.head<2>());
  }
  return places;
}

// Covariances of points at rest, frame O [m^2]; nullopt: not in view.
class Cameras {
 public:
  explicit Cameras(const Scene& scene)
      : pair_(scene.sense.Find<StereoCameras>()),
        depth_(scene.sense.Find<DepthImages>()),
        sigma_px_(scene.sense.Find<PointTracking>()->sigma) {
    if (pair_ == nullptr) return;
    rig_ = RigOf(scene);
    X_LO_ = pair_->X_SL.inverse() * scene.object.X_SO;
  }
  [[nodiscard]] std::optional<Matrix3d> CovarianceAt(const Vector3d& p_O) const {
    if (depth_ != nullptr) return depth_->sigma * depth_->sigma * Matrix3d::Identity();
    const Vector3d p_L = X_LO_ * p_O;
    const auto left = Project(rig_.left, p_L), right = Project(rig_.right, rig_.X_RL * p_L);
    const auto point = left && right ? Triangulate(rig_, *left, *right, sigma_px_) : std::nullopt;
    if (!point) return std::nullopt;
    return X_LO_.linear().transpose() * point->covariance * X_LO_.linear();
  }

 private:
  const StereoCameras* pair_;
  const DepthImages* depth_;
  double sigma_px_;
  StereoRig rig_;
  Eigen::Isometry3d X_LO_ = Eigen::Isometry3d::Identity();
};

std::vector<SurfacePoint> PointsAtRest(const Scene& scene, const MembraneGeometry& membrane) {
  const Cameras cameras(scene);
  std::vector<SurfacePoint> points;
  for (const Vector2d& place : PlacesOfPoints(scene, membrane.radius)) {
    SurfacePoint point;
    point.id = static_cast<int>(points.size());
    point.p_S_rest = {place.x(), place.y(), -membrane.thickness};  // on the inner face
    const auto covariance = cameras.CovarianceAt(point.p_S_rest);
    if (!covariance) continue;
    point.seen = true;
    point.covariance = *covariance;
    points.push_back(point);
  }
  return points;
}

// Returns the solid pressed by the tool at `radius` on the x axis, from rest to full depth;
// nullptr: no equilibrium.
std::shared_ptr<const simulation::MembranePress> PressedAt(double radius, const Scene& scene,
                                                           const PressSpec& question,
                                                           const MembraneGeometry& membrane) {
  simulation::PressedMembrane solid(membrane, scene.object.material, question.width, {radius, 0},
                                    {}, scene.model.prestress,
                                    simulation::FaceOf(scene.tool.value_or(Tool{})));
  for (int step = 1; kStep * step <= 1; ++step) {
    if (!solid.Deepen(kStep * step * question.depth)) return nullptr;
  }
  return std::make_shared<simulation::MembranePress>(solid.press());
}

// `indentation`: at rest.
SeenPress Seen(const std::vector<SurfacePoint>& rest, simulation::Indentation indentation,
               double full_depth) {
  SeenPress seen;
  for (int image = 0; image <= kImages; ++image) {
    indentation.depth = full_depth * image / kImages;
    seen.images_O.push_back(rest);
    for (SurfacePoint& point : seen.images_O.back()) {
      point.p_S =
          point.p_S_rest + simulation::DisplacementOf(indentation, point.p_S_rest.head<2>());
    }
  }
  seen.force = -simulation::ForceOf(indentation);
  return seen;
}

std::vector<SeenPress> Solve(const Scene& scene, const PressSpec& question,
                             const MembraneGeometry& membrane) {
  const std::vector<SurfacePoint> rest = PointsAtRest(scene, membrane);
  // The key is the radius in units of kSameRadius, because a membrane has the same response all
  // around.
  std::map<long, std::shared_ptr<const simulation::MembranePress>> solids;
  std::vector<SeenPress> seen;
  for (const Press& press : question.presses) {
    const Vector2d place_O = press.p_O.head<2>();
    const double radius = place_O.norm();
    auto& solid = solids[std::lround(radius / (kSameRadius * membrane.radius))];
    if (!solid) solid = PressedAt(radius, scene, question, membrane);
    if (!solid) return {};
    const simulation::Indentation indentation{
        .rim = membrane.radius, .place_O = place_O, .parts = {{{solid, radius, 1}, {}}}};
    seen.push_back(Seen(rest, indentation, question.depth));
  }
  return seen;
}

}  // namespace

std::vector<SeenPress> SeePresses(const Scene& scene, const PressSpec& question) {
  const auto* membrane = std::get_if<MembraneGeometry>(&scene.object.geometry);
  if (membrane == nullptr || !scene.tool || !HasStereoOrDepth(scene.sense)) return {};
  try {
    return Solve(scene, question, *membrane);
    // The solid has no solution; the model is used with the depth instead.
  } catch (const std::exception&) {
    return {};
  }
}

}  // namespace palpate::study
