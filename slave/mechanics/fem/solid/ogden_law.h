// Ogden's elastic energy of the stretches at equal volume, a_k any exponent but zero:
//
//   A = sum over k of 2 mu_k / a_k^2 (b1^a_k + b2^a_k + b3^a_k - 3),   b_i = l_i J^(-1/3)
//
// Stresses in units of Young's modulus; sum mu_k is the shear modulus at rest. One term of exponent
// 2 is the neo-Hookean law, 2 and -2 are Mooney and Rivlin's.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/scene/scene.h"

namespace palpate {

class OgdenLaw {
 public:
  // `mu`: shear modulus at rest, which is divided among the terms by their shares.
  OgdenLaw(const std::vector<OgdenTerm>& terms, double mu);

  // For F = I + H: A and dA / dF. Infinite and zero where det F is not above zero. Strains of 1e-18
  // keep their digits.
  struct Point {
    double energy = 0;
    Eigen::Matrix3d stress = Eigen::Matrix3d::Zero();
  };
  [[nodiscard]] Point At(const Eigen::Matrix3d& H) const;

  // Derivatives by principal stretches, all above zero: dA / dl_i, and the second derivatives.
  struct Principal {
    Eigen::Vector3d slope;
    Eigen::Matrix3d curvature;
  };
  [[nodiscard]] Principal At(const Eigen::Vector3d& stretches) const;

 private:
  // l_i dA / dl_i of log b_i.
  [[nodiscard]] Eigen::Vector3d Kirchhoff(const Eigen::Vector3d& log_b) const;

  struct Term {
    double mu, alpha;
  };
  std::vector<Term> terms_;
};

}  // namespace palpate
