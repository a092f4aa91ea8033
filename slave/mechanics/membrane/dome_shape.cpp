#include "slave/mechanics/membrane/dome_shape.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <string>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>

#include "shared/text/text.h"

namespace palpate {
namespace {

using Quadric = Eigen::Matrix<double, 9, 1>;  // x2 y2 z2 xy xz yz x y z: a . q = 1

Quadric Monomials(const Eigen::Vector3d& p) {
  Quadric m;
  m << p.cwiseProduct(p), p.x() * p.y(), p.x() * p.z(), p.y() * p.z(), p;
  return m;
}

Eigen::Matrix3d SquarePart(const Quadric& q) {
  Eigen::Matrix3d m;
  m << q[0], q[3] / 2, q[4] / 2, q[3] / 2, q[1], q[5] / 2, q[4] / 2, q[5] / 2, q[2];
  return m;
}

// The ellipsoid in the scaled coordinates in which it was fitted.
Ellipsoid EllipsoidOf(const Quadric& q) {
  const Eigen::Matrix3d square = SquarePart(q);
  Ellipsoid ellipsoid;
  ellipsoid.centre = -square.inverse() * q.tail<3>() / 2;
  const double level = 1 + ellipsoid.centre.dot(square * ellipsoid.centre);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(square / level);
  if (!(ellipsoid.centre.allFinite() && axes.eigenvalues()[0] > 0)) {
    throw std::invalid_argument("membrane: the points at rest do not lie on an ellipsoid");
  }
  ellipsoid.semi_axes = axes.operatorInverseSqrt();
  return ellipsoid;
}

// Nodes at `place` of (radius share, angle), ring by ring about the centre, the outermost held;
// triangles counter-clockwise.
MembraneShape MakeRings(int rings, const std::function<Eigen::Vector3d(double, double)>& place) {
  if (rings < 1 || rings > 1000) RefuseValue("rings", rings, "1 to 1000");
  MembraneShape made;
  auto& [nodes, triangles] = made.surface;
  nodes.push_back(place(0, 0));
  const auto first = [](int ring) { return ring == 0 ? 0 : 1 + 3 * ring * (ring - 1); };
  for (int ring = 1; ring <= rings; ++ring) {
    const int count = 6 * ring;
    const int inner_count = std::max(1, count - 6);
    for (int k = 0; k < count; ++k) {
      nodes.push_back(place(static_cast<double>(ring) / rings, 2 * std::numbers::pi * k / count));
      // Sextant and step in it: the ring inside has one step fewer.
      const int sextant = k / ring;
      const int step = k % ring;
      const int outer = first(ring) + k;
      const int outer_next = first(ring) + (k + 1) % count;
      const int inner = first(ring - 1) + (sextant * (ring - 1) + step) % inner_count;
      triangles.push_back({outer, outer_next, inner});
      if (step < ring - 1) {
        const int inner_next = first(ring - 1) + (sextant * (ring - 1) + step + 1) % inner_count;
        triangles.push_back({inner, outer_next, inner_next});
      }
      if (ring == rings) made.held.push_back(outer);
    }
  }
  return made;
}

}  // namespace

Ellipsoid FitEllipsoid(std::span<const Eigen::Vector3d> points, double scatter) {
  if (points.size() < 9) {
    throw std::invalid_argument("membrane: " + std::to_string(points.size()) +
                                " points at rest: accepted is at least 9");
  }
  if (!(scatter > 0)) RefuseValue("scatter", scatter, "> 0");
  // About the mean, in units of the cloud's size, so that the squares are of order one.
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : points) mean += p / static_cast<double>(points.size());
  double size = 0;
  for (const auto& p : points) size += (p - mean).norm() / static_cast<double>(points.size());
  // The origin must not lie on the quadric: the mean of a shell does not.
  const auto rows = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd monomials(rows, 9);
  for (Eigen::Index i = 0; i < rows; ++i) {
    monomials.row(i) = Monomials((points[static_cast<std::size_t>(i)] - mean) / size);
  }
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(rows);
  Quadric q = Quadric::Zero();
  for (int pass = 0; pass < 20; ++pass) {
    const Eigen::MatrixXd weighted = weights.asDiagonal() * monomials;
    q = weighted.colPivHouseholderQr().solve(weights);
    const Eigen::Matrix3d square = SquarePart(q);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const Eigen::Vector3d p = monomials.row(i).tail<3>();
      const double slope = (2 * square * p + q.tail<3>()).norm();
      const double off = std::abs(monomials.row(i) * q - 1) / slope * size;
      weights[i] = off > scatter ? std::sqrt(scatter / off) : 1;
    }
  }
  Ellipsoid ellipsoid = EllipsoidOf(q);
  ellipsoid.centre = mean + size * ellipsoid.centre;
  ellipsoid.semi_axes *= size;
  return ellipsoid;
}

double DistanceOutside(const Ellipsoid& ellipsoid, const Eigen::Vector3d& p) {
  const Eigen::Matrix3d inverse = ellipsoid.semi_axes.inverse();
  const Eigen::Vector3d on_sphere = inverse * (p - ellipsoid.centre);
  const double radius = on_sphere.norm();
  return (radius - 1) * radius / (inverse * on_sphere).norm();
}

MembraneShape MeshFlatMembrane(double radius, int rings) {
  RequirePositive("radius", radius);
  return MakeRings(rings, [&](double share, double angle) {
    const double r = radius * share;
    return Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), 0);
  });
}

MembraneShape MeshDomedMembrane(const Ellipsoid& ellipsoid, const Eigen::Vector3d& axis, double rim,
                                int rings) {
  const Eigen::Vector3d e1 = axis.unitOrthogonal();
  const Eigen::Vector3d e2 = axis.cross(e1);
  const Eigen::Matrix3d inverse = ellipsoid.semi_axes.inverse();
  // The point of the ellipsoid that lies under this angle from the axis.
  const auto point = [&](double polar, double angle) -> Eigen::Vector3d {
    const Eigen::Vector3d ray = std::cos(polar) * axis + std::sin(polar) * std::cos(angle) * e1 +
                                std::sin(polar) * std::sin(angle) * e2;
    return ellipsoid.centre + ray / (inverse * ray).norm();
  };
  const auto above = [&](const Eigen::Vector3d& p) { return p.dot(axis) - rim; };
  if (!(above(point(0, 0)) > 0 && above(point(std::numbers::pi, 0)) < 0)) {
    RefuseValue("rim", rim, "a plane that cuts the ellipsoid along the axis");
  }
  return MakeRings(rings, [&](double share, double angle) {
    double low = 0;
    double high = std::numbers::pi;
    for (int k = 0; k < 60; ++k) {
      const double middle = (low + high) / 2;
      (above(point(middle, angle)) > 0 ? low : high) = middle;
    }
    return point(share * low, angle);
  });
}

}  // namespace palpate
