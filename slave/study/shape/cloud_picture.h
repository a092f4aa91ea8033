// Clouds, surfaces and boxes as images.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/solid_mesh.h"
#include "slave/scene/scene.h"
#include "slave/study/clouds/point_cloud.h"
#include "slave/study/clouds/segmentation.h"
#include "slave/study/shape/shape_score.h"
#include "slave/study/shape/virtual_depth_camera.h"

namespace palpate::study {

using Rgb = std::array<std::uint8_t, 3>;

// Colours that are distinguishable on white, used cyclically.
Rgb RegionColour(int region);

// Looks along z of V, x right, y down, from V's origin.
struct PictureView {
  Eigen::Isometry3d X_SV = Eigen::Isometry3d::Identity();
  double focal = 500;                 // [px]
  Eigen::Vector2d centre{320, 240};   // where z meets the image [px]
  std::array<int, 2> size{640, 480};  // [px]
};
// From the position of `X_SD`, aimed and zoomed so that `points_S` fill the image. `turn` [rad]
// first rotates around their middle, about S's vertical z, or, for a view from above or below, over
// the top. No points: straight ahead.
PictureView ViewOf(const Eigen::Isometry3d& X_SD, std::span<const Eigen::Vector3d> points_S,
                   double turn = 0);

// The cloud in its colours, or by depth where it has none. PNG.
std::string PictureOfCloud(const PictureView& view, const PointCloud& cloud_S);
// Every region in a different colour, points without a region in grey.
std::string PictureOfRegions(const PictureView& view, const PointCloud& cloud_S,
                             const Segmentation& segmentation);
// Fingers in grey, measured points, near ones dark, and the wires of the estimate.
std::string PictureOfShapes(const PictureView& view, std::span<const Eigen::Vector3d> measured_S,
                            const SurfaceMesh& estimate_S, std::span<const Occluder> fingers_S);
// Leaves of the first of LatticeCorners in grey, simulated points green inside them and red
// outside.
std::string PictureOfLeaves(const PictureView& view, std::span<const Eigen::Vector3d> measured_S,
                            std::span<const Eigen::Vector3d> simulated_S, double leaf);

}  // namespace palpate::study
