// The pictures of an evaluation (paper B, figures 10 to 12).
#pragma once

#include <span>
#include <string>

#include "slave/scene/scene.h"
#include "slave/study/clouds/octree_leaves.h"
#include "slave/study/clouds/point_cloud.h"
#include "slave/study/clouds/segmentation.h"
#include "slave/study/shape/cloud_picture.h"

namespace palpate::study {

// The cloud in its colours, or by depth where it has none. PNG.
std::string PictureOfCloud(const PictureView& view, const PointCloud& cloud_S);
// Every region in a colour of its own, what belongs to none in grey.
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
