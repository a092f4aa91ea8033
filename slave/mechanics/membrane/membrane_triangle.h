// One triangle of a membrane in space: its stiffnesses and the volume that it encloses.
#pragma once

#include <array>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace palpate {

using TriangleMatrix = Eigen::Matrix<double, 9, 9>;  // node by node, x y z

class MembraneTriangle {
 public:
  explicit MembraneTriangle(const std::array<Eigen::Vector3d, 3>& p);

  [[nodiscard]] double area() const { return area_; }  // [m^2]
  [[nodiscard]] const Eigen::Vector3d& normal() const { return normal_; }

  // Plane stress at constant strain, per E h.
  [[nodiscard]] TriangleMatrix Elastic(double poisson_ratio) const;
  // int grad u : grad u.
  [[nodiscard]] TriangleMatrix Tension() const;
  // Second derivative of p0 . (p1 x p2) / 6, the volume of the cone from the origin.
  [[nodiscard]] TriangleMatrix Volume() const;

 private:
  std::array<Eigen::Vector3d, 3> p_;
  Eigen::Vector3d normal_;
  double area_ = 0;
  Eigen::Matrix3d gradients_;  // column k: of node k's shape function [1/m]
};

}  // namespace palpate
