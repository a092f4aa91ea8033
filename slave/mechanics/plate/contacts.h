// Checked, nondimensional contacts on a clamped circular plate, for both plate models.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/plate/pressed_places.h"

namespace palpate::plate {

// Frame O: origin at the plate's centre, z along the outward normal; an indentation is along -z.
struct Geometry {
  double radius = 0;     // a [m]
  double thickness = 0;  // t [m]
};

// Deflections beyond it are no answer [radii].
inline constexpr double kAbsurd = 1e6;

// One contact; deflections and forces are positive along -z.
struct Touch {
  Contact::Kind kind = Contact::Kind::kDisplacement;
  Disc disc;  // in units of the radius a
  Face face = Face::kEven;
  double value = 0;  // prescribed deflection in units of a, or load [N]

  [[nodiscard]] bool moved() const { return kind == Contact::Kind::kDisplacement; }
  [[nodiscard]] bool is_rigid() const { return face == Face::kRigid; }
  // Returns whether the solution determines the forces on its places, or the distribution of its
  // load.
  [[nodiscard]] bool is_sought() const { return moved() || is_rigid(); }
  [[nodiscard]] bool IsAt(const Touch& other) const {
    return kind == other.kind && face == other.face && disc.centre == other.disc.centre &&
           disc.radius == other.disc.radius;
  }
};

// Converts contacts to `touches`, which is resized; it allocates only if it grows. Returns empty
// text if all contacts are possible, else the reason: a value that is not finite; a component
// across the normal; a point off the disc; a contact over the rim; a displaced point on the rim;
// overlapping contacts of which one is displaced or rigid; deflections beyond 1e6 radii. A rigid
// face of less than 1e-4 radii presses as an even one.
std::string_view Check(std::span<const Contact> contacts, const Geometry& geometry,
                       std::vector<Touch>* touches);

// Throws std::invalid_argument: radius, thickness or modulus not positive and finite, thickness
// beyond radius / 10, nu outside -1 < nu <= 0.5.
void RequirePlate(const Geometry& geometry, double young_modulus, double poisson_ratio);

}  // namespace palpate::plate
