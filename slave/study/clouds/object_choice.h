// ObjectChoice selects the regions of a cloud that are the object.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slave/study/clouds/segmentation.h"

namespace palpate::study {

struct ObjectHint {
  std::optional<Eigen::Vector3d> at;  // a point on it, frame of the cloud [m]
  // Position of the object in the scene: a box, and the pose of the cloud's frame in the box's
  // frame.
  Eigen::AlignedBox3d box;
  Eigen::Isometry3d X_BD = Eigen::Isometry3d::Identity();
};

struct ObjectChoice {
  std::vector<int> regions;  // none: the segmentation has none
  std::string why;           // for people
  // False: there is no region at the expected position, so the nearest one was used.
  bool sure = true;
};

// With `at` it selects the region of the nearest segmented point. Throws std::invalid_argument: no
// segmented point within 5 cm. Without `at` it selects every region that is mostly inside the box
// (fingers may split the visible object into several), or else the region nearest to the box's
// centre.
ObjectChoice ChooseObject(const PointCloud& cloud, const Segmentation& segmentation,
                          const ObjectHint& hint);

// The points of the chosen regions.
PointCloud Chosen(const PointCloud& cloud, const Segmentation& segmentation,
                  const std::vector<int>& regions);

}  // namespace palpate::study
