// Points as a depth camera measures them.
#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

namespace palpate::study {

// Finite positions [m] in the frame of the camera: pupil at the origin, z forward, x right, y down.
// Black points have no colour; label 0 means no label.
using PointCloud = pcl::PointCloud<pcl::PointXYZRGBL>;

}  // namespace palpate::study
