// Shape functions of tetrahedra with four or ten nodes, in volume coordinates, and their integrals.
#pragma once

#include <span>

#include <Eigen/Core>

#include "slave/mechanics/tet_mesh.h"

namespace palpate {

// A rule on the tetrahedron, weights add up to one: one point is exact for four nodes, four points
// (degree 2) for the linear stiffness of ten.
struct QuadraturePoint {
  Eigen::Vector4d bary;
  double weight = 0;
};
std::span<const QuadraturePoint> QuadratureOf(int nodes_per_element);

using ShapeValues = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxNodes, 1>;
ShapeValues ShapesAt(int nodes_per_element, const Eigen::Vector4d& bary);

// Integrals of shape functions over an element of volume one: of each, and of products of two.
ShapeValues ShapeIntegrals(int nodes_per_element);
Eigen::MatrixXd ShapeProducts(int nodes_per_element);

}  // namespace palpate
