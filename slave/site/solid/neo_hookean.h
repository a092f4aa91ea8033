// Nearly incompressible rubber, stretched at rest or not:
//
//   W(F) = mu / 2 (J^(-2/3) tr F^T F - 3) + K / 2 (J - 1)^2,   J = det F
//   mu = E / (2 (1 + nu)),   K = E / (3 (1 - 2 nu))
//
// per volume of the rubber free of stress (Bonet and Wood, Nonlinear Continuum Mechanics, 2008,
// 6.5). Stresses by E. Immutable, hence thread-safe.
#pragma once

#include <Eigen/Core>

namespace palpate::site {

class NeoHookean {
 public:
  // First Piola-Kirchhoff stress, per area at rest, and its derivative over vec(F), column by
  // column.
  struct Stress {
    Eigen::Matrix3d P;
    Eigen::Matrix<double, 9, 9> tangent;
  };

  // -1 < nu < 0.5. `tension` >= 0: stress in the plane of a sheet at rest, none across it.
  NeoHookean(double nu, double tension);

  // At H = F - I with F from the rest, so that small strains keep their digits. False: not J > 0.
  bool At(const Eigen::Matrix3d& H, bool with_tangent, Stress* stress) const;
  // Of the rest: how the rubber was stretched to get there, in the plane and across.
  [[nodiscard]] const Eigen::Vector3d& stretch() const { return stretch_; }

 private:
  bool FromFree(const Eigen::Matrix3d& H, bool with_tangent, Stress* stress) const;
  [[nodiscard]] double Stretched(double along, double across, int component) const;

  double mu_, bulk_;
  Eigen::Vector3d stretch_{1, 1, 1};
};

}  // namespace palpate::site
