// Integrals of Kelvin's plane solution over a straight element on which the density is constant or
// one of Legendre's polynomials.
//
// A unit line force at x in direction i causes at y, r = y - x, the displacement U_ij and, on a cut
// with normal n, the traction T_ij in direction j (plane strain, shear modulus G; plane stress with
// the effective nu):
//
//   U_ij = [ -(3 - 4 nu) ln r d_ij + r,i r,j ] / (8 pi G (1 - nu))
//   T_ij = -[ ((1 - 2 nu) d_ij + 2 r,i r,j) dr/dn - (1 - 2 nu) (r,i n_j - r,j n_i) ]
//          / (4 pi (1 - nu) r)
//
// Source: Brebbia, Telles and Wrobel, Boundary Element Techniques (1984), eqs. (5.1.13)-(5.1.15).
// In the element's own frame (t, n) y - x = xi t + d n with d constant, so that every integral is
// elementary. One formula is used for all pairs: the antiderivatives' differences are computed
// analytically, so that there is no cancellation at large distances, and on the element itself (d =
// 0) the result is Cauchy's principal value.
#pragma once

#include <cmath>
#include <complex>
#include <numbers>
#include <type_traits>
#include <utility>

#include <Eigen/Core>

#include "slave/mechanics/bem/element_nodes.h"

namespace palpate {

// Returns ln(q / p) for q - p = `difference`; for doubles it is accurate even if p and q are nearly
// equal.
template <typename T>
T LogRatio(const T& p, const T& q, const T& difference) {
  using std::log;
  if constexpr (std::is_same_v<T, double>) {
    return difference < 0 ? -std::log1p(-difference / q) : std::log1p(difference / p);
  } else {
    return log(T(q / p));
  }
}

// Integrals over the element's length; T is double, or a dual number to differentiate by x.
template <typename T>
struct KelvinIntegrals {
  T log_r;                       // of ln r
  T angle;                       // of d / r^2: the angle under which x sees the element
  T log_ratio;                   // of xi / r^2 = ln(r_b / r_a)
  T direction_tt, direction_tn;  // of r,t r,t and r,t r,n; r,n r,n follows from their sum
  T turn_n, turn_t;              // of (d^3 - d xi^2) / r^4 and of 2 d^2 xi / r^4

  KelvinIntegrals() = default;
  // The integral of a constant. From x to the element's ends: `xi_a` and `xi_a + length` along t,
  // `d` along n.
  KelvinIntegrals(const T& xi_a, const T& d, double length) {
    using std::atan2;
    using std::log;
    const T xi_b = xi_a + length;
    const T d2 = d * d;
    const T ra2 = xi_a * xi_a + d2;
    const T rb2 = xi_b * xi_b + d2;
    const T sum = xi_a + xi_b;
    log_ratio = 0.5 * LogRatio(ra2, rb2, T(length * sum));
    const bool inside = d == 0.0 && xi_a * xi_b < 0.0;
    angle = inside ? T(0.0 * d) : T(atan2(T(d * length), T(xi_a * xi_b + d2)));
    log_r = 0.5 * sum * log_ratio + (0.25 * length) * log(T(ra2 * rb2)) - length + d * angle;
    direction_tt = length - d * angle;
    direction_tn = d * log_ratio;
    const T slope = length * d / (ra2 * rb2);
    turn_n = slope * (d2 - xi_a * xi_b);
    turn_t = slope * d * sum;
  }
};

// An element relative to a point, lengths in units of the mesh: tangent, outward normal, and the
// components along both from the point to the element's start.
struct ElementView {
  Eigen::Vector2d t, n;
  double xi_a = 0, d = 0, length = 0;
  // The point in the element's frame, over half its length.
  [[nodiscard]] std::complex<double> z() const {
    const double half = 0.5 * length;
    return {-(xi_a + half) / half, -d / half};
  }
};

// The integral of P_k, k > 0, over an element of half length `h`. `lift` turns a holomorphic
// function of z, given with its derivative, into its real and imaginary parts: a pair of T.
template <typename T, typename Lift>
KelvinIntegrals<T> KelvinMode(const LegendreMoments& moments, std::size_t k, double h, const T& d,
                              const Lift& lift) {
  const auto log = lift(moments.log[k], -moments.pole[k]);
  const auto pole = lift(moments.pole[k], moments.dipole[k]);
  const auto dipole = lift(moments.dipole[k], moments.triple[k]);
  KelvinIntegrals<T> I;
  I.log_r = h * log.first;
  I.angle = -pole.second;
  I.log_ratio = pole.first;
  I.direction_tt = d * pole.second;
  I.direction_tn = d * pole.first;
  I.turn_n = -(d * dipole.first) / h;
  I.turn_t = -(d * dipole.second) / h;
  return I;
}

inline KelvinIntegrals<double> KelvinMode(const LegendreMoments& moments, std::size_t k, double h,
                                          double d) {
  return KelvinMode<double>(moments, k, h, d, [](const auto& value, const auto& /*derivative*/) {
    return std::pair{value.real(), value.imag()};
  });
}

// Contribution of values on an element at a point: row i for the unit force's direction,
// column j for the component of the traction or displacement, frame of the mesh.
template <typename T>
struct KelvinBlocks {
  Eigen::Matrix<T, 2, 2> of_traction;      // integral of U_ij
  Eigen::Matrix<T, 2, 2> of_displacement;  // integral of T_ij, principal value
};

// The constants of the two kernels.
struct KelvinConstants {
  double u, t;    // 1 / (8 pi G (1 - nu)), 1 / (4 pi (1 - nu))
  double u_log;   // 3 - 4 nu
  double t_skew;  // 1 - 2 nu

  KelvinConstants(double shear_modulus, double effective_nu)
      : u(1 / (8 * std::numbers::pi * shear_modulus * (1 - effective_nu))),
        t(1 / (4 * std::numbers::pi * (1 - effective_nu))),
        u_log(3 - 4 * effective_nu),
        t_skew(1 - 2 * effective_nu) {}
};

// Turns the integrals from the element's frame, tangent (tx, ty) and normal (ty, -tx), and adds
// the kernels up. `length`: the integral of the density, the element's length or, for k > 0, zero.
template <typename T>
KelvinBlocks<T> Combine(const KelvinConstants& c, const KelvinIntegrals<T>& I, double length,
                        double tx, double ty) {
  // A symmetric matrix with the entries tt, tn, nn in the element's frame is
  // (tt + nn) / 2 I + (tt - nn) / 2 [C S; S -C] + tn [S -C; -C -S], C = cos 2a, S = sin 2a.
  const double C = tx * tx - ty * ty;
  const double S = 2 * tx * ty;
  const T half = I.direction_tt - 0.5 * length;  // (tt - nn) / 2, as tt + nn = length
  const T u_mean = 0.5 * length - c.u_log * I.log_r;
  const T u_c = half * C + I.direction_tn * S;
  const T u_s = half * S - I.direction_tn * C;
  KelvinBlocks<T> blocks;
  blocks.of_traction << c.u * (u_mean + u_c), c.u * u_s, c.u * u_s, c.u * (u_mean - u_c);
  const T t_mean = (c.t_skew + 1) * I.angle;
  const T t_c = I.turn_t * S - I.turn_n * C;
  const T t_s = -I.turn_n * S - I.turn_t * C;
  const T skew = c.t_skew * I.log_ratio;
  blocks.of_displacement << -c.t * (t_mean + t_c), -c.t * (t_s + skew), -c.t * (t_s - skew),
      -c.t * (t_mean - t_c);
  return blocks;
}

}  // namespace palpate
