#include <cmath>

#include <Eigen/LU>

#include "slave/vision/stereo/lens_model.h"

namespace palpate {
namespace {

// Rays less than about 1e-7 rad apart say nothing of depth.
constexpr double kParallel = 1e-14;  // squared sine

struct Meeting {
  Eigen::Vector3d p_L;  // between the rays where they are nearest
  double gap = 0;       // [m]
};

std::optional<Meeting> NearestOfRays(const StereoRig& rig, const Eigen::Vector2d& left,
                                     const Eigen::Vector2d& right) noexcept {
  const Eigen::Matrix3d R_LR = rig.X_RL.linear().transpose();
  const Eigen::Vector3d a = left.homogeneous().normalized();
  const Eigen::Vector3d b = (R_LR * right.homogeneous()).normalized();
  const Eigen::Vector3d o = -(R_LR * rig.X_RL.translation());  // the right camera, in L
  const Eigen::Vector3d n = a.cross(b);
  if (!(n.squaredNorm() > kParallel)) return std::nullopt;
  const double on_left = o.cross(b).dot(n) / n.squaredNorm();
  const double on_right = o.cross(a).dot(n) / n.squaredNorm();
  if (!(on_left > 0) || !(on_right > 0)) return std::nullopt;
  const Eigen::Vector3d p = on_left * a, q = o + on_right * b;
  return Meeting{0.5 * (p + q), (p - q).norm()};
}

struct Normal {
  Eigen::Matrix3d curvature;
  Eigen::Vector3d slope;
};

// Gauss-Newton's normal equations of both pictures' misses [px] at p_L.
std::optional<Normal> Misses(const StereoRig& rig, const Eigen::Vector3d& p_L,
                             const Eigen::Vector2d& left_I,
                             const Eigen::Vector2d& right_I) noexcept {
  Eigen::Vector2d at_left, at_right;
  Eigen::Matrix<double, 2, 3> J_left, J_right;
  if (!ProjectWithJacobian(rig.left, p_L, &at_left, &J_left) ||
      !ProjectWithJacobian(rig.right, rig.X_RL * p_L, &at_right, &J_right)) {
    return std::nullopt;
  }
  J_right *= rig.X_RL.linear();
  return Normal{
      J_left.transpose() * J_left + J_right.transpose() * J_right,
      J_left.transpose() * (left_I - at_left) + J_right.transpose() * (right_I - at_right)};
}

}  // namespace

std::optional<Triangulated> Triangulate(const StereoRig& rig, const Eigen::Vector2d& left_I,
                                        const Eigen::Vector2d& right_I, double sigma_px) noexcept {
  const auto left = RayOf(rig.left, left_I), right = RayOf(rig.right, right_I);
  if (!left || !right) return std::nullopt;
  const auto meeting = NearestOfRays(rig, *left, *right);
  if (!meeting || !(meeting->p_L.z() > 0)) return std::nullopt;

  Triangulated out;
  out.p_L = meeting->p_L;
  out.miss_px = meeting->gap * std::sqrt(rig.left.fx * rig.left.fy) / meeting->p_L.z();
  // From the rays' middle the nearest place in the pictures is a step or two away.
  constexpr int kMostSteps = 8;
  Eigen::Matrix3d inverse;
  for (int i = 0; i < kMostSteps; ++i) {
    const auto normal = Misses(rig, out.p_L, left_I, right_I);
    if (!normal) return std::nullopt;
    bool regular = false;
    double determinant = 0;
    // Scaled, so that the check does not depend on the unit of length.
    const double scale = normal->curvature.trace() / 3;
    Eigen::Matrix3d unit_inverse;
    (normal->curvature / scale)
        .computeInverseAndDetWithCheck(unit_inverse, determinant, regular, 1e-18);
    if (!regular) return std::nullopt;
    inverse = unit_inverse / scale;
    const Eigen::Vector3d step = inverse * normal->slope;
    out.p_L += step;
    if (!out.p_L.allFinite()) return std::nullopt;
    if (step.norm() <= 1e-12 * out.p_L.norm()) break;
  }
  out.covariance = sigma_px * sigma_px * inverse;
  const bool in_front = out.p_L.z() > 0 && (rig.X_RL * out.p_L).z() > 0;
  if (!in_front || !out.covariance.allFinite()) return std::nullopt;
  return out;
}

}  // namespace palpate
