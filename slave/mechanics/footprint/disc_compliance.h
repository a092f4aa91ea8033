// Compliance of a disc on an elastic half-space: the part that a mesh coarser than the contact
// lacks.
#pragma once

#include <Eigen/Core>

namespace palpate {

// Displacement by force, times Young's modulus and the disc's radius [-].
struct DiscCompliance {
  double normal = 0, across = 0;  // along the surface's normal; along the surface

  // The compliance in components; `n`: the unit normal.
  [[nodiscard]] Eigen::Matrix3d Around(const Eigen::Vector3d& n) const {
    return across * Eigen::Matrix3d::Identity() + (normal - across) * n * n.transpose();
  }
};

// Compliance of a bonded rigid disc: normal by Spence (1968); tangential by Bycroft (1956), in
// which the normal traction vanishes only on average (exact at nu = 1/2).
DiscCompliance OfBondedDisc(double poisson_ratio) noexcept;
// Compliance of a disc that slides: Boussinesq's flat punch; none across.
DiscCompliance OfSlidingDisc(double poisson_ratio) noexcept;
// Mean displacement under an even load: Johnson, Contact Mechanics, 3.4 and 3.6.
DiscCompliance OfEvenLoad(double poisson_ratio) noexcept;

}  // namespace palpate
