#include "slave/reference/solid/element_shape.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include <Eigen/LU>

#include "shared/geometry/symmetric_eigen.h"

namespace palpate::simulation {
namespace {

using Eigen::MatrixXd;
using Eigen::MatrixXi;
using Eigen::VectorXd;

// Points of a rule, dims x points.
struct Rule {
  MatrixXd points;
  VectorXd weights;
};

// Returns the Gauss rule on [0, 1] (Golub and Welsch 1969).
Rule GaussRule(int count) {
  MatrixXd jacobi = MatrixXd::Zero(count, count);
  for (int k = 1; k < count; ++k) jacobi(k, k - 1) = k / std::sqrt(4.0 * k * k - 1);
  const SymmetricEigen eigen = EigenOf(jacobi);
  return {(0.5 * (eigen.values.array() + 1)).matrix().transpose(),
          eigen.vectors.row(0).array().square()};
}

// Returns all index tuples below `count`, with the last index varying fastest.
MatrixXi Lattice(int dims, int count) {
  MatrixXi lattice(dims, static_cast<int>(std::lround(std::pow(count, dims))));
  for (int i = 0; i < lattice.cols(); ++i) {
    for (int d = dims - 1, rest = i; d >= 0; --d, rest /= count) lattice(d, i) = rest % count;
  }
  return lattice;
}

Rule CubeRule(int dims, int count) {
  const Rule line = GaussRule(count);
  const MatrixXi places = Lattice(dims, count);
  Rule rule{MatrixXd(dims, places.cols()), VectorXd::Ones(places.cols())};
  for (int q = 0; q < places.cols(); ++q) {
    for (int d = 0; d < dims; ++d) {
      rule.points(d, q) = line.points(0, places(d, q));
      rule.weights[q] *= line.weights[places(d, q)];
    }
  }
  return rule;
}

// Powers x^0 to x^degree and their derivatives.
struct Powers {
  Powers(double x, int degree) : value(degree + 1), slope(degree + 1) {
    for (int k = 0; k <= degree; ++k) {
      value[k] = std::pow(x, k);
      slope[k] = k == 0 ? 0 : k * std::pow(x, k - 1);
    }
  }
  VectorXd value, slope;
};

// Returns the monomials with exponents in the columns of `exponents`: values (`along` < 0) or
// derivatives along one direction, one row per point.
MatrixXd Monomials(const MatrixXi& exponents, const MatrixXd& places, int along) {
  MatrixXd result = MatrixXd::Ones(places.cols(), exponents.cols());
  for (int d = 0; d < places.rows(); ++d) {
    for (int q = 0; q < places.cols(); ++q) {
      const Powers powers(places(d, q), exponents.maxCoeff());
      const VectorXd& factor = d == along ? powers.slope : powers.value;
      for (int m = 0; m < exponents.cols(); ++m) result(q, m) *= factor[exponents(d, m)];
    }
  }
  return result;
}

// The monomials with the lattice's exponents span the space of shape functions.
ElementShape ShapeOf(const MatrixXi& lattice, int degree, const Rule& rule) {
  const MatrixXd nodes = lattice.cast<double>() / degree;
  const MatrixXd coefficients = Monomials(lattice, nodes, -1).inverse();
  const int dims = static_cast<int>(lattice.rows()), points = static_cast<int>(rule.weights.size());
  ElementShape shape{lattice, {}, MatrixXd(lattice.cols(), dims * points), rule.weights};
  shape.values = (Monomials(lattice, rule.points, -1) * coefficients).transpose();
  for (int d = 0; d < dims; ++d) {
    const MatrixXd slopes = (Monomials(lattice, rule.points, d) * coefficients).transpose();
    for (int q = 0; q < points; ++q) shape.gradients.col(dims * q + d) = slopes.col(q);
  }
  return shape;
}

}  // namespace

ElementShape ElementShape::Cube(int dims, int degree) {
  return ShapeOf(Lattice(dims, degree + 1), degree, CubeRule(dims, degree + 1));
}

ElementShape ElementShape::Tetrahedron(int degree) {
  const MatrixXi cube = Lattice(3, degree + 1);
  MatrixXi lattice(3, (degree + 1) * (degree + 2) * (degree + 3) / 6);
  int nodes = 0;
  for (int i = 0; i < cube.cols(); ++i) {
    if (cube.col(i).sum() <= degree) lattice.col(nodes++) = cube.col(i);
  }
  Rule rule = CubeRule(3, degree + 1);
  for (int q = 0; q < rule.weights.size(); ++q) {
    auto p = rule.points.col(q);
    p[1] *= 1 - p[0];
    p[2] *= 1 - p[0] - p[1];
    rule.weights[q] *= (1 - p[0]) * (1 - p[0] - p[1]);
  }
  return ShapeOf(lattice, degree, rule);
}

PlacedElement::PlacedElement(const ElementShape& shape, const MatrixXd& places,
                             std::vector<int> numbers)
    : nodes(std::move(numbers)), gradients(shape.gradients), weights(shape.weights) {
  const int dims = shape.dims();
  for (int q = 0; q < shape.points(); ++q) {
    auto at_point = gradients.middleCols(dims * q, dims);
    const MatrixXd jacobian = places * at_point;
    const double volume = jacobian.determinant();
    if (!(volume > 0)) throw std::invalid_argument("mesh: an element has no volume");
    at_point = (at_point * jacobian.inverse()).eval();
    weights[q] *= volume;
  }
}

}  // namespace palpate::simulation
