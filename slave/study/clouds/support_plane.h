// Finds the planes that support an object: table, floor, wall.
#pragma once

#include "slave/study/clouds/point_cloud.h"

namespace palpate::study {

// Noise of a structured-light camera at depth `z` [m]: 1.2 mm + 1.9 mm/m^2 (z - 0.4 m)^2, one sigma
// [m] (Nguyen, Izadi & Lovell 2012, axial noise of the Kinect).
double DepthNoise(double z) noexcept;

// Moves the points in supporting planes from `points` to the result. There are at most three
// planes, each with at least a tenth of the points and an extent of 0.3 m, because smaller planes
// belong to objects. Points are in a plane within `tolerance` [m], or three sigma of DepthNoise if
// that is more. RANSAC with a fixed seed: the same points give the same result. Distant outliers
// change neither tolerance nor extent.
pcl::Indices TakeSupportPlanes(const PointCloud::ConstPtr& cloud, double tolerance,
                               pcl::Indices* points);

}  // namespace palpate::study
