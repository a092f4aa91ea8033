#include "slave/vision/stereo/pair_rig.h"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Lens LensOf(const StereoCameras& cameras) {
  Lens lens;
  lens.fx = lens.fy = cameras.focal;
  lens.cx = 0.5 * (cameras.size[0] - 1);
  lens.cy = 0.5 * (cameras.size[1] - 1);
  lens.size = cameras.size;
  return lens;
}

bool IsInImage(const Lens& lens, const Vector3d& p_C) {
  const auto p_I = Project(lens, p_C);
  return p_I && p_I->x() > 0 && p_I->y() > 0 && p_I->x() < lens.size[0] - 1 &&
         p_I->y() < lens.size[1] - 1;
}

// p_R = X_RL p_L.
Isometry3d Verged(double baseline, double distance) {
  const double half = std::asin(baseline / (2 * distance));
  Isometry3d X_LR = Isometry3d::Identity();
  X_LR.linear() = Eigen::AngleAxisd(-2 * half, Vector3d::UnitY()).toRotationMatrix();
  X_LR.translation() = baseline * Vector3d(std::cos(half), 0, std::sin(half));
  return X_LR.inverse();
}

}  // namespace

StereoRig SimulatedRig(const Scene& scene) {
  if (!scene.sense.Find<StereoCameras>() || !scene.sense.Find<StereoCameras>()->rig.empty()) {
    throw std::invalid_argument(
        "sense.camera: the simulator of a membrane or a textured target expects a simulated "
        "pair");
  }
  const StereoCameras& cameras = *scene.sense.Find<StereoCameras>();
  const Vector3d p_L = cameras.X_SL.inverse() * scene.object.X_SO.translation();
  const double distance = p_L.norm();
  if (!(distance > 0 && distance < 1e6)) {
    throw std::invalid_argument("sense.camera.pose: expected a position away from the object");
  }
  if (!(cameras.baseline < 1.5 * distance)) {
    throw std::invalid_argument(
        fmt::format("sense.camera.pair.baseline = {:g} m: expected less than {:g} m (1.5 times "
                    " the distance to the object)",
                    cameras.baseline, 1.5 * distance));
  }
  StereoRig rig;
  rig.left = rig.right = LensOf(cameras);
  rig.X_RL = Verged(cameras.baseline, distance);
  if (!IsInImage(rig.left, p_L) || !IsInImage(rig.right, rig.X_RL * p_L)) {
    throw std::invalid_argument(
        "sense.camera.pose: the simulator expects a pose from which both cameras see the "
        "origin of the object's frame");
  }
  return rig;
}

}  // namespace palpate
