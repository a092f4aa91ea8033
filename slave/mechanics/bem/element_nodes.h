// Nodes of boundary elements: one, two or three inside each element, at the Gauss points; and the
// integrals of the Legendre polynomials that interpolate their values.
//
// Elements are discontinuous: no node is shared, and none is at a corner. At every node the
// boundary is smooth and has one normal, so corners, ends of supports, contacts that begin between
// two elements, and several loops need no special rules; a contact on an element moves only that
// element. The cost is two nodes per linear element instead of one. At Gauss's points the nodes'
// weights integrate a traction exactly, and displacements converge faster than the interpolation
// between the nodes does.
#pragma once

#include <array>
#include <complex>

#include "slave/scene/scene.h"

namespace palpate {

constexpr int kMaxNodeCount = 3;
constexpr int kModes = kMaxNodeCount + 1;  // Legendre's polynomials that are integrated

// On -1 <= s <= 1. P_k: Legendre's polynomials.
struct ElementNodes {
  int count = 1;
  std::array<double, kMaxNodeCount> s{};
  std::array<double, kMaxNodeCount> weight{};  // sum: 1
  // The basis function of node m, one there and zero at the others, is sum_k mode[m][k] P_k(s).
  std::array<std::array<double, kMaxNodeCount>, kMaxNodeCount> mode{};

  // The basis function of node m at `at`, which may lie beyond the element's ends, -1 and 1.
  [[nodiscard]] double At(std::size_t m, double at) const {
    return mode[m][0] + at * mode[m][1] + Legendre(2, at) * mode[m][2];
  }
  // P_k(at), k <= 3. The nodes are the zeros of P_count.
  static double Legendre(int k, double at) {
    if (k < 2) return k == 0 ? 1 : at;
    return k == 2 ? 1.5 * at * at - 0.5 : (2.5 * at * at - 1.5) * at;
  }

  static const ElementNodes& Of(ElementOrder order);
};

// Integrals of Legendre's polynomials against the logarithm and its derivatives: the building
// blocks of linear and quadratic boundary elements.
//
// In an element's own frame, with lengths divided by half the element's length, the element is -1
// <= s <= 1 and the evaluation point is the complex number z. Kelvin's kernels are real and
// imaginary parts of ln(z - s), 1 / (s - z) and 1 / (s - z)^2, and the integrals Legendre's
// functions of the second kind:
//
//   int P_k / (s - z) ds = -2 Q_k(z),   int P_k ln(z - s) ds = 2 (Q_{k+1} - Q_{k-1}) / (2 k + 1)
//
// Source: Abramowitz and Stegun, 8.8.3 (Neumann) and 8.5.3 (recurrence); the second by parts.
struct LegendreMoments {
  using Complex = std::complex<double>;
  using Modes = std::array<Complex, kModes>;
  Modes log{};     // of ln(z - s); not for k = 0, which depends on the unit of length
  Modes pole{};    // of 1 / (s - z), the derivative of -log
  Modes dipole{};  // of 1 / (s - z)^2, the derivative of pole
  Modes triple{};  // of 2 / (s - z)^3, the derivative of dipole

  // Accurate to working precision relative to the largest mode for any `z`. On the element, imag(z)
  // = 0 and |real(z)| < 1, the values are Cauchy principal values; dipole and triple are zero
  // there, because their factors are zero.
  explicit LegendreMoments(Complex z);
};

}  // namespace palpate
