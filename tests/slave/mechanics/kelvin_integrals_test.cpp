#include "slave/mechanics/bem/kelvin_integrals.h"

#include <array>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kShear = 0.35;

struct Kernels {
  Matrix2d U, T;
};

// Kelvin's solution at y for unit forces at x, as printed above the integrals.
Kernels KernelsAt(const Vector2d& x, const Vector2d& y, const Vector2d& n, double nu) {
  const Vector2d r = y - x;
  const double d = r.norm();
  const Vector2d g = r / d;
  const Matrix2d I = Matrix2d::Identity();
  const double pi = std::numbers::pi;
  Kernels k;
  k.U = (-(3 - 4 * nu) * std::log(d) * I + g * g.transpose()) / (8 * pi * kShear * (1 - nu));
  k.T = -(((1 - 2 * nu) * I + 2 * g * g.transpose()) * g.dot(n) -
          (1 - 2 * nu) * (g * n.transpose() - n * g.transpose())) /
        (4 * pi * (1 - nu) * d);
  return k;
}

// Gauss's rule with five points on each of many equal parts.
Kernels Quadrature(const Vector2d& a, const Vector2d& b, const Vector2d& x, double nu, int parts) {
  constexpr std::array kPoint{-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831,
                              0.9061798459386640};
  constexpr std::array kWeight{0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                               0.4786286704993665, 0.2369268850561891};
  const Vector2d t = (b - a).normalized();
  const Vector2d n(t.y(), -t.x());
  Kernels sum{Matrix2d::Zero(), Matrix2d::Zero()};
  for (int part = 0; part < parts; ++part) {
    for (std::size_t q = 0; q < kPoint.size(); ++q) {
      const double s = (part + 0.5 * (1 + kPoint[q])) / parts;
      const double w = 0.5 * kWeight[q] / parts * (b - a).norm();
      const Kernels k = KernelsAt(x, a + s * (b - a), n, nu);
      sum.U += w * k.U;
      sum.T += w * k.T;
    }
  }
  return sum;
}

KelvinBlocks<double> Exact(const Vector2d& a, const Vector2d& b, const Vector2d& x, double nu) {
  const Vector2d t = (b - a).normalized();
  const Vector2d n(t.y(), -t.x());
  const double length = (b - a).norm();
  const KelvinIntegrals<double> integrals((a - x).dot(t), (a - x).dot(n), length);
  return Combine(KelvinConstants(kShear, nu), integrals, length, t.x(), t.y());
}

class KelvinIntegralsTest : public testing::TestWithParam<double> {};

// Reference: quadrature of the pointwise kernels, fine enough to be exact to 1e-13 at each distance
// (parts much shorter than the distance).
TEST_P(KelvinIntegralsTest, AgreeWithQuadratureNearAndFar) {
  const double nu = GetParam();
  const Vector2d a(0.3, -0.2);
  const Vector2d b(0.37, -0.14);
  const Vector2d middle = 0.5 * (a + b);
  for (const double distance : {0.01, 0.05, 0.3, 1.0, 30.0}) {
    for (const double angle : {0.1, 1.0, 2.5, 4.0, 5.5}) {
      const Vector2d x = middle + distance * Vector2d(std::cos(angle), std::sin(angle));
      const Kernels expected = Quadrature(a, b, x, nu, distance < 0.1 ? 4000 : 40);
      const auto exact = Exact(a, b, x, nu);
      EXPECT_LT((exact.of_traction - expected.U).norm(), 1e-12 * expected.U.norm()) << distance;
      EXPECT_LT((exact.of_displacement - expected.T).norm(), 1e-12 * expected.T.norm())
          << distance << ' ' << angle;
    }
  }
}

// Reference: the element's own principal value, two mirrored halves without the point itself. The
// displacement kernel is finite in the limit, the traction kernel is odd and vanishes up to the
// skew part, which cancels too.
TEST_P(KelvinIntegralsTest, OnTheElementItselfAreThePrincipalValue) {
  const double nu = GetParam();
  const double length = 0.1;
  const KelvinIntegrals<double> integrals(-0.5 * length, 0.0, length);
  const auto own = Combine(KelvinConstants(kShear, nu), integrals, length, 0.6, 0.8);
  EXPECT_LT(own.of_displacement.norm(), 1e-16);
  const Vector2d a(0, 0);
  const Vector2d t(0.6, 0.8);
  const Matrix2d below =
      Exact(a - 0.5 * length * t, a + 0.5 * length * t, a + 1e-9 * Vector2d(0.8, -0.6), nu)
          .of_traction;
  EXPECT_LT((own.of_traction - below).norm(), 1e-6 * below.norm());
}

INSTANTIATE_TEST_SUITE_P(PoissonRatios, KelvinIntegralsTest, testing::Values(-0.5, 0.0, 0.3, 0.5));

}  // namespace
}  // namespace palpate
