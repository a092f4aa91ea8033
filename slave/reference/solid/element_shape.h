// Elements whose shape functions are polynomials given by their values at a lattice of nodes.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace palpate::simulation {

// On the reference element: the cube [0, 1]^dims, or the simplex where the coordinates' sum is at
// most 1. Nodes are at `lattice` / degree, with the last coordinate varying fastest. The Gauss rule
// has degree + 1 points in each direction; the simplex is a cube with one side collapsed.
struct ElementShape {
  static ElementShape Cube(int dims, int degree);
  static ElementShape Tetrahedron(int degree);

  [[nodiscard]] int dims() const { return static_cast<int>(lattice.rows()); }
  [[nodiscard]] int nodes() const { return static_cast<int>(lattice.cols()); }
  [[nodiscard]] int points() const { return static_cast<int>(weights.size()); }

  Eigen::MatrixXi lattice;    // dims x nodes
  Eigen::MatrixXd values;     // of the functions: nodes x points
  Eigen::MatrixXd gradients;  // nodes x (dims per point)
  Eigen::VectorXd weights;    // per point
};

// An element in its rest position.
struct PlacedElement {
  // `places`: dims x nodes. Throws std::invalid_argument: a point of the rule has no volume.
  PlacedElement(const ElementShape& shape, const Eigen::MatrixXd& places, std::vector<int> numbers);

  std::vector<int> nodes;
  Eigen::MatrixXd gradients;  // nodes x (dims per point) [1 / length]
  Eigen::VectorXd weights;    // volume of each point
};

}  // namespace palpate::simulation
