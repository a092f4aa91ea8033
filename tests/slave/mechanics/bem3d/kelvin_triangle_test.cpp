#include "slave/mechanics/bem3d/kelvin_triangle.h"

#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

using Pair = Eigen::Matrix<double, 3, 6>;  // U beside T

// The kernels as they are printed, one point at a time.
Pair Kernels(double nu, const Vector3d& x, const Vector3d& y, const Vector3d& n) {
  const double G = 1 / (2 * (1 + nu));
  const double r = (y - x).norm();
  const Vector3d g = (y - x) / r;
  const double dr_dn = g.dot(n);
  Pair both;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double same = i == j ? 1 : 0;
      both(i, j) = ((3 - 4 * nu) * same + g[i] * g[j]) / (16 * std::numbers::pi * G * (1 - nu) * r);
      both(i, 3 + j) = -(((1 - 2 * nu) * same + 3 * g[i] * g[j]) * dr_dn -
                         (1 - 2 * nu) * (g[i] * n[j] - g[j] * n[i])) /
                       (8 * std::numbers::pi * (1 - nu) * r * r);
    }
  }
  return both;
}

// Nodes and weights of Gauss-Legendre's rule on [0, 1] by Newton's method on the polynomial.
std::vector<std::pair<double, double>> GaussRule(int n) {
  std::vector<std::pair<double, double>> rule;
  for (int k = 0; k < n; ++k) {
    double x = std::cos(std::numbers::pi * (k + 0.75) / (n + 0.5));
    double slope = 1;
    for (int step = 0; step < 20; ++step) {
      double p = 1, before = 0;
      for (int m = 1; m <= n; ++m) {
        before = std::exchange(p, ((2 * m - 1) * x * p - (m - 1) * before) / m);
      }
      slope = n * (x * p - before) / (x * x - 1);
      x -= p / slope;
    }
    rule.emplace_back((1 + x) / 2, 1 / ((1 - x * x) * slope * slope));
  }
  return rule;
}

// Product rule in coordinates that collapse the square to the triangle.
Pair ByRule(double nu, const FlatTriangle& t, const Vector3d& x) {
  static const auto kRule = GaussRule(10);
  Pair sum = Pair::Zero();
  for (const auto& [u, wu] : kRule) {
    for (const auto& [v, wv] : kRule) {
      const Vector3d y = t.corners[0] + u * ((1 - v) * (t.corners[1] - t.corners[0]) +
                                             v * (t.corners[2] - t.corners[0]));
      sum += 2 * t.area * wu * wv * u * Kernels(nu, x, y, t.normal);
    }
  }
  return sum;
}

// Halves the triangle's edges until the parts agree with the whole.
Pair Adaptive(double nu, const FlatTriangle& t, const Vector3d& x, const Pair& whole, double within,
              int depth) {
  const auto& [a, b, c] = t.corners;
  const Vector3d ab = (a + b) / 2, bc = (b + c) / 2, ca = (c + a) / 2;
  const std::array<FlatTriangle, 4> parts{FlatTriangle(a, ab, ca), FlatTriangle(ab, b, bc),
                                          FlatTriangle(ca, bc, c), FlatTriangle(ab, bc, ca)};
  std::array<Pair, 4> sums;
  Pair sum = Pair::Zero();
  for (std::size_t k = 0; k < 4; ++k) sum += sums[k] = ByRule(nu, parts[k], x);
  if ((sum - whole).norm() <= within || depth == 0) return sum;
  sum.setZero();
  for (std::size_t k = 0; k < 4; ++k) {
    sum += Adaptive(nu, parts[k], x, sums[k], within / 2, depth - 1);
  }
  return sum;
}

// Of either block, relative to itself; T relative to 1 / r^2 where it vanishes, as it does in the
// triangle's plane at nu = 0.5.
double Discrepancy(double nu, const FlatTriangle& t, const Vector3d& x) {
  const Pair first = ByRule(nu, t, x);
  const Pair quadrature = Adaptive(nu, t, x, first, 1e-12 * first.norm(), 24);
  const KelvinSolidConstants constants(nu);
  const KelvinSolidBlocks exact = IntegrateKelvin(constants, t, x);
  const Matrix3d U = quadrature.leftCols<3>();
  const Matrix3d T = quadrature.rightCols<3>();
  const double usual = constants.t * t.area / (t.centroid - x).squaredNorm();
  return std::max((exact.of_traction - U).norm() / U.norm(),
                  (exact.of_displacement - T).norm() / std::max(T.norm(), usual));
}

// Reference: adaptive quadrature of the kernels, which knows nothing of the potentials. It is asked
// for 1e-12.
TEST(KelvinTriangle, IntegralsAgreeWithAdaptiveQuadratureEverywhere) {
  const FlatTriangle t({0.1, 0, 0.2}, {1.2, 0.1, 0}, {0.3, 0.9, 0.4});
  const Vector3d n = t.normal;
  const Vector3d edge = t.along[1];
  const std::vector<std::pair<const char*, Vector3d>> points{
      {"anywhere", {0.7, -0.4, 1.1}},
      {"just above the middle", t.centroid + 1e-2 * n},
      {"just below a corner", t.corners[2] - 1e-2 * n},
      {"just above an edge", (t.corners[0] + t.corners[1]) / 2 + 1e-2 * n},
      {"in the plane", t.centroid + 2 * t.outward[0]},
      {"in the plane, near an edge", (t.corners[0] + t.corners[1]) / 2 + 1e-2 * t.outward[0]},
      {"on an edge's line", t.corners[2] + 0.3 * edge},
      {"on an edge's line, before it", t.corners[1] - 0.3 * edge},
      {"almost on an edge's line", t.corners[2] + 0.3 * edge + 1e-7 * n},
      {"almost in the plane", t.centroid + 2 * t.outward[2] + 1e-9 * n},
      {"far away", {30, -50, 20}}};
  for (const double nu : {-0.9, 0.0, 0.3, 0.5}) {
    for (const auto& [name, x] : points) {
      EXPECT_LT(Discrepancy(nu, t, x), 1e-10) << name << ", nu = " << nu;
    }
  }
}

// Reference and tolerance as above.
TEST(KelvinTriangle, IntegralsOverSliversAgreeWithAdaptiveQuadrature) {
  for (const double width : {1e-2, 1e-4}) {
    const FlatTriangle t({0, 0, 0}, {1, 0, 0}, {0.4, width, 0});
    for (const Vector3d& x : {Vector3d(0.5, 0.02, 0.01), Vector3d(-0.3, 0, 0.2),
                              Vector3d(1.5, 0, 0), Vector3d(0.4, -0.05, 0)}) {
      EXPECT_LT(Discrepancy(0.3, t, x), 1e-10) << "width " << width << " at " << x.transpose();
    }
  }
}

// Reference: in polar coordinates about the centroid 1 / r leaves R(angle), the principal value of
// r / r^3 leaves ln R(angle) times the direction (the disc around the point vanishes by
// symmetry). Gauss's rule with 60 points on each edge's angle is exact to rounding.
TEST(KelvinTriangle, IntegralsOnItselfAreThoseInPolarCoordinates) {
  const FlatTriangle t({0.1, 0, 0.2}, {1.2, 0.1, 0}, {0.3, 0.9, 0.4});
  for (const double nu : {-0.9, 0.3, 0.5}) {
    const double G = 1 / (2 * (1 + nu));
    Matrix3d U = Matrix3d::Zero();
    Vector3d pull = Vector3d::Zero();
    for (std::size_t e = 0; e < 3; ++e) {
      const Vector3d a = t.corners[e] - t.centroid;
      const double h = a.dot(t.outward[e]);
      const double begin = std::atan2(a.dot(t.along[e]), h);
      const double end = std::atan2(a.dot(t.along[e]) + t.lengths[e], h);
      for (const auto& [s, w] : GaussRule(60)) {
        const double angle = begin + s * (end - begin);
        const Vector3d g = std::cos(angle) * t.outward[e] + std::sin(angle) * t.along[e];
        const double R = h / std::cos(angle);
        U += w * (end - begin) * R * ((3 - 4 * nu) * Matrix3d::Identity() + g * g.transpose());
        pull += w * (end - begin) * std::log(R) * g;
      }
    }
    U /= 16 * std::numbers::pi * G * (1 - nu);
    const Matrix3d T = (1 - 2 * nu) / (8 * std::numbers::pi * (1 - nu)) *
                       (pull * t.normal.transpose() - t.normal * pull.transpose());
    const auto exact = IntegrateKelvinOnItself(KelvinSolidConstants(nu), t);
    EXPECT_LT((exact.of_traction - U).norm(), 1e-13 * U.norm()) << "nu = " << nu;
    EXPECT_LT((exact.of_displacement - T).norm(), 1e-13) << "nu = " << nu;
  }
}

// Reference: far away only the resultant counts, with the triangle's moments of second order left
// over: (size / distance)^2 / 10 at the most.
TEST(KelvinTriangle, FarAwayATriangleIsAPoint) {
  const FlatTriangle t({0.1, 0, 0.2}, {1.2, 0.1, 0}, {0.3, 0.9, 0.4});
  for (const double distance : {1e2, 1e3, 1e4}) {
    const Vector3d x = t.centroid + distance * Vector3d(0.6, -0.64, 0.48);
    const Pair point = t.area * Kernels(0.3, x, t.centroid, t.normal);
    const auto exact = IntegrateKelvin(KelvinSolidConstants(0.3), t, x);
    const double within = 0.3 / (distance * distance) + 1e-15 * distance;
    EXPECT_LT((exact.of_traction - point.leftCols<3>()).norm(), within * point.norm());
    EXPECT_LT(
        (exact.of_displacement - point.rightCols<3>()).norm(),
        within * distance * point.rightCols<3>().norm() + within * point.rightCols<3>().norm());
  }
}

// Reference: solid geometry. A cube's face is seen from its centre under 4 pi / 6.
TEST(KelvinTriangle, SolidAngleIsThatOfTheCube) {
  const FlatTriangle a({1, -1, -1}, {1, 1, -1}, {1, 1, 1});
  const FlatTriangle b({1, -1, -1}, {1, 1, 1}, {1, -1, 1});
  const Vector3d centre = Vector3d::Zero();
  EXPECT_NEAR(SolidAngle(a, centre) + SolidAngle(b, centre), 2 * std::numbers::pi / 3, 1e-15);
  EXPECT_NEAR(SolidAngle(a, {2, 0, 0}) + SolidAngle(b, {2, 0, 0}), -2 * std::numbers::pi / 3,
              1e-15);
}

}  // namespace
}  // namespace palpate
