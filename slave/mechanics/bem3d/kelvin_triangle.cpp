#include "slave/mechanics/bem3d/kelvin_triangle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A triangle's corners seen from x.
struct Corners {
  std::array<Vector3d, 3> r;
  std::array<double, 3> length;

  Corners(const FlatTriangle& t, const Vector3d& x)
      : r{t.corners[0] - x, t.corners[1] - x, t.corners[2] - x},
        length{r[0].norm(), r[1].norm(), r[2].norm()} {}
};

// Van Oosterom and Strackee (1983), eq. (8); `volume` is the triple product of the corners.
double Angle(const Corners& c, double volume) {
  const auto& [r, length] = c;
  const double cosine = length[0] * length[1] * length[2] + r[0].dot(r[1]) * length[2] +
                        r[1].dot(r[2]) * length[0] + r[2].dot(r[0]) * length[1];
  return 2 * std::atan2(volume, cosine);
}

// Integrals along an edge, s from s_a to s_b, r^2 = s^2 + p^2.
struct EdgeIntegrals {
  double log_r;    // of 1 / r
  double inverse;  // of 1 / r^3
  double radius;   // of s / r = r_b - r_a
  double decay;    // of s / r^3 = 1 / r_a - 1 / r_b

  EdgeIntegrals(double s_a, double length, double p2, double r_a, double r_b) {
    const double s_b = s_a + length;
    const bool beside = s_a * s_b < 0;  // the foot of the perpendicular lies on the edge
    const double near = std::min(std::abs(s_a), std::abs(s_b));
    const double excess = (beside ? 0.0 : 2 * near) + p2 / (r_a + std::abs(s_a)) +
                          p2 / (r_b + std::abs(s_b));  // r_a + r_b - length
    const double product = r_a * r_b;
    const double slope = length * (s_a + s_b);
    log_r = std::log1p(2 * length / excess);
    inverse = beside ? (s_b / r_b - s_a / r_a) / p2 : slope / (product * (s_b * r_a + s_a * r_b));
    radius = slope / (r_a + r_b);
    decay = radius / product;
  }
};

// Integrals over the triangle of what the kernels are made of, d = r . n and q = r - d n.
struct TriangleIntegrals {
  double d;
  double inverse_r = 0;                    // of 1 / r
  double solid_angle = 0;                  // of d / r^3
  Vector3d pull = Vector3d::Zero();        // of q / r^3
  Vector3d across = Vector3d::Zero();      // of -3 q / r^5
  Matrix3d directions = Matrix3d::Zero();  // of q q^T / r^3
  Matrix3d fluxes = Matrix3d::Zero();      // of 3 d q q^T / r^5
  std::array<Matrix3d, 3> squares;         // of q q^T / r^3 along the edges

  TriangleIntegrals(const FlatTriangle& t, const Vector3d& x, bool on_itself) {
    const Corners corners(t, x);
    const auto& [r, length] = corners;
    d = on_itself ? 0 : r[0].dot(t.normal);
    if (!on_itself) solid_angle = Angle(corners, 2 * t.area * d);
    for (std::size_t e = 0; e < 3; ++e) {
      const double s_a = r[e].dot(t.along[e]);
      const double h = r[e].dot(t.outward[e]);
      const double p2 = h * h + d * d;
      const EdgeIntegrals I(s_a, t.lengths[e], p2, length[e], length[(e + 1) % 3]);
      const Vector3d& nu = t.outward[e];
      const Vector3d decay = h * I.inverse * nu + I.decay * t.along[e];  // of q / r^3
      inverse_r += h * I.log_r;
      pull -= nu * I.log_r;
      across += nu * I.inverse;
      directions -= nu * (h * I.log_r * nu + I.radius * t.along[e]).transpose();
      fluxes -= d * nu * decay.transpose();
      squares[e] =
          h * nu * decay.transpose() +
          t.along[e] * (h * I.decay * nu + (I.log_r - p2 * I.inverse) * t.along[e]).transpose();
    }
    inverse_r -= d * solid_angle;
    const Matrix3d in_plane = Matrix3d::Identity() - t.normal * t.normal.transpose();
    directions += inverse_r * in_plane;
    fluxes += solid_angle * in_plane;
  }
};

// The integral of T_ij, for a density that is constant.
Matrix3d Constant(const KelvinSolidConstants& c, const TriangleIntegrals& I, const Vector3d& n) {
  const Vector3d slant = -I.d * I.d * I.across - c.t_skew * I.pull;
  const Vector3d slant_skewed = -I.d * I.d * I.across + c.t_skew * I.pull;
  Matrix3d T = I.fluxes + slant * n.transpose() + n * slant_skewed.transpose();
  T += (3 * I.solid_angle - I.fluxes.trace()) * n * n.transpose();
  T.diagonal().array() += c.t_skew * I.solid_angle;
  return -c.t * T;
}

// The integral of T_ij (q . slope), for a density that grows along `slope` in the triangle's plane.
Matrix3d Growing(const KelvinSolidConstants& c, const TriangleIntegrals& I, const FlatTriangle& t,
                 const Vector3d& slope) {
  const Vector3d& n = t.normal;
  Matrix3d T = slope * I.pull.transpose() + I.pull * slope.transpose();
  for (std::size_t e = 0; e < 3; ++e) T -= t.outward[e].dot(slope) * I.squares[e];
  T *= I.d;
  const Vector3d flux = I.d * (I.fluxes * slope);
  const Vector3d skew = c.t_skew * (I.directions * slope);
  T += (flux - skew) * n.transpose() + n * (flux + skew).transpose();
  T -= I.d * I.d * I.d * I.across.dot(slope) * n * n.transpose();
  T.diagonal().array() += c.t_skew * I.d * I.pull.dot(slope);
  return -c.t * T;
}

KelvinSolidBlocks Combine(const KelvinSolidConstants& c, const TriangleIntegrals& I,
                          const FlatTriangle& t, const Vector3d& x) {
  const Vector3d& n = t.normal;
  KelvinSolidBlocks blocks;
  blocks.of_traction =
      I.directions + I.d * (I.pull * n.transpose() + n * (I.pull + I.solid_angle * n).transpose());
  blocks.of_traction.diagonal().array() += c.u_mean * I.inverse_r;
  blocks.of_traction *= c.u;
  blocks.of_displacement = Constant(c, I, n);
  for (std::size_t k = 0; k < 2; ++k) {
    const std::size_t opposite = (k + 1) % 3;
    const Vector3d slope = -t.lengths[opposite] / (2 * t.area) * t.outward[opposite];
    blocks.of_corner[k] =
        Growing(c, I, t, slope) - slope.dot(t.centroid - x) * blocks.of_displacement;
  }
  blocks.of_corner[2] = -blocks.of_corner[0] - blocks.of_corner[1];
  return blocks;
}

}  // namespace

FlatTriangle::FlatTriangle(const Vector3d& a, const Vector3d& b, const Vector3d& c)
    : corners{a, b, c}, centroid((a + b + c) / 3) {
  const Vector3d doubled = (b - a).cross(c - a);
  area = 0.5 * doubled.norm();
  normal = doubled.stableNormalized();
  for (std::size_t e = 0; e < 3; ++e) {
    const Vector3d edge = corners[(e + 1) % 3] - corners[e];
    lengths[e] = edge.norm();
    along[e] = edge.stableNormalized();
    outward[e] = along[e].cross(normal);
  }
}

double SolidAngle(const FlatTriangle& triangle, const Vector3d& x) {
  const Corners corners(triangle, x);
  return Angle(corners, 2 * triangle.area * corners.r[0].dot(triangle.normal));
}

KelvinSolidConstants::KelvinSolidConstants(double nu)
    : u((1 + nu) / (8 * std::numbers::pi * (1 - nu))),
      t(1 / (8 * std::numbers::pi * (1 - nu))),
      u_mean(3 - 4 * nu),
      t_skew(1 - 2 * nu) {}

KelvinSolidBlocks IntegrateKelvin(const KelvinSolidConstants& constants,
                                  const FlatTriangle& triangle, const Vector3d& x) {
  return Combine(constants, TriangleIntegrals(triangle, x, false), triangle, x);
}

KelvinSolidBlocks IntegrateKelvinOnItself(const KelvinSolidConstants& constants,
                                          const FlatTriangle& triangle) {
  return Combine(constants, TriangleIntegrals(triangle, triangle.centroid, true), triangle,
                 triangle.centroid);
}

}  // namespace palpate
