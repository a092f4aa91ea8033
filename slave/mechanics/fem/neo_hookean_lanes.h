// The stable neo-Hookean law of solid/material_law.h for eight linear tetrahedra at a time: energy,
// forces and tangent from one deformation gradient.
//
//   K_ab = V (c_I g_a.g_b 1 + c_F f_a f_b^T + k h_a h_b^T + c_J [F (g_a x g_b)]),
//   f = F g, h = cof F g, [w] v = v x w
//
// with g_a the gradient of corner a's shape function. Rows and columns of the first corner are
// minus the sums of the others'.
#pragma once

#include <array>
#include <cmath>

#include "slave/mechanics/fem/signed_polar.h"
#include "slave/mechanics/linear/lanes.h"

namespace palpate::fem {

using LaneVector = std::array<Double8, 3>;

// Moduli of the law, in units of Young's modulus.
struct NeoHookeanModuli {
  double m = 0;  // 4/3 mu
  double k = 0;  // lambda + 5/6 mu, on the change of volume
};

struct NeoHookeanPoint {
  Lanes3x3 F, cofactor, stress;       // stress: dPsi / dF
  Double8 energy, determinant;        // Psi; det F
  Double8 identity, along, pressure;  // c_I, c_F, c_J
};

PALPATE_INLINE Lanes3x3 CofactorOf(const Lanes3x3& F) {
  Lanes3x3 C;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t a = (i + 1) % 3, b = (i + 2) % 3;
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t p = (j + 1) % 3, q = (j + 2) % 3;
      C[i][j] = F[a][p] * F[b][q] - F[a][q] * F[b][p];
    }
  }
  return C;
}

// log(1 + x), x > -1: twice the inverse hyperbolic tangent of x / (2 + x) by its series, which is
// exact to rounding where that is at most a third; else from the library.
PALPATE_INLINE Double8 LogOfOnePlus(const Double8& x) {
  constexpr int kLast = 31;
  const Double8 s = x / (x + 2), square = s * s;
  Double8 sum = Double8{} + 1.0 / kLast;
  for (int k = kLast - 2; k > 0; k -= 2) sum = sum * square + 1.0 / k;
  Double8 logarithm = 2 * s * sum;
  for (int l = 0; l < kLanes; ++l) {
    if (!(square[l] <= 1.0 / 9)) logarithm[l] = std::log1p(x[l]);
  }
  return logarithm;
}

// Evaluates the law from H = F - I, so that strains of 1e-18 keep their digits.
PALPATE_INLINE NeoHookeanPoint NeoHookeanAt(const NeoHookeanModuli& law, const Lanes3x3& H) {
  const Lanes3x3 minors = CofactorOf(H);
  const Double8 trace = H[0][0] + H[1][1] + H[2][2];
  const Double8 g = trace + minors[0][0] + minors[1][1] + minors[2][2] + H[0][0] * minors[0][0] +
                    H[0][1] * minors[0][1] + H[0][2] * minors[0][2];
  Double8 stretch = 2 * trace;  // I_C - 3
  for (const auto& row : H) stretch += row[0] * row[0] + row[1] * row[1] + row[2] * row[2];
  NeoHookeanPoint at;
  at.determinant = 1 + g;
  const Double8 logarithm = LogOfOnePlus(0.25 * stretch);
  at.energy = 0.5 * law.m * (stretch - logarithm) - 0.75 * law.m * g + 0.5 * law.k * g * g;
  const Double8 inverse = 1 / (stretch + 4);
  const Double8 excess = 0.25 * law.m * stretch * inverse;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      Double8 area = minors[i][j] - H[j][i];  // cof F - I
      if (i == j) area += trace;
      at.F[i][j] = H[i][j];
      at.cofactor[i][j] = area;
      if (i == j) at.F[i][j] += 1, at.cofactor[i][j] += 1;
      at.stress[i][j] =
          0.75 * law.m * (H[i][j] - area) + excess * at.F[i][j] + law.k * g * at.cofactor[i][j];
    }
  }
  at.identity = law.m * (1 - inverse);
  at.along = 2 * law.m * inverse * inverse;
  at.pressure = law.k * g - 0.75 * law.m;
  return at;
}

PALPATE_INLINE LaneVector Times(const Lanes3x3& A, const LaneVector& x) {
  LaneVector y;
  for (std::size_t i = 0; i < 3; ++i) y[i] = A[i][0] * x[0] + A[i][1] * x[1] + A[i][2] * x[2];
  return y;
}

PALPATE_INLINE LaneVector Scaled(const Double8& factor, const LaneVector& x) {
  return {factor * x[0], factor * x[1], factor * x[2]};
}

PALPATE_INLINE LaneVector Cross(const LaneVector& a, const LaneVector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// a -= b, or its transpose.
PALPATE_INLINE void Subtract(const Lanes3x3& b, bool transposed, Lanes3x3& a) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) a[i][j] -= transposed ? b[j][i] : b[i][j];
  }
}

// Pairs of corners a <= b, and where they are kept: row by row.
inline constexpr int kPairs = 10;
constexpr std::size_t PairOf(std::size_t a, std::size_t b) {
  return a * (7 - a) / 2 + b;
}
using PairBlocks = std::array<Lanes3x3, kPairs>;

// `gradient`: of corners 1 to 3; `shift` >= 0 is added to c_I, so that the tangent becomes
// definite.
PALPATE_INLINE void TangentOf(const NeoHookeanPoint& at, double k, double shift,
                              const std::array<LaneVector, 3>& gradient, const Double8& volume,
                              PairBlocks& K) {
  std::array<LaneVector, 3> f, h;
  for (std::size_t a = 0; a < 3; ++a) {
    f[a] = Times(at.F, gradient[a]);
    h[a] = Times(at.cofactor, gradient[a]);
  }
  for (std::size_t b = 0; b < 3; ++b) {
    const LaneVector along = Scaled(volume * at.along, f[b]), swell = Scaled(volume * k, h[b]);
    const LaneVector same = Scaled(volume * (at.identity + shift), gradient[b]);
    for (std::size_t a = 0; a <= b; ++a) {
      Lanes3x3& block = K[PairOf(a + 1, b + 1)];
      const LaneVector& g = gradient[a];
      const Double8 equal = same[0] * g[0] + same[1] * g[1] + same[2] * g[2];
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
          block[i][j] = f[a][i] * along[j] + h[a][i] * swell[j];
        }
        block[i][i] += equal;
      }
      if (a == b) continue;
      const LaneVector w = Scaled(volume * at.pressure, Times(at.F, Cross(g, gradient[b])));
      block[0][1] += w[2], block[1][0] -= w[2];
      block[1][2] += w[0], block[2][1] -= w[0];
      block[2][0] += w[1], block[0][2] -= w[1];
    }
  }
  K[0] = {};
  for (std::size_t b = 1; b < 4; ++b) {
    Lanes3x3& first = K[PairOf(0, b)];
    first = {};
    for (std::size_t a = 1; a < 4; ++a) {
      Subtract(K[a <= b ? PairOf(a, b) : PairOf(b, a)], a > b, first);
    }
    Subtract(first, false, K[0]);
  }
}

}  // namespace palpate::fem
