// Displacement and stress inside a body and on its boundary, from a solution on the boundary.
#pragma once

#include <array>
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
  // between discontinuous elements show. O(N).
  [[nodiscard]] PointState At(const Eigen::Vector2d& p_O) const;

  // At the midpoint of element `i`: the traction, and the stress along the boundary from the
  // displacements: its own or, where elements are constant, those of the neighbours that continue
  // it without a corner.
  [[nodiscard]] PointState OnBoundary(int i) const;

 private:
  using Modes = std::array<Eigen::Vector2d, kLargestNodeCount>;
  [[nodiscard]] Modes ModesOf(const std::vector<Eigen::Vector2d>& values, int element) const;
  [[nodiscard]] double StretchOf(int i) const;

  const Bem2dModel& model_;
  BoundaryState state_;
};

}  // namespace palpate
