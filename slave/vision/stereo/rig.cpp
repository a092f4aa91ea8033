#include "slave/vision/stereo/rig.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace palpate {
namespace {

// Squared sine of the angle below which rays are parallel and give no depth [-], about 1e-7 rad.
// [derived: rounding]
constexpr double kParallel = 1e-14;
// Newton steps, of which a few are needed [-]. [derived: they converge quadratically]
constexpr int kMaxSteps = 30;

struct Meeting {
  Eigen::Vector3d p_L;  // between the rays where they are nearest
  double gap = 0;       // distance of the left ray towards AcrossEpipolar [m]
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
  return Meeting{0.5 * (p + q), (q - p).dot(n.normalized())};
}

struct Normal {
  Eigen::Matrix3d curvature;
  Eigen::Vector3d slope;
};

// Gauss-Newton's normal equations of both images' misses [px] at p_L.
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

Distorted Distort(const Lens& lens, const Eigen::Vector2d& ray) noexcept {
  const auto& [k1, k2, p1, p2, k3] = lens.distortion;
  const double x = ray.x(), y = ray.y(), s = x * x + y * y;
  const double radial = 1 + s * (k1 + s * (k2 + s * k3));
  const double slope = k1 + s * (2 * k2 + s * 3 * k3);  // d radial / d s
  Distorted out;
  out.ray = {x * radial + 2 * p1 * x * y + p2 * (s + 2 * x * x),
             y * radial + p1 * (s + 2 * y * y) + 2 * p2 * x * y};
  const double cross = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y;
  out.jacobian << radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x, cross,  //
      cross, radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x;
  return out;
}

bool IsInvertibleOutTo(const Lens& lens, const Eigen::Vector2d& ray) noexcept {
  const double k1 = lens.distortion[0], k2 = lens.distortion[1], k3 = lens.distortion[4];
  const double end = ray.squaredNorm();
  // d(r radial)/dr, a cubic in s = r^2; its lowest place in [0, end] is an end or a turn.
  const auto rises = [&](double s) { return 1 + s * (3 * k1 + s * (5 * k2 + s * 7 * k3)) > 0; };
  if (!rises(end)) return false;
  const double a = 21 * k3, b = 10 * k2, c = 3 * k1;  // its derivative a s^2 + b s + c
  const double root = b * b - 4 * a * c;
  if (root < 0) return true;
  // Both roots without cancellation, and none where a or b is zero.
  const double q = -0.5 * (b + std::copysign(std::sqrt(root), b));
  const double turns[2] = {a != 0 ? q / a : -1.0, q != 0 ? c / q : -1.0};
  return std::all_of(turns, turns + 2, [&](double s) { return !(s > 0 && s < end) || rises(s); });
}

std::optional<Eigen::Vector2d> RayOf(const Lens& lens, const Eigen::Vector2d& p_I) noexcept {
  const Eigen::Vector2d seen((p_I.x() - lens.cx) / lens.fx, (p_I.y() - lens.cy) / lens.fy);
  if (!seen.allFinite()) return std::nullopt;
  // Newton, from the image itself: from below on a barrel's curve, from above on a pincushion's,
  // so it does not pass the end of the invertible range where there is an answer within it.
  Eigen::Vector2d ray = seen;
  for (int i = 0; i < kMaxSteps; ++i) {
    const Distorted at = Distort(lens, ray);
    if (!(at.jacobian.determinant() > 0)) return std::nullopt;
    const Eigen::Vector2d step = at.jacobian.inverse() * (seen - at.ray);
    ray += step;
    if (!ray.allFinite()) return std::nullopt;
    if (step.squaredNorm() <= 1e-28 * (1 + ray.squaredNorm())) break;
  }
  const double miss = (Distort(lens, ray).ray - seen).norm();
  if (!(miss <= 1e-12 * (1 + seen.norm())) || !IsInvertibleOutTo(lens, ray)) return std::nullopt;
  return ray;
}

bool ProjectWithJacobian(const Lens& lens, const Eigen::Vector3d& p_C, Eigen::Vector2d* p_I,
                         Eigen::Matrix<double, 2, 3>* jacobian) noexcept {
  if (!(p_C.z() > 0)) return false;
  const Eigen::Vector2d ray = p_C.head<2>() / p_C.z();
  if (!ray.allFinite() || !IsInvertibleOutTo(lens, ray)) return false;
  const Distorted at = Distort(lens, ray);
  *p_I = {lens.cx + lens.fx * at.ray.x(), lens.cy + lens.fy * at.ray.y()};
  Eigen::Matrix<double, 2, 3> by_place;
  by_place << 1, 0, -ray.x(), 0, 1, -ray.y();
  *jacobian = Eigen::Vector2d(lens.fx, lens.fy).asDiagonal() * at.jacobian * by_place / p_C.z();
  return p_I->allFinite() && jacobian->allFinite();
}

std::optional<Eigen::Vector2d> Project(const Lens& lens, const Eigen::Vector3d& p_C) noexcept {
  Eigen::Vector2d p_I;
  Eigen::Matrix<double, 2, 3> jacobian;
  if (!ProjectWithJacobian(lens, p_C, &p_I, &jacobian)) return std::nullopt;
  return p_I;
}

std::optional<Eigen::Vector2d> CircleCentroidBias(const Lens& lens, const Eigen::Vector3d& p_C,
                                                  const Eigen::Vector3d& n_C,
                                                  double radius) noexcept {
  const double square = radius * radius;
  const Eigen::Vector3d middle =
      p_C.z() * p_C + square * n_C.z() * n_C - square * Eigen::Vector3d::UnitZ();
  if (!(p_C.z() > 0 && middle.z() > 0)) return std::nullopt;
  const auto seen = Project(lens, middle);
  const auto centre = Project(lens, p_C);
  if (!seen || !centre) return std::nullopt;
  return *seen - *centre;
}

Eigen::Vector2d AcrossEpipolar(const StereoRig& rig, const Eigen::Vector2d& left_I) noexcept {
  const Lens& lens = rig.left;
  const Eigen::Vector3d ray((left_I.x() - lens.cx) / lens.fx, (left_I.y() - lens.cy) / lens.fy, 1);
  const Eigen::Vector3d o = -(rig.X_RL.linear().transpose() * rig.X_RL.translation());
  const Eigen::Vector3d n = ray.cross(o);
  const Eigen::Vector2d across(lens.fx * (n.x() - ray.x() * n.z()),
                               lens.fy * (n.y() - ray.y() * n.z()));
  return across.stableNormalized();
}

std::optional<Triangulated> Triangulate(const StereoRig& rig, const Eigen::Vector2d& left_I,
                                        const Eigen::Vector2d& right_I, double sigma_px) noexcept {
  const auto left = RayOf(rig.left, left_I), right = RayOf(rig.right, right_I);
  if (!left || !right) return std::nullopt;
  const auto meeting = NearestOfRays(rig, *left, *right);
  if (!meeting || !(meeting->p_L.z() > 0)) return std::nullopt;

  Triangulated out;
  out.p_L = meeting->p_L;
  out.miss_px = meeting->gap * std::sqrt(rig.left.fx * rig.left.fy) / meeting->p_L.z();
  // Starts at the midpoint between the rays; one or two steps are sufficient.
  Eigen::Matrix3d inverse;
  for (int i = 0; i < kMaxSteps; ++i) {
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
