// Isotropic elastic energies of the principal stretches l1, l2, l3 that are fitted to tests of a
// material.
//
//   W = sum over i of 2 G_i / a_i^2 (l1^a_i + l2^a_i + l3^a_i - 3)
//       + c1 (I1 - 3) + c2 (I1 - 3)^2 + c3 (I1 - 3)^3
//
// All models are incompressible. The first line is Ogden's law (1972); neo-Hookean is a = 2, Mooney
// and Rivlin's a = 2 and -2. sum G_i is the shear modulus at rest. A term with G_i > 0 is convex in
// the logarithmic strain, hence stable under every load (Hill 1957). The second line is Yeoh's law
// (1990).
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace palpate::identify {

struct LawTerm {
  double G = 0;      // [Pa]
  double alpha = 2;  // not 0 [-]
};

struct HyperLaw {
  std::string name;
  std::vector<LawTerm> terms;
  Eigen::Vector3d yeoh{0, 0, 0};  // c1, c2, c3 [Pa]

  // dW / dl_i without the pressure [Pa]. All stretches > 0.
  [[nodiscard]] Eigen::Vector3d Derivatives(const Eigen::Vector3d& stretches) const;
  [[nodiscard]] double ShearModulus() const;  // at rest [Pa]
  [[nodiscard]] double YoungModulus() const;  // at rest [Pa]
};

// LawFamily states which parameters of a law are fitted. For given exponents W is linear in the
// moduli.
struct LawFamily {
  std::string name;
  std::vector<double> fixed;  // exponents that the name decides
  int free = 0;               // number of unknown exponents
  std::vector<int> yeoh;      // powers of I1 - 3, of 1 to 3, instead of terms

  [[nodiscard]] int moduli() const {
    return static_cast<int>(yeoh.empty() ? fixed.size() : yeoh.size()) + free;
  }
  [[nodiscard]] int parameters() const { return moduli() + free; }
  [[nodiscard]] HyperLaw Make(const Eigen::VectorXd& moduli,
                              const Eigen::VectorXd& exponents) const;
  // Returns the names that reports use: G1, alpha1, ..., in the order of Make's arguments.
  [[nodiscard]] std::vector<std::string> ParameterNames() const;
};

// Range of the size of a free exponent [-].
inline constexpr double kMinExponent = 1e-3, kMaxExponent = 40;

// All that are offered, from the simplest on.
const std::vector<LawFamily>& OfferedLaws();

// Returns the smallest second-order work of a small volume-preserving step from these stretches,
// relative to that at rest: below zero the law is unstable there (Drucker). Computed by
// differences.
double MinStability(const HyperLaw& law, const Eigen::Vector3d& stretches);

// Returns as text where a law first becomes unstable in uniaxial, equibiaxial or planar load
// between the stretches `low` <= 1 <= `high`; empty if it is stable.
std::string FirstInstability(const HyperLaw& law, double low, double high);

}  // namespace palpate::identify
