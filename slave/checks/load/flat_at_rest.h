// A membrane that is flat in the scene is flat at rest: a bulging or indented one does not respond
// as the plate does.
#pragma once

#include <vector>

#include "slave/checks/load/fit_sample.h"
#include "slave/checks/load/load_limits.h"

namespace palpate {

// Deviation of the points at rest from a plane, frame O. The pose of the plane depends on the
// camera pose and changes no force.
struct RestShape {
  double height = 0, sigma_height = 0;  // of a dome h (1 - (r / a)^2)^2 about the centre [m]
  double rms = 0, sigma_rms = 0;        // rms of the points about a plane, and of their noise [m]
  int points = 0;
};

// `radius` of the membrane about O's origin [m]. Fewer than six points: all zero. O(points).
RestShape RestShapeOf(const std::vector<SurfacePoint>& points_O, double radius) noexcept;

// Returns whether bulge and noise are small compared with `thickness` [m], see
// LoadLimits::kFlatHeight.
bool IsFlat(const RestShape& shape, double thickness) noexcept;

class FlatAtRestCheck final : public Check<FitSample> {
 public:
  // Size of the membrane [m].
  FlatAtRestCheck(double radius, double thickness) : radius_(radius), thickness_(thickness) {}

  void Examine(const FitSample& sample, Findings* findings) noexcept override {
    if (IsFlat(RestShapeOf(sample.points_O, radius_), thickness_)) return;
    findings->Fail(FailedCheck::kRestShape,
                   "the membrane was not flat at rest: bulging, or already in contact");
  }

 private:
  double radius_, thickness_;
};

}  // namespace palpate
