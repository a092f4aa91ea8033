// Isotropic elastic energies of the principal stretches l1, l2, l3 that tests of a material decide.
//
//   W = sum over i of 2 G_i / a_i^2 (l1^a_i + l2^a_i + l3^a_i - 3 + (J^(-a_i b) - 1) / b)
//       + c1 (I1 - 3) + c2 (I1 - 3)^2 + c3 (I1 - 3)^3 + 3 c1 r ln(I2 / 3)
//
// The first line is Ogden's law (1972), with b = nu / (1 - 2 nu) the compressible foam of Storakers
// (1986); neo-Hookean is a = 2, Mooney and Rivlin's a = 2 and -2. sum G_i is the shear modulus at
// rest. A term with G_i > 0 is convex in the logarithmic strain, hence stable under every load
// (Hill 1957). The second line is Yeoh's law (1990) with a term of Gent and Thomas (1958) of share
// r at rest.
#pragma once

#include <optional>
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
  double second_share = 0;        // r [-]
  std::optional<double> nu;       // nullopt: incompressible

  // dW / dl_i without the pressure of an incompressible law [Pa]. All stretches > 0.
  [[nodiscard]] Eigen::Vector3d Derivatives(const Eigen::Vector3d& stretches) const;
  [[nodiscard]] double ShearModulus() const;  // at rest [Pa]
  [[nodiscard]] double YoungModulus() const;  // at rest [Pa]
  [[nodiscard]] double PoissonRatio() const { return nu.value_or(0.5); }
};

// Which numbers of a law are sought. Given exponents (and nu), W is linear in the moduli.
struct LawFamily {
  std::string name;
  std::vector<double> fixed;  // exponents that the name decides
  int free = 0;               // exponents that are sought
  bool foam = false;          // compressible, nu is sought too
  std::vector<int> yeoh;      // powers of I1 - 3, of 1 to 3, instead of terms
  double second_share = 0;

  [[nodiscard]] int moduli() const {
    return static_cast<int>(yeoh.empty() ? fixed.size() : yeoh.size()) + free;
  }
  [[nodiscard]] int shapes() const { return free + (foam ? 1 : 0); }
  [[nodiscard]] int parameters() const { return moduli() + shapes(); }
  // `shape`: exponents, then nu of a foam.
  [[nodiscard]] HyperLaw Make(const Eigen::VectorXd& moduli, const Eigen::VectorXd& shape) const;
  // As reports call them: G1, alpha1, ..., in the order of Make's arguments.
  [[nodiscard]] std::vector<std::string> ParameterNames() const;
};

inline constexpr double kMostExponent = 40;       // [-], of free ones
inline constexpr double kLeastExponent = 1e-3;    // the same, of their size
inline constexpr double kMostFoamPoisson = 0.49;  // of a foam [-]

// All that are offered, from the simplest on.
const std::vector<LawFamily>& OfferedLaws();

// The least second-order work of a small step from where the stretches are, over that of the law at
// rest, along all principal steps that keep the volume (or all, of a foam): below zero the law is
// unstable there (Drucker). By differences.
double LeastStability(const HyperLaw& law, const Eigen::Vector3d& stretches);

// Where in uniaxial, equibiaxial or planar load between the stretches `low` <= 1 <= `high` a law
// first is unstable, as text; empty: nowhere.
std::string FirstInstability(const HyperLaw& law, double low, double high);

}  // namespace palpate::identify
