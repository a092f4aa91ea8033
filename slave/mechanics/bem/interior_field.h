// Displacement and stress inside a body and on its boundary, from a solution on the boundary.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/bem/bem2d_model.h"

namespace palpate {

struct PointState {
  Eigen::Vector2d displacement{0, 0};                // [m]
  Eigen::Matrix2d stress = Eigen::Matrix2d::Zero();  // [Pa], tension positive
};

class InteriorField {
 public:
  InteriorField(const Bem2dModel& model, BoundaryState state);

  // Somigliana's identity u_i = sum over elements of U_ij t_j - T_ij u_j with exact integrals; the
  // stress by Hooke's law from its exact derivatives, the pressure apart so that nu = 0.5 is as
  // good as any. `p_O` [m] lies inside; nearer to the boundary than an element is long the steps
  // between constant elements show. O(N).
  [[nodiscard]] PointState At(const Eigen::Vector2d& p_O) const;

  // At the midpoint of element `i`: the traction, and the stress along the boundary from the
  // displacements of the neighbours that continue the element without a corner.
  [[nodiscard]] PointState OnBoundary(int i) const;

 private:
  const Bem2dModel& model_;
  BoundaryState state_;
};

}  // namespace palpate
