#include "slave/mechanics/bem3d/kelvin_triangle.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
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

// Integrals over the triangle of what the kernels are made of, d = r . n.
struct TriangleIntegrals {
  double inverse_r = 0;                    // of 1 / r
  double solid_angle = 0;                  // of d / r^3
  Vector3d pull = Vector3d::Zero();        // of the in-plane part of r / r^3
  Matrix3d directions = Matrix3d::Zero();  // of r r^T / r^3
  Matrix3d fluxes = Matrix3d::Zero();      // of 3 d r r^T / r^5

  TriangleIntegrals(const FlatTriangle& t, const Vector3d& x, bool on_itself) {
    const Corners corners(t, x);
    const auto& [r, length] = corners;
    const double d = on_itself ? 0 : r[0].dot(t.normal);
    if (!on_itself) solid_angle = Angle(corners, 2 * t.area * d);
    Matrix3d turns = Matrix3d::Zero();
    Matrix3d decays = Matrix3d::Zero();
    Vector3d across = Vector3d::Zero();
    double bulge = 0;
    for (std::size_t e = 0; e < 3; ++e) {
      const std::size_t next = (e + 1) % 3;
      const double s_a = r[e].dot(t.along[e]);
      const double h = r[e].dot(t.outward[e]);
      const EdgeIntegrals I(s_a, t.lengths[e], h * h + d * d, length[e], length[next]);
      const Vector3d& nu = t.outward[e];
      inverse_r += h * I.log_r;
      pull -= nu * I.log_r;
      turns += nu * (h * I.log_r * nu + I.radius * t.along[e]).transpose();
      decays += nu * (h * I.inverse * nu + I.decay * t.along[e]).transpose();
      across += nu * I.inverse;
      bulge += h * I.inverse;
    }
    const Vector3d& n = t.normal;
    const double depth = d * solid_angle;
    inverse_r -= depth;
    directions = -turns + d * (pull * n.transpose() + n * pull.transpose());
    directions += (depth - inverse_r) * n * n.transpose();
    directions.diagonal().array() += inverse_r;
    fluxes = -d * decays - d * d * (across * n.transpose() + n * across.transpose());
    fluxes += d * bulge * n * n.transpose();
    fluxes.diagonal().array() += solid_angle;
  }
};

KelvinSolidBlocks Combine(const KelvinSolidConstants& c, const TriangleIntegrals& I,
                          const Vector3d& n) {
  KelvinSolidBlocks blocks;
  blocks.of_traction = c.u * I.directions;
  blocks.of_traction.diagonal().array() += c.u * c.u_mean * I.inverse_r;
  const Matrix3d skew = I.pull * n.transpose() - n * I.pull.transpose();
  blocks.of_displacement = -c.t * (I.fluxes - c.t_skew * skew);
  blocks.of_displacement.diagonal().array() -= c.t * c.t_skew * I.solid_angle;
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
  return Combine(constants, TriangleIntegrals(triangle, x, false), triangle.normal);
}

KelvinSolidBlocks IntegrateKelvinOnItself(const KelvinSolidConstants& constants,
                                          const FlatTriangle& triangle) {
  return Combine(constants, TriangleIntegrals(triangle, triangle.centroid, true), triangle.normal);
}

}  // namespace palpate
