// Green's functions of the clamped circular plate at small deflection, in closed form.
//
// Nondimensional: lengths are divided by the plate's radius a, deflections by F a^2 / D for a load
// F, with the rigidity D = E t^3 / (12 (1 - nu^2)). Deflection counts along the load. Source: paper
// C, eq. (2) (after Michell 1902), with the part that is illegible in the scan restored. Loads
// spread over a disc use Pizzetti's mean value theorem, which is exact for biharmonic functions.
#pragma once

#include <Eigen/Core>

namespace palpate::plate {

// A load of one, spread uniformly over a disc inside the plate; radius 0: at a point.
struct Disc {
  Eigen::Vector2d centre{0, 0};  // |centre| + radius <= 1
  double radius = 0;
};

// Deflection at `x`, |x| <= 1, under a load of one at `p`. Zero on the rim. Symmetric in both.
double Deflection(const Eigen::Vector2d& p, const Eigen::Vector2d& x) noexcept;
// Deflection under a load over a disc; exact inside the disc, outside it and on its edge.
double Deflection(const Disc& load, const Eigen::Vector2d& x) noexcept;

}  // namespace palpate::plate
