#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "slave/scene/scene_loader.h"
#include "slave/scene/sections.h"

namespace palpate {

Eigen::Matrix3d FixedAxesRotation(const Eigen::Vector3d& angles) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd(angles.z(), Vector3d::UnitZ()) * AngleAxisd(angles.y(), Vector3d::UnitY()) *
          AngleAxisd(angles.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

namespace {

struct PoseParts {
  Eigen::Vector3d translation, angles;
};

PoseParts ReadParts(Section& pose, const Eigen::Isometry3d& fallback) {
  return {pose.Vector3("translation", Eigen::Vector3d(fallback.translation())),
          pose.Vector3("rotation")};
}

Eigen::Isometry3d PoseOf(const PoseParts& parts) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translate(parts.translation).rotate(FixedAxesRotation(parts.angles));
  return X;
}

}  // namespace

Eigen::Isometry3d ReadPose(Section& section, const Eigen::Isometry3d& fallback) {
  Section pose = section.Open("pose");
  return pose.present() ? PoseOf(ReadParts(pose, fallback)) : fallback;
}

Eigen::Isometry3d ReadKnownPose(Section& section) {
  if (section.present() &&
      (!section.Has("pose") || section.node()->Find("pose")->children.empty())) {
    section.Refuse("pose", "a map of translation, rotation");
  }
  return ReadPose(section, Eigen::Isometry3d::Identity());
}

Eigen::Isometry3d ReadPlanarPose(Section& section, const Eigen::Isometry3d& fallback) {
  Section pose = section.Open("pose");
  if (!pose.present()) return fallback;
  const PoseParts parts = ReadParts(pose, fallback);
  const bool is_raised = parts.translation.z() != 0;
  const bool is_tilted = parts.angles.x() != 0 || parts.angles.y() != 0;
  if (is_raised) {
    pose.Refuse("translation", "[x, y, 0], because one camera measures the plane z = 0 only");
  }
  if (is_tilted) {
    pose.Refuse("rotation", "[0, 0, angle], because one camera measures the plane z = 0 only");
  }
  return is_raised || is_tilted ? fallback : PoseOf(parts);
}

std::string ScenePose(const Eigen::Isometry3d& X) {
  const Eigen::Matrix3d R = X.linear();
  constexpr double kDegrees = 180 / std::numbers::pi;
  // R = Rz Ry Rx; at Ry = 90 deg, rotations about x and z are about the same axis, so all is
  // assigned to z.
  const double across = std::hypot(R(0, 0), R(1, 0));
  const bool is_gimbal = across < 1e-9;
  const double x = is_gimbal ? 0 : std::atan2(R(2, 1), R(2, 2));
  const double y = std::atan2(-R(2, 0), across);
  const double z = is_gimbal ? std::atan2(-R(0, 1), R(1, 1)) : std::atan2(R(1, 0), R(0, 0));
  const Eigen::Vector3d t = 1e3 * X.translation();
  return fmt::format(
      "pose: {{translation: [{:.6g} mm, {:.6g} mm, {:.6g} mm], rotation: [{:.8g} deg, {:.8g} deg, "
      "{:.8g} deg]}}",
      // + 0.0 avoids printing "-0"
      t.x() + 0.0, t.y() + 0.0, t.z() + 0.0, x * kDegrees + 0.0, y * kDegrees + 0.0,
      z * kDegrees + 0.0);
}

}  // namespace palpate
