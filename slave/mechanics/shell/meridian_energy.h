// Energy of the pieces of a shell's meridian with its derivatives, see FluidShell. Lengths relative
// to the sphere's radius R, energy to E h R^2, pressure to E h / R.
#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <unsupported/Eigen/AutoDiff>

namespace palpate::shell {

// Value, gradient and Hessian of what depends on N coordinates.
template <int N>
struct Local {
  Eigen::Matrix<double, N, 1> gradient;
  Eigen::Matrix<double, N, N> hessian;
};

// `energy(x)` of a vector of N scalars. The Hessian by central differences of exact gradients,
// which is sufficient for the iteration that uses it.
template <int N, typename Energy>
Local<N> Derive(const Eigen::Matrix<double, N, 1>& at, const Energy& energy) {
  using Vector = Eigen::Matrix<double, N, 1>;
  using Dual = Eigen::AutoDiffScalar<Vector>;
  const auto gradient = [&](const Vector& x) -> Vector {
    Eigen::Matrix<Dual, N, 1> dual;
    for (int i = 0; i < N; ++i) dual(i) = Dual(x(i), N, i);
    return energy(dual).derivatives();
  };
  constexpr double kStep = 1e-6;
  Local<N> local{gradient(at), {}};
  for (int i = 0; i < N; ++i) {
    Vector ahead = at, behind = at;
    ahead(i) += kStep, behind(i) -= kStep;
    local.hessian.col(i) = (gradient(ahead) - gradient(behind)) / (2 * kStep);
  }
  local.hessian = (0.5 * (local.hessian + local.hessian.transpose())).eval();
  return local;
}

// A piece between two nodes at rest.
struct Piece {
  double length = 0, r = 0;  // its own, and of its middle from the axis
  double kappa2 = 0;         // curvature along the parallel
};

// (r, z) of both ends.
template <typename T>
using Ends = Eigen::Matrix<T, 4, 1>;
template <typename T>
using Triple = Eigen::Matrix<T, 6, 1>;  // (r, z) of three nodes

template <typename T>
T LengthOf(const T& dr, const T& dz) {
  using std::sqrt;
  return sqrt(dr * dr + dz * dz);
}

// Quadratic form of two strains or changes of curvature, x1 along the meridian.
template <typename T>
T PlaneEnergy(const T& x1, const T& x2, double nu) {
  return (x1 * x1 + 2 * nu * x1 * x2 + x2 * x2) / (2 * (1 - nu * nu));
}

template <typename T>
T Stretching(const Ends<T>& x, const Piece& rest, double nu) {
  const T dr = x(2) - x(0), dz = x(3) - x(1), r = 0.5 * (x(0) + x(2));
  const T e1 = LengthOf(dr, dz) / rest.length - 1.0, e2 = r / rest.r - 1.0;
  return 2 * std::numbers::pi * rest.r * rest.length * PlaneEnergy(e1, e2, nu);
}

// The volume within, between the planes of both ends; positive where z falls.
template <typename T>
T VolumeWithin(const Ends<T>& x) {
  return std::numbers::pi / 3 * (x(0) * x(0) + x(0) * x(2) + x(2) * x(2)) * (x(1) - x(3));
}

template <typename T>
T AlongParallel(const T& dr, const T& dz, const T& r) {
  return -dz / (LengthOf(dr, dz) * r);
}

// Turn of the meridian at the middle one of three nodes [rad], less than a right angle.
template <typename T>
T Turn(const Triple<T>& x) {
  using std::asin;
  const T ar = x(2) - x(0), az = x(3) - x(1), br = x(4) - x(2), bz = x(5) - x(3);
  const T sine = (az * br - ar * bz) / (LengthOf(ar, az) * LengthOf(br, bz));
  return asin(sine);
}

// At a node between two pieces; `share`: length of wall that bends there.
struct Hinge {
  double turn = 0;                // at rest [rad]
  double kappa2 = 0;              // mean of both pieces at rest
  double between = 0, share = 0;  // their middles are so far apart
  double r = 0;
};

template <typename T>
T Kappa2(const Triple<T>& x) {
  const T ar = x(2) - x(0), az = x(3) - x(1), br = x(4) - x(2), bz = x(5) - x(3);
  const T a = AlongParallel<T>(ar, az, 0.5 * (x(0) + x(2)));
  const T b = AlongParallel<T>(br, bz, 0.5 * (x(2) + x(4)));
  return 0.5 * (a + b);
}

// `thin`: h / R.
template <typename T>
T Bending(const Triple<T>& x, const Hinge& rest, double nu, double thin) {
  const T k1 = (Turn(x) - rest.turn) / rest.between;
  const T k2 = Kappa2(x) - rest.kappa2;
  const double area = 2 * std::numbers::pi * rest.r * rest.share;
  return area * thin * thin / 12 * PlaneEnergy(k1, k2, nu);
}

}  // namespace palpate::shell
