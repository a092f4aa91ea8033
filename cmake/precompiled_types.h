// Expressions that most sources write. Their types are made once, with the headers, instead of in
// each unit: that is a sixth of what compiling the house costs. Nobody calls this.
#pragma once

#include <chrono>

#include <Eigen/Dense>

namespace palpate::precompiled {

inline void OfTime(std::chrono::steady_clock::time_point& a,
                   std::chrono::system_clock::time_point& b, double& s) {
  a += std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(s));
  s = std::chrono::duration<double>(a - a).count() + std::chrono::duration<double>(b - b).count();
  if (a < a + std::chrono::milliseconds(1)) b += std::chrono::seconds(1);
}

template <typename Vector>
inline void OfVectors(Vector& a, const Vector& b, const Vector& c, double& s) {
  a = b + c;
  a = b - c;
  a = -b;
  a = s * b;
  a = b * s;
  a = b / s;
  a += b;
  a -= b;
  a += s * b;
  a -= s * b;
  a *= s;
  a /= s;
  a = b + s * c;
  a = b - s * c;
  a = s * (b + c);
  a = s * (b - c);
  a = (b - c) / s;
  a = (b - a) + s * (c - b);
  a = s * a + s * b;
  a = b + c / s;
  a = b + c + a;
  a = b - c - a;
  a = b.cwiseMin(c);
  a = b.cwiseMax(c);
  a = b.cwiseAbs();
  a = b.cwiseProduct(c);
  a = b.normalized();
  a = Vector::Zero(b.size());
  a = Vector::Constant(b.size(), s);
  a.setZero();
  s = b.dot(c) + b.norm() + b.squaredNorm() + (b - c).norm() + (b - c).squaredNorm() +
      (b - a).dot(c) + a.dot(b - c);
  s = (b + c).norm() + (s * b).norm() + (b - c).dot(b - a) + b.sum() + b.mean() + b.minCoeff() +
      b.maxCoeff();
  s = b.cwiseAbs().maxCoeff() + b.cwiseAbs().sum() + b.template lpNorm<Eigen::Infinity>() + b.x();
  if (b.allFinite() && b == c && b != c && b.isZero()) a.normalize();
}

inline void OfPlanes(Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Matrix2d& m,
                     double& s) {
  OfVectors(a, b, b, s);
  a = m * b;
  a = m.transpose() * b;
  a = m.inverse() * b;
  s = m.determinant() + m.trace() + m(0, 1);
  a = Eigen::Vector2d(s, s);
}

inline void OfSpace(Eigen::Vector3d& a, const Eigen::Vector3d& b, Eigen::Matrix3d& m,
                    const Eigen::Matrix3d& n, Eigen::Isometry3d& x, const Eigen::Isometry3d& y,
                    double& s) {
  OfVectors(a, b, b, s);
  a = b.cross(a);
  s = b.cross(a).norm() + b.dot(a.cross(b)) + (a - b).cross(b).dot(a) + (a - b).cross(a - b).norm();
  a = (b - a).cross(b - a);
  a = b.cross(a).normalized();
  a = (b - a).normalized();
  a = m * b;
  a = m * (b - a);
  a = m * b + a;
  a = s * (m * b) + a;
  a = m.transpose() * b;
  a = m.transpose() * (b - a);
  a = b - s * b.dot(a) * a;
  a = b.dot(a) * a;
  a = m.col(0);
  m.col(0) = b;
  m = n;
  m = n * m;
  m = n * m.transpose();
  m = n.transpose() * m;
  m = s * n;
  m += n;
  m += s * n;
  m = n - m;
  m = b * a.transpose();
  m += s * b * a.transpose();
  m = n.inverse();
  m = n.transpose();
  m = Eigen::Matrix3d::Identity();
  m = Eigen::Matrix3d::Zero();
  m = s * Eigen::Matrix3d::Identity();
  s = n.determinant() + n.trace() + b.dot(m * a) + n.norm() + n(0, 1) + n.col(0).dot(b) +
      n.row(0).dot(b);
  a = x * b;
  x = y * x;
  x = y.inverse();
  x = y.inverse() * x;
  a = y.inverse() * b;
  a = x.translation();
  x.translation() = b;
  x.linear() = n;
  m = x.linear();
  m = x.rotation();
  a = x.linear() * b;
  a = x.linear().transpose() * b;
  a = x.linear().col(0);
  x = Eigen::Isometry3d::Identity();
  x = Eigen::Translation3d(b) * y;
  m = Eigen::AngleAxisd(s, b).toRotationMatrix();
  x.rotate(Eigen::AngleAxisd(s, b));
  const Eigen::Quaterniond q(n);
  a = q * b;
  m = q.toRotationMatrix();
  const Eigen::Vector2d flat = b.head<2>();
  a.head<2>() = flat;
}

inline void OfAnySize(Eigen::VectorXd& a, const Eigen::VectorXd& b, Eigen::MatrixXd& m,
                      const Eigen::MatrixXd& n, double& s) {
  OfVectors(a, b, b, s);
  a = n * b;
  a.noalias() = n * b;
  a = n.transpose() * b;
  a.noalias() = n.transpose() * b;
  a = b - n * b;
  a = b.head(1);
  a = b.segment<3>(0);
  a.segment<3>(0) = b.segment<3>(0);
  a.segment<3>(0) += b.segment<3>(0);
  a.segment(0, 1) = b.segment(0, 1);
  a.head(1) = b.tail(1);
  m = n * m;
  m.noalias() = n * m;
  m = n.transpose() * m;
  m = n * m.transpose();
  m = n.transpose();
  m = s * n;
  m += n;
  m -= n;
  m = n + m;
  m = n - m;
  m = Eigen::MatrixXd::Zero(1, 1);
  m = Eigen::MatrixXd::Identity(1, 1);
  m.setZero();
  m.col(0) = b;
  a = n.col(0);
  m.row(0) = b.transpose();
  m.block(0, 0, 1, 1) = n;
  m.block<3, 3>(0, 0) = n.block<3, 3>(0, 0);
  m.block<3, 3>(0, 0) += n.block<3, 3>(0, 0);
  s = n.norm() + (n - m).norm() + n.maxCoeff() + n.cwiseAbs().maxCoeff() + b.dot(n * a) + n(0, 0);
  if (n.allFinite()) m.resize(1, 1);
}

}  // namespace palpate::precompiled
