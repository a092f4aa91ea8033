// Contacts on a clamped circular plate, checked and nondimensional: what both plate models accept.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/plate/green.h"

namespace palpate::plate {

// Frame O: origin at the plate's centre, z along the outward normal, so that a press is along -z.
struct Geometry {
  double radius = 0;     // a [m]
  double thickness = 0;  // t [m]
};

// One contact; deflections and forces count along the press, -z.
struct Touch {
  Contact::Kind kind = Contact::Kind::kDisplacement;
  Disc disc;         // by the radius a
  double value = 0;  // prescribed deflection by a, or load [N]
};

// Turns contacts into `touches` (resized; no allocation once it was as large). Empty if all are
// possible, else why not: a value not finite; across the normal; a place off the disc; a patch over
// the rim; a moved place on the rim, where nothing moves; overlapping patches of which one is
// moved; deflections beyond 1e6 radii.
std::string_view Check(std::span<const Contact> contacts, const Geometry& geometry,
                       std::vector<Touch>* touches);

// Throws std::invalid_argument: radius, thickness or modulus not positive and finite, thickness
// beyond radius / 10, nu outside -1 < nu <= 0.5.
void RequirePlate(const Geometry& geometry, double young_modulus, double poisson_ratio);
void RequirePositive(const char* name, double value);

}  // namespace palpate::plate
