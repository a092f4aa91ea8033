// Elastic energy densities of a deformation gradient, split into a part and a pressure part:
//
//   Psi(F, p) = A(F) + p g(F) - p^2 / (2 k),   p = k g(F) if it is not a separate unknown
//
//   linear        A = mu eps:eps                        g = tr eps       k = lambda
//   corotational  A = mu |S - I|^2                      g = tr(S - I)    k = lambda
//   neo-Hookean   A = m/2 (I_C - 3) - m/2 ln((I_C + 1)/4) - 3/4 m (J - 1)
//                                                       g = J - 1        k = lambda + 5/6 mu
//   ogden         A = that of ogden_law.h              g = J - 1        k = lambda + 2/3 mu
//
// F = R S with det R = 1 (the smallest stretch takes the sign of J), I_C = tr F^T F, J = det F,
// m = 4/3 mu. With p = k g the last is the stable neo-Hookean law of Smith, de Goes and Kim 2018
// (their eq. 14, with its rest-stable constants) up to a constant; all agree to second order
// about rest. Stresses are in units of Young's modulus. Immutable, hence thread-safe.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/solid/ogden_law.h"
#include "slave/scene/scene.h"

namespace palpate {

using Matrix9d = Eigen::Matrix<double, 9, 9>;

// Treatment of the parts that make a tangent indefinite.
struct Tangent {
  double removed = 0;   // fraction of every negative curvature at a point that is removed, 0 to 1
  bool warped = false;  // keep the co-rotational law's rotation constant
};
constexpr Tangent kExactTangent{0, false};
constexpr Tangent kProjectedTangent{1, false};  // positive semidefinite
constexpr Tangent kWarpedTangent{1, true};

class MaterialLaw {
 public:
  struct Point {
    double energy = 0;              // A [E]
    double g = 0;                   // the volume change that p acts on [-]
    Eigen::Matrix3d stress;         // dA / dF [E]
    Eigen::Matrix3d volume_stress;  // dg / dF [-]
  };

  // -1 < nu <= 0.5, checked by the caller. `terms`: of Ogden's law alone.
  MaterialLaw(FemOptions::Law law, double nu, const std::vector<OgdenTerm>& terms = {});

  // H = F - I, the displacement gradient: strains of 1e-18 keep their digits.
  [[nodiscard]] Point At(const Eigen::Matrix3d& H) const;
  // Tangent of laws whose energy depends only on I_C and J, as in TangentAt without removed parts:
  //   identity 1 + along F F^T + volume cof F cof F^T + pressure d cof F / dF
  struct InvariantTangent {
    double identity = 0, along = 0, volume = 0, pressure = 0;
  };
  [[nodiscard]] bool HasInvariantTangent() const { return law_ == FemOptions::Law::kNeoHookean; }
  [[nodiscard]] InvariantTangent InvariantTangentAt(const Eigen::Matrix3d& H, double p,
                                                    double bulk) const;
  // d2(A + p g) / dF dF + bulk dg/dF dg/dF^T over vec(F), column by column. `bulk`: k where the
  // pressure follows from g at the point itself, 0 where it is an unknown.
  [[nodiscard]] Matrix9d TangentAt(const Eigen::Matrix3d& H, double p, double bulk,
                                   const Tangent& tangent) const;

  // 1 / k [1/E]; zero at nu = 0.5, not positive for the first two laws where nu <= 0.
  [[nodiscard]] double compressibility() const { return compressibility_; }
  [[nodiscard]] double mu() const { return mu_; }  // [E]
  [[nodiscard]] FemOptions::Law law() const { return law_; }

 private:
  // In the frame of principal stretches: second derivatives along them, and the stiffness against
  // shears (flip) and rotations (twist) in the planes 12, 02, 01.
  struct Principal {
    Eigen::Matrix3d along;
    Eigen::Vector3d flip, twist;
  };
  [[nodiscard]] Principal PrincipalAt(const Eigen::Vector3d& s, double p, double bulk,
                                      const Tangent& tangent) const;
  [[nodiscard]] Principal OgdenPrincipalAt(const Eigen::Vector3d& s, double p, double bulk) const;
  [[nodiscard]] Matrix9d LinearTangent(double bulk) const;

  FemOptions::Law law_;
  double mu_, compressibility_;
  OgdenLaw ogden_;
};

// F = U diag(s) V^T with det U = det V = 1, s falling, only the last may be negative.
struct SignedSvd {
  Eigen::Matrix3d U, V;
  Eigen::Vector3d s;
};
SignedSvd SignedSvdOf(const Eigen::Matrix3d& F);

}  // namespace palpate
