// Finds the planes that support an object: table, floor, wall.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

namespace palpate::study {

// Noise of a structured-light camera at depth `z` [m]: 1.2 mm + 1.9 mm/m^2 (z - 0.4 m)^2, one sigma
// [m] (Nguyen, Izadi & Lovell 2012, axial noise of the Kinect).
double DepthNoise(double z) noexcept;

struct SupportPlaneOptions {
  double tolerance = 0.006;  // of a point [m]; three sigma of DepthNoise where that is more, at no
                             // more than twice the points' median depth
  double extent = 0.3;  // smaller planes belong to objects [m]; four sigma of the spread across
                        // their longer direction, of points no farther than three times the
                        // median distance from their middle
  double share = 0.1;   // of all points that must lie in it
  int planes = 3;       // largest number of planes
};

// Points in supporting planes: the largest plane, then the largest of the rest. Frame: the
// camera's, z forward. Found by RANSAC with a fixed seed: the same points give the same result.
// Distant outliers change neither tolerance nor extent.
std::vector<bool> InSupportPlanes(std::span<const Eigen::Vector3d> points,
                                  const SupportPlaneOptions& options);

}  // namespace palpate::study
