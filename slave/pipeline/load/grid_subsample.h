// Few points instead of many, spread evenly over a round plate: what a fit costs grows with their
// number, what it gains from neighbours that tell the same soon does not.
#pragma once

#include <vector>

#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// One thread; allocation-free after the first call with as many points.
class GridSubsample {
 public:
  static constexpr int kMost = 128;  // points that are taken as they are; beyond, at most so many
  static constexpr int kNone = -1;   // of a square none of whose points is seen

  // `radius` of the plate about the origin of O [m].
  explicit GridSubsample(double radius) : radius_(radius) {}

  // Indices of points on the plate, frame O. Where more than kMost rest there: of each square of a
  // grid over it, the point seen nearest to its middle, or kNone; their number depends on the
  // places at rest alone.
  const std::vector<int>& Of(const std::vector<SurfacePoint>& points_O);

 private:
  struct Square {
    bool has_points = false;
    int nearest = kNone;
    double distance = 0;  // from the middle [squares], squared
  };
  void Add(const SurfacePoint& point, int index);

  double radius_;
  std::vector<int> chosen_;
  std::vector<Square> squares_;
};

}  // namespace palpate
