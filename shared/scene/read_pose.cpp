#include "shared/scene/sections.h"

namespace palpate {

Eigen::Matrix3d FixedAxesRotation(const Eigen::Vector3d& angles) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd(angles.z(), Vector3d::UnitZ()) * AngleAxisd(angles.y(), Vector3d::UnitY()) *
          AngleAxisd(angles.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

Eigen::Isometry3d ReadPlanarPose(Section& section, const Eigen::Isometry3d& fallback) {
  Section pose = section.Open("pose");
  if (!pose.present()) return fallback;
  const Eigen::Vector3d translation =
      pose.Vector3("translation", Any(Dimension::kLength), fallback.translation());
  const Eigen::Vector3d angles =
      pose.Vector3("rotation", Any(Dimension::kAngle), Eigen::Vector3d::Zero());
  if (translation.z() != 0) {
    pose.Refuse("translation", "[x, y, 0]: this version sees and models the plane z = 0 only");
  }
  if (angles.x() != 0 || angles.y() != 0) {
    pose.Refuse("rotation", "[0, 0, angle]: this version sees and models the plane z = 0 only");
  }
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translate(translation).rotate(FixedAxesRotation(angles));
  return X;
}

}  // namespace palpate
