// A flat membrane rests at the scene's distance from the camera: depths that are wrong by a share,
// of a wrong unit, baseline or focal length, put it that much nearer or farther.
#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "slave/checks/check.h"
#include "slave/checks/points/points_sample.h"
#include "slave/scene/scene.h"

namespace palpate {

class MembraneDistanceCheck final : public Check<PointsSample> {
 public:
  // `X_SE`: the camera from which distances are measured. Only flat membranes are checked.
  MembraneDistanceCheck(const Scene& scene, const Eigen::Isometry3d& X_SE);

  // Of what was seen at rest, by the first of them: all are flagged, or none.
  void Examine(const PointsSample& sample, Findings* findings) noexcept override;
  void Reset() noexcept override { farther_.reset(); }

 private:
  Eigen::Isometry3d X_ES_;
  std::optional<Eigen::Isometry3d> X_EO_;  // of a flat membrane
  std::optional<double> farther_;          // difference from the scene's distance, relative [-]
};

}  // namespace palpate
