// Integrals of Legendre's polynomials against the logarithm and its derivatives: what linear and
// quadratic boundary elements are made of.
//
// In an element's own frame, lengths over half the element's, the element is -1 <= s <= 1 and the
// point that looks at it the complex number z. Kelvin's kernels are real and imaginary parts of
// ln(z - s), 1 / (s - z) and 1 / (s - z)^2, and the integrals Legendre's functions of the second
// kind:
//
//   int P_k / (s - z) ds = -2 Q_k(z),   int P_k ln(z - s) ds = 2 (Q_{k+1} - Q_{k-1}) / (2 k + 1)
//
// Source: Abramowitz and Stegun, 8.8.3 (Neumann) and 8.5.3 (recurrence); the second by parts.
#pragma once

#include <array>
#include <complex>

#include "slave/mechanics/bem/element_nodes.h"

namespace palpate {

struct LegendreMoments {
  using Complex = std::complex<double>;
  using Modes = std::array<Complex, kLargestNodeCount>;
  Modes log{};     // of ln(z - s); not for k = 0, whose scale is not its own
  Modes pole{};    // of 1 / (s - z), the derivative of -log
  Modes dipole{};  // of 1 / (s - z)^2, the derivative of pole
  Modes triple{};  // of 2 / (s - z)^3, the derivative of dipole

  // To working precision relative to the largest mode, however near or far `z` is. On the element,
  // imag(z) = 0 and |real(z)| < 1, Cauchy's principal values; dipole and triple are zero there, as
  // what they are multiplied with is.
  explicit LegendreMoments(Complex z);
};

}  // namespace palpate
