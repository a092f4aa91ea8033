#include "slave/simulator/fingertips/finger_hand.h"

#include <algorithm>
#include <limits>

namespace palpate::simulation {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr int kExitHalvings = 50;  // largest number of halvings until a point is outside

Vector3d FromAxis(const RigidFinger& finger, const Vector3d& p_F) {
  return p_F - Vector3d(std::clamp(p_F.x(), -finger.length, 0.0), 0, 0);
}

// Reductions of the interval by a third until the deepest place is found.
constexpr int kThirds = 90;
constexpr int kHalvings = 60;  // halvings until the surface is located

double SenseOf(Finger::Motion motion) {
  if (motion == Finger::Motion::kAtRest) return 0;
  return motion == Finger::Motion::kHand ? 1 : -1;
}

// Returns the parameter at which the line p + t d enters the finger; infinity: it does not. The
// distance from a convex body is convex along a line.
double Entry(const RigidFinger& finger, const Vector3d& p_F, const Vector3d& d_F) {
  const auto distance = [&](double t) { return finger.Distance(p_F + t * d_F); };
  double low = -(p_F.norm() + finger.radius + finger.length), high = -low;
  for (int i = 0; i < kThirds; ++i) {
    const double third = (high - low) / 3;
    if (distance(low + third) < distance(high - third)) {
      high -= third;
    } else {
      low += third;
    }
  }
  double inside = 0.5 * (low + high);
  if (distance(inside) >= 0) return std::numeric_limits<double>::infinity();
  double outside = -(p_F.norm() + finger.radius + finger.length);
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (inside + outside);
    (distance(middle) < 0 ? inside : outside) = middle;
  }
  return inside;
}

}  // namespace

double RigidFinger::Distance(const Vector3d& p_F) const noexcept {
  return FromAxis(*this, p_F).norm() - radius;
}

Vector3d RigidFinger::Normal(const Vector3d& p_F) const noexcept {
  const Vector3d outward = FromAxis(*this, p_F);
  const double length_out = outward.norm();
  if (length_out > 0) return outward / length_out;
  return {0, 0, -1};  // on the axis any direction is possible; this is towards the pad
}

Vector3d RigidFinger::PushOut(const Vector3d& p_F, const Vector3d& direction_F) const noexcept {
  if (direction_F.isZero(0)) return p_F - Distance(p_F) * Normal(p_F);
  // The finger is convex, so the line leaves it once.
  double inside = 0, outside = 2 * radius + length;
  for (int i = 0; i < kExitHalvings; ++i) {
    const double middle = 0.5 * (inside + outside);
    (Distance(p_F + middle * direction_F) < 0 ? inside : outside) = middle;
  }
  return p_F + outside * direction_F;
}

Isometry3d FingerHand::PoseOf(std::size_t f, const Vector3d& h_O) const {
  Isometry3d X_OF = fingers[f].X_OF_home;
  X_OF.translation() += fingers[f].sense * h_O;
  return X_OF;
}

std::vector<FingerPlacement> FingerHand::Placements(const Vector3d& lateral_O, double s) const {
  std::vector<FingerPlacement> placements;
  for (std::size_t f = 0; f < fingers.size(); ++f) {
    placements.push_back({PoseOf(f, lateral_O + s * approach_O), fingers[f].sense * approach_O});
  }
  return placements;
}

double FingerHand::FirstTouch(std::size_t f, const Vector3d& lateral_O,
                              const std::vector<Vector3d>& nodes_O) const {
  double first = std::numeric_limits<double>::infinity();
  if (fingers[f].sense == 0) return first;
  const Isometry3d X_FO = PoseOf(f, lateral_O).inverse();
  const Vector3d d_F = -fingers[f].sense * (X_FO.linear() * approach_O);
  for (const Vector3d& p_O : nodes_O) {
    const Vector3d p_F = X_FO * p_O;
    // A point farther from the line than the finger's size cannot be hit.
    const Vector3d beside = p_F - p_F.dot(d_F) * d_F;
    if (beside.norm() > shape.radius + shape.length) continue;
    first = std::min(first, Entry(shape, p_F, d_F));
  }
  return first;
}

FingerHand MakeFingerHand(const Tactile& tactile, const Isometry3d& X_SO) {
  FingerHand hand;
  hand.shape.radius = tactile.finger_radius;
  for (const Finger& finger : tactile.fingers) {
    hand.fingers.push_back({X_SO.inverse() * finger.X_SF, SenseOf(finger.motion)});
  }
  return hand;
}

}  // namespace palpate::simulation
