// Contact of a rigid sphere with an elastic half-space: K. L. Johnson, Contact Mechanics, 1985,
// sections 4.2 (Hertz) and 7.2 (Cattaneo and Mindlin; Mindlin and Deresiewicz for a tangential
// force that reverses).
#pragma once

#include <algorithm>
#include <cmath>

namespace palpate::solids {

// A rigid sphere on a half-space of moduli E = 1 and `nu`, with friction `mu`. Any unit of length.
struct SphereOnHalfSpace {
  double radius = 1, depth = 0, nu = 0.5, mu = 0;

  [[nodiscard]] double G() const { return 0.5 / (1 + nu); }
  [[nodiscard]] double a() const { return std::sqrt(radius * depth); }  // of the contact
  [[nodiscard]] double NormalForce() const {
    return 4.0 / 3 / (1 - nu * nu) * std::sqrt(radius) * std::pow(depth, 1.5);
  }
  // Tangential displacement at which all of it slides.
  [[nodiscard]] double SlidesAt() const {
    return 3 * mu * NormalForce() * (2 - nu) / (16 * a() * G());
  }
  // Tangential force at a displacement that grew from zero.
  [[nodiscard]] double Tangential(double displacement) const {
    const double left = std::max(0.0, 1 - displacement / SlidesAt());
    return mu * NormalForce() * (1 - std::pow(left, 1.5));
  }
  // The tangential force after the displacement grew to `farthest` and then decreased by twice that
  // at most.
  [[nodiscard]] double TangentialBack(double displacement, double farthest) const {
    const double left = std::max(0.0, 1 - (farthest - displacement) / (2 * SlidesAt()));
    return Tangential(farthest) - 2 * mu * NormalForce() * (1 - std::pow(left, 1.5));
  }
  [[nodiscard]] double StickRadius(double tangential) const {
    return a() * std::cbrt(1 - tangential / (mu * NormalForce()));
  }
};

}  // namespace palpate::solids
