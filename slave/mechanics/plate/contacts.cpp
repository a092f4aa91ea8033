#include "slave/mechanics/plate/contacts.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "shared/text/text.h"

namespace palpate::plate {
namespace {

constexpr double kSlack = 1e-9;           // of the radius: places on the disc's surface and rim
constexpr double kMinRimDistance = 1e-6;  // smallest distance of moved points from the rim [radii]
constexpr double kPoint = 1e-4;           // smallest radius of a face with a rim [radii]
constexpr double kSamePoint = 1e-7;       // moved points closer than this are identical [radii]

std::string_view WhyNot(const Contact& contact, const Geometry& geometry) {
  const bool moved = contact.kind == Contact::Kind::kDisplacement;
  const double a = geometry.radius;
  if (!contact.p_O.allFinite() || !contact.prescribed_O.allFinite() ||
      !std::isfinite(contact.width)) {
    return "a contact's value is not finite";
  }
  if (contact.width < 0) return "a contact's width is negative";
  if (contact.prescribed_O.x() != 0 || contact.prescribed_O.y() != 0) {
    return "a plate is displaced and loaded along its normal only: x and y must be 0";
  }
  if (moved && std::abs(contact.prescribed_O.z()) > kAbsurd * a) {
    return "a displacement is too large";
  }
  if (std::abs(contact.p_O.z()) > geometry.thickness / 2 + kSlack * a) {
    return "a contact point is off the plate: |z| > thickness / 2";
  }
  const double r = contact.p_O.head<2>().stableNorm() / a;
  if (!(r <= 1 + kSlack)) return "a contact point is off the plate: beyond the rim";
  if (!(r + contact.width / 2 / a <= 1 + kSlack)) return "a contact reaches over the rim";
  if (moved && r > 1 - kMinRimDistance) return "a point on the clamped rim cannot be displaced";
  return {};
}

// Returns whether two contacts conflict: uniform loads may overlap, moved or rigid contacts may
// not.
bool Clash(const Touch& a, const Touch& b) {
  if (!a.is_sought() && !b.is_sought()) return false;
  const double gap = (a.disc.centre - b.disc.centre).norm() - a.disc.radius - b.disc.radius;
  return gap < (a.disc.radius + b.disc.radius > 0 ? -kSlack : kSamePoint);
}

}  // namespace

std::string_view Check(std::span<const Contact> contacts, const Geometry& geometry,
                       std::vector<Touch>* touches) {
  touches->resize(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& contact = contacts[i];
    if (const auto why = WhyNot(contact, geometry); !why.empty()) return why;
    Touch& touch = (*touches)[i];
    touch.kind = contact.kind;
    touch.disc = {contact.p_O.head<2>() / geometry.radius, contact.width / 2 / geometry.radius};
    touch.face = contact.is_rigid && touch.disc.radius >= kPoint ? Face::kRigid : Face::kEven;
    touch.value = -contact.prescribed_O.z() / (touch.moved() ? geometry.radius : 1);
    for (std::size_t j = 0; j < i; ++j) {
      if (Clash(touch, (*touches)[j])) return "a displaced contact overlaps with another contact";
    }
  }
  return {};
}

void RequirePlate(const Geometry& geometry, double young_modulus, double poisson_ratio) {
  RequirePositive("radius", geometry.radius);
  RequirePositive("young_modulus", young_modulus);
  const double thickest = geometry.radius / 10;
  if (!(geometry.thickness > 0 && geometry.thickness <= thickest * (1 + kSlack))) {
    std::ostringstream accepted;
    accepted << "0 < t <= " << thickest << " (radius / 10)";
    RefuseValue("thickness", geometry.thickness, accepted.str());
  }
  if (!(poisson_ratio > -1 && poisson_ratio <= 0.5)) {
    RefuseValue("poisson_ratio", poisson_ratio, "-1 < nu <= 0.5");
  }
}

}  // namespace palpate::plate
