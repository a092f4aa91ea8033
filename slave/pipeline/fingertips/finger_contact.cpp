#include "slave/pipeline/fingertips/finger_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kSlip = 2e-3;  // [m]
constexpr double kAnywhere = std::numeric_limits<double>::infinity();

}  // namespace

double DepthBelow(const SurfaceContact& surface, const Isometry3d& X_OF, double radius) noexcept {
  double deepest = -kAnywhere;
  for (const double behind : {0.0, 1.0, 2.0}) {
    const auto place = surface.Find(X_OF * Vector3d(-behind * radius, 0, 0), kAnywhere);
    if (!place) continue;
    const double below = place->inside ? place->distance : -place->distance;
    deepest = std::max(deepest, radius + below);
  }
  return deepest;
}

double DepthUnderFinger(const Isometry3d& X_OF, double radius, const Vector3d& p_O,
                        const Vector3d& n_O) noexcept {
  const Vector3d axis = X_OF.linear().col(0);
  const Vector3d from_centre = p_O - X_OF.translation();
  const double behind = std::min(0.0, axis.dot(from_centre));  // along the cylinder
  const Vector3d e = from_centre - behind * axis;
  const double height = n_O.dot(e);
  const double reach2 = radius * radius - (e.squaredNorm() - height * height);
  return reach2 >= 0 ? height + std::sqrt(reach2) : -radius;
}

FingerContact::FingerContact(const Tactile& tactile)
    : radius_(tactile.finger_radius),
      gate_(tactile.gate),
      holds_(tactile.hold == Tactile::Hold::kDisplacement) {
  contact_.width = tactile.patch;
  contact_.wants_stiffness = false;
}

void FingerContact::EndContact() noexcept {
  has_place_ = has_force_ = acts_ = is_beyond_model_ = false;
  misplaced_ = {};
  slide_.reset();
}

void FingerContact::Update(const SurfaceContact& surface, const Isometry3d& X_OF,
                           const FingerTouch& touch, const Limits& limits) noexcept {
  acts_ = has_force_ = is_beyond_model_ = false;
  misplaced_ = {};
  const auto centre = surface.Find(X_OF.translation(), kAnywhere);
  if (centre && centre->inside && centre->distance > radius_) {
    KeepPlace(X_OF, touch, limits.largest_force);
    misplaced_ = "the pose puts the fingertip inside the object";
    return;
  }
  if (slide_ && !(DepthOf(X_OF) > 0)) slide_.reset();
  const bool stays = holds_ && has_place_ && DepthOf(X_OF) > 0;
  if (!touch.touching && !stays) {
    EndContact();
    if (centre && centre->inside) {
      misplaced_ = "the pose puts the fingertip inside the object, but no force is measured";
    }
    return;
  }
  if (touch.touching && !FindPlace(surface, X_OF, touch) && !stays) {
    EndContact();
    misplaced_ = "the fingertip is in contact, but no surface is within the gate";
    return;
  }
  if (touch.touching) TakeForce(X_OF, touch, limits.largest_force);
  const double depth = holds_ ? DepthOf(X_OF) : 0;
  if (!(depth > 0)) return ActByForce();
  if (limits.has_friction && !slide_) slide_ = {X_OF.inverse() * place_.p_O, place_};
  ActByDisplacement(X_OF, depth);
}

// A pose deeper than a radius behind the surface is rejected. A force that continues there, as on
// very soft objects, acts at its last place.
void FingerContact::KeepPlace(const Isometry3d& X_OF, const FingerTouch& touch,
                              double largest_force) noexcept {
  if (!touch.touching || !has_place_) return EndContact();
  TakeForce(X_OF, touch, largest_force);
  ActByForce();
}

bool FingerContact::FindPlace(const SurfaceContact& surface, const Isometry3d& X_OF,
                              const FingerTouch& touch) noexcept {
  if (!touch.place.usable()) return has_place_;
  const Vector3d p_O = X_OF * touch.place.p_F;
  Vector3d rest_O = p_O;
  if (has_place_) {
    const Vector3d way = p_O - found_from_O_;
    const Vector3d along = way - place_.n_O.dot(way) * place_.n_O;
    if (along.norm() <= kSlip) return true;
    rest_O = place_.p_O + along;
  }
  const auto found = surface.Find(rest_O, gate_);
  if (!found) return false;
  has_place_ = true;
  found_from_O_ = p_O;
  place_ = *found;
  return true;
}

Vector3d FingerContact::WayOf(const Isometry3d& X_OF) const noexcept {
  if (!slide_) return Vector3d::Zero();
  const Vector3d way = X_OF * slide_->p_F - slide_->from.p_O;
  const Vector3d& n_O = slide_->from.n_O;
  return way - n_O.dot(way) * n_O;
}

// A slide counts from the plane of the first touch, because the model knows where its surface is.
double FingerContact::DepthOf(const Isometry3d& X_OF) const noexcept {
  const TouchedPlace& at = slide_ ? slide_->from : place_;
  return DepthUnderFinger(X_OF, radius_, at.p_O + WayOf(X_OF), at.n_O);
}

void FingerContact::ActByDisplacement(const Isometry3d& X_OF, double depth) noexcept {
  const TouchedPlace& at = slide_ ? slide_->from : place_;
  contact_.kind = Contact::Kind::kDisplacement;
  contact_.p_O = at.p_O;
  contact_.element = at.triangle;
  contact_.prescribed_O = WayOf(X_OF) - depth * at.n_O;
  acts_ = true;
}

// A fingertip cannot pull, although its network may report a pull.
void FingerContact::TakeForce(const Isometry3d& X_OF, const FingerTouch& touch,
                              double largest_force) noexcept {
  has_force_ = touch.force_F.has_value();
  if (!has_force_) return;
  force_O_ = X_OF.linear() * *touch.force_F;
  force_O_ -= std::max(0.0, place_.n_O.dot(force_O_)) * place_.n_O;
  is_beyond_model_ = !(force_O_.norm() <= largest_force);
  has_force_ = !is_beyond_model_;
}

void FingerContact::ActByForce() noexcept {
  acts_ = has_place_ && has_force_;
  slide_.reset();
  contact_.kind = Contact::Kind::kForce;
  contact_.p_O = place_.p_O;
  contact_.element = place_.triangle;
  contact_.prescribed_O = has_force_ ? force_O_ : Vector3d::Zero();
}

}  // namespace palpate
