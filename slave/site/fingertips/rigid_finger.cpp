#include "slave/site/fingertips/rigid_finger.h"

#include <algorithm>

namespace palpate::site {
namespace {

using Eigen::Vector3d;

constexpr int kHalvings = 50;

Vector3d FromAxis(const RigidFinger& finger, const Vector3d& p_F) {
  return p_F - Vector3d(std::clamp(p_F.x(), -finger.length, 0.0), 0, 0);
}

}  // namespace

double RigidFinger::Distance(const Vector3d& p_F) const noexcept {
  return FromAxis(*this, p_F).norm() - radius;
}

Vector3d RigidFinger::Normal(const Vector3d& p_F) const noexcept {
  const Vector3d outward = FromAxis(*this, p_F);
  const double length_out = outward.norm();
  if (length_out > 0) return outward / length_out;
  return {0, 0, -1};  // on the axis the pad is as good a way out as any
}

Vector3d RigidFinger::PushOut(const Vector3d& p_F, const Vector3d& direction_F) const noexcept {
  if (direction_F.isZero(0)) return p_F - Distance(p_F) * Normal(p_F);
  // The finger is convex: along the line it is left once.
  double inside = 0, outside = 2 * radius + length;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (inside + outside);
    (Distance(p_F + middle * direction_F) < 0 ? inside : outside) = middle;
  }
  return p_F + outside * direction_F;
}

}  // namespace palpate::site
