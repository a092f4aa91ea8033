// Where a flat membrane rests is a measure for cameras: depths that are wrong by a share, of a
// wrong unit, baseline or focal length, put it that much nearer or farther.
#pragma once

#include <optional>
#include <string_view>

#include <Eigen/Geometry>

#include "slave/scene/scene.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

class MembraneDistance {
 public:
  static constexpr double kTrue = 0.015;  // of the membrane's distance

  // `X_SE`: the camera from which distances are measured. Only flat membranes are checked.
  MembraneDistance(const Scene& scene, const Eigen::Isometry3d& X_SE);

  // Of what was seen at rest, by the first of them: all are flagged, or none.
  void Check(SurfaceObservation* seen);
  void Reset() { farther_.reset(); }

 private:
  static constexpr std::string_view kElsewhere =
      "the membrane at rest is nearer or farther than in the scene: check unit, baseline, fx, fy "
      "and the poses";

  Eigen::Isometry3d X_ES_;
  std::optional<Eigen::Isometry3d> X_EO_;  // of a flat membrane
  std::optional<double> farther_;          // difference from the scene's distance, relative [-]
};

}  // namespace palpate
