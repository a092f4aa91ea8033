// The rest shape of a measured membrane.
#pragma once

#include <cmath>
#include <span>
#include <stdexcept>
#include <string>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "shared/text/text.h"
#include "slave/mechanics/membrane/inflated_membrane.h"

namespace palpate::domes {

using Quadric = Eigen::Matrix<double, 9, 1>;  // x2 y2 z2 xy xz yz x y z: a . q = 1

inline Quadric Monomials(const Eigen::Vector3d& p) {
  Quadric m;
  m << p.cwiseProduct(p), p.x() * p.y(), p.x() * p.z(), p.y() * p.z(), p;
  return m;
}

inline Eigen::Matrix3d SquarePart(const Quadric& q) {
  Eigen::Matrix3d m;
  m << q[0], q[3] / 2, q[4] / 2, q[3] / 2, q[1], q[5] / 2, q[4] / 2, q[5] / 2, q[2];
  return m;
}

// The ellipsoid in the scaled coordinates in which it was fitted.
inline Ellipsoid EllipsoidOf(const Quadric& q) {
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

// The ellipsoid through `points`, by least squares of their algebraic distance, with robust weights
// (Huber, at `scatter` [m] from the surface). Throws std::invalid_argument: fewer than nine points,
// scatter not positive, or the fit is not an ellipsoid.
inline Ellipsoid FitEllipsoid(std::span<const Eigen::Vector3d> points, double scatter) {
  if (points.size() < 9) {
    throw std::invalid_argument("membrane: " + std::to_string(points.size()) +
                                " points at rest: expected at least 9");
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

}  // namespace palpate::domes
