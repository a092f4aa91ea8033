#include "slave/mechanics/bem3d/kelvin_triangle.h"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

using Blocks = Eigen::Matrix<double, 3, 15>;  // U, T, and T times b_k - 1 / 3

// The kernels as they are printed, one point at a time.
Eigen::Matrix<double, 3, 6> Kernels(double nu, const Vector3d& x, const Vector3d& y,
                                    const Vector3d& n) {
  const double G = 1 / (2 * (1 + nu));
  const double r = (y - x).norm();
  const Vector3d g = (y - x) / r;
  const double dr_dn = g.dot(n);
  Eigen::Matrix<double, 3, 6> both;
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

Vector3d Barycentric(const FlatTriangle& t, const Vector3d& y) {
  Vector3d b;
  for (int k = 0; k < 3; ++k) {
    const auto next = static_cast<std::size_t>((k + 1) % 3);
    const auto last = static_cast<std::size_t>((k + 2) % 3);
    b[k] = (t.corners[next] - y).cross(t.corners[last] - y).dot(t.normal) / (2 * t.area);
  }
  return b;
}

// Over a part of the triangle `t`, by a product rule in coordinates that collapse the square to it.
Blocks ByRule(double nu, const FlatTriangle& t, const FlatTriangle& part, const Vector3d& x) {
  static const auto kRule = GaussRule(10);
  Blocks sum = Blocks::Zero();
  for (const auto& [u, wu] : kRule) {
    for (const auto& [v, wv] : kRule) {
      const Vector3d y = part.corners[0] + u * ((1 - v) * (part.corners[1] - part.corners[0]) +
                                                v * (part.corners[2] - part.corners[0]));
      const auto kernels = Kernels(nu, x, y, t.normal);
      const Vector3d b = Barycentric(t, y);
      const double weight = 2 * part.area * wu * wv * u;
      sum.leftCols<6>() += weight * kernels;
      for (int k = 0; k < 3; ++k) {
        sum.middleCols<3>(6 + 3 * k) += weight * (b[k] - 1.0 / 3) * kernels.rightCols<3>();
      }
    }
  }
  return sum;
}

// Halves the triangle's edges until the parts agree with the whole.
Blocks Adaptive(double nu, const FlatTriangle& t, const FlatTriangle& part, const Vector3d& x,
                const Blocks& whole, double within, int depth) {
  const auto& [a, b, c] = part.corners;
  const Vector3d ab = (a + b) / 2, bc = (b + c) / 2, ca = (c + a) / 2;
  const std::array<FlatTriangle, 4> parts{FlatTriangle(a, ab, ca), FlatTriangle(ab, b, bc),
                                          FlatTriangle(ca, bc, c), FlatTriangle(ab, bc, ca)};
  std::array<Blocks, 4> sums;
  Blocks sum = Blocks::Zero();
  for (std::size_t k = 0; k < 4; ++k) sum += sums[k] = ByRule(nu, t, parts[k], x);
  if ((sum - whole).norm() <= within || depth == 0) return sum;
  sum.setZero();
  for (std::size_t k = 0; k < 4; ++k) {
    sum += Adaptive(nu, t, parts[k], x, sums[k], within / 2, depth - 1);
  }
  return sum;
}

// Of either block, relative to itself; T relative to 1 / r^2 where it vanishes, as it does in the
// triangle's plane at nu = 0.5.
double Discrepancy(double nu, const FlatTriangle& t, const Vector3d& x) {
  const Blocks first = ByRule(nu, t, t, x);
  const Blocks quadrature = Adaptive(nu, t, t, x, first, 1e-12 * first.norm(), 24);
  const KelvinSolidConstants constants(nu);
  const KelvinSolidBlocks exact = IntegrateKelvin(constants, t, x);
  const double usual = constants.t * t.area / (t.centroid - x).squaredNorm();
  const auto discrepancy = [&](const Matrix3d& integral, int column, double scale) {
    const Matrix3d expected = quadrature.middleCols<3>(column);
    return (integral - expected).norm() / std::max(expected.norm(), scale);
  };
  double worst =
      std::max(discrepancy(exact.of_traction, 0, 0), discrepancy(exact.of_displacement, 3, usual));
  for (int k = 0; k < 3; ++k) {
    worst = std::max(worst,
                     discrepancy(exact.of_corner[static_cast<std::size_t>(k)], 6 + 3 * k, usual));
  }
  return worst;
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

// Reference as above. Across a sliver the potentials of its long edges cancel, once for the width
// and once for the slope: rounding grows with the square of length over width.
TEST(KelvinTriangle, IntegralsOverSliversAgreeWithAdaptiveQuadrature) {
  for (const double width : {1e-2, 1e-4}) {
    const FlatTriangle t({0, 0, 0}, {1, 0, 0}, {0.4, width, 0});
    for (const Vector3d& x : {Vector3d(0.5, 0.02, 0.01), Vector3d(-0.3, 0, 0.2),
                              Vector3d(1.5, 0, 0), Vector3d(0.4, -0.05, 0)}) {
      EXPECT_LT(Discrepancy(0.3, t, x), 1e-10 + 1e-16 / (width * width))
          << "width " << width << " at " << x.transpose();
    }
  }
}

// Reference: in polar coordinates about the centroid 1 / r leaves R(angle), the principal value of
// r / r^3 leaves ln R(angle) times the direction (the disc around the point vanishes by symmetry),
// and what grows linearly its value at the rim. Gauss's rule with 60 points on each edge's angle is
// exact to rounding.
TEST(KelvinTriangle, IntegralsOnItselfAreThoseInPolarCoordinates) {
  const FlatTriangle t({0.1, 0, 0.2}, {1.2, 0.1, 0}, {0.3, 0.9, 0.4});
  for (const double nu : {-0.9, 0.3, 0.5}) {
    const double G = 1 / (2 * (1 + nu));
    Matrix3d U = Matrix3d::Zero();
    Vector3d pull = Vector3d::Zero();
    Matrix3d grown = Matrix3d::Zero();  // column k: of (b_k - 1 / 3) r / r^3
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
        const Vector3d b = Barycentric(t, t.centroid + R * g) - Vector3d::Constant(1.0 / 3);
        grown += w * (end - begin) * g * b.transpose();
      }
    }
    U /= 16 * std::numbers::pi * G * (1 - nu);
    const double skew = (1 - 2 * nu) / (8 * std::numbers::pi * (1 - nu));
    const auto turned = [&](const Vector3d& v) -> Matrix3d {
      return skew * (v * t.normal.transpose() - t.normal * v.transpose());
    };
    const auto exact = IntegrateKelvinOnItself(KelvinSolidConstants(nu), t);
    EXPECT_LT((exact.of_traction - U).norm(), 1e-13 * U.norm()) << "nu = " << nu;
    EXPECT_LT((exact.of_displacement - turned(pull)).norm(), 1e-13) << "nu = " << nu;
    for (int k = 0; k < 3; ++k) {
      const auto& of_corner = exact.of_corner[static_cast<std::size_t>(k)];
      EXPECT_LT((of_corner - turned(grown.col(k))).norm(), 1e-13) << "nu = " << nu;
    }
  }
}

// Reference: far away only the resultant counts, with the triangle's moments of second order left
// over: (size / distance)^2 / 10 at the most.
TEST(KelvinTriangle, FarAwayATriangleIsAPoint) {
  const FlatTriangle t({0.1, 0, 0.2}, {1.2, 0.1, 0}, {0.3, 0.9, 0.4});
  for (const double distance : {1e2, 1e3, 1e4}) {
    const Vector3d x = t.centroid + distance * Vector3d(0.6, -0.64, 0.48);
    const Eigen::Matrix<double, 3, 6> point = t.area * Kernels(0.3, x, t.centroid, t.normal);
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
