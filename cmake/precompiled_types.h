// Expressions that most sources write. Their types are made once, with the headers, instead of in
// each unit: that is a sixth of what compiling the house costs. Nobody calls this.
#pragma once

#include <array>
#include <chrono>
#include <istream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <Eigen/SparseCore>
#include <nlohmann/json.hpp>

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
  a = (b - c).normalized();
  a = s * (b - c).normalized();
  a = b.stableNormalized();
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
  a = Eigen::Vector2d::UnitX();
  a = s * (b + b.transpose().transpose());
  const Eigen::Matrix2d same = Eigen::Matrix2d::Constant(s), one = Eigen::Matrix2d::Identity();
  s = same(0, 0) + one(0, 0);
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
  Eigen::Vector2d flat = b.head<2>();
  a.head<2>() = flat;
  x.translation().head<2>() += flat;
  s = y.translation().stableNorm() + y.translation().norm() + b.head<2>().norm() + b.stableNorm();
  a = Eigen::Vector3d::UnitX();
  a = Eigen::Vector3d::UnitY();
  a = Eigen::Vector3d::UnitZ();
  a = y.linear() * b;
  m = n.transpose() * m * n;
  m = n.transpose() * m.transpose() * n;
  if (m == n && n.allFinite()) m = Eigen::Matrix3d::Constant(s);
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
  if ((b.array() < s).count() > 0) a = a.array().max(s);
}

template <typename Value>
inline void OfContainers(std::optional<Value>& maybe, std::vector<Value>& many, const Value& one) {
  const std::optional<Value> same = maybe;
  maybe = same;
  maybe = one;
  many.push_back(same.value_or(one));
  const std::vector<Value> copy(many);
  many = copy;
  if (!many.empty()) many.resize(1, many.back());
  for (const Value& each : copy) many.front() = each;
}

// Instantiates the initialisation and the copies of structure members that most sources use.
inline void OfMembers(Eigen::Vector3f& f, const Eigen::Vector3d& d,
                      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>& rows,
                      Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, 0, 96, 96>& patch,
                      Eigen::Matrix<double, 6, 6>& six, std::vector<std::array<int, 4>>& cells,
                      std::vector<std::vector<Eigen::Vector2d>>& outlines) {
  f = Eigen::Vector3f::Zero();
  f = d.cast<float>();
  const auto more = rows;
  rows = more;
  const auto same = patch;
  patch = same;
  six = Eigen::Matrix<double, 6, 6>::Zero();
  six = Eigen::Matrix<double, 6, 6>::Identity();
  const auto kept = cells;
  cells = kept;
  cells.push_back({});
  const auto all = outlines;
  outlines = all;
  outlines.emplace_back();
}

template <typename Json>
inline void OfJson(Json& json, const Json& other, std::istream& file, std::string& text) {
  json = Json::parse(text);
  json = Json::parse(file);
  json["key"] = text;
  json["key"] = 1.0;
  json["key"] = {1.0, 2.0};
  json.push_back(other);
  json.at("key") = other.at("key");
  const Json copy(other);
  if (copy.contains("key") && copy == other && copy["key"] == "text") text = copy.dump();
  for (const Json& each : copy) text = each.dump(1) + each.template get<std::string>();
  for (const auto& [key, value] : copy.items()) {
    json["key"] = value.template get<double>() + value.template get<int>();
  }
}

inline void OfEverything(nlohmann::json& json, nlohmann::ordered_json& ordered, std::istream& file,
                         std::string& text, std::optional<Eigen::Isometry3d>& x,
                         std::optional<double>& number, std::vector<double>& numbers,
                         std::optional<Eigen::Vector2d>& a, std::vector<Eigen::Vector2d>& as,
                         std::optional<Eigen::Vector3d>& b, std::vector<Eigen::Vector3d>& bs,
                         std::optional<Eigen::Vector3f>& c, std::vector<long>& whole,
                         std::map<std::string, std::size_t>& counts) {
  OfJson(json, nlohmann::json(), file, text);
  OfJson(ordered, nlohmann::ordered_json(), file, text);
  OfContainers(number, numbers, 1.0);
  OfContainers(a, as, Eigen::Vector2d(1, 1));
  OfContainers(b, bs, Eigen::Vector3d(1, 1, 1));
  if (x && c && !whole.empty()) x = Eigen::Isometry3d::Identity(), whole.push_back(1);
  ++counts[text];
}

}  // namespace palpate::precompiled
