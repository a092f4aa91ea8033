// Gauss-Legendre and Gauss-Lobatto rules, and polynomials given by their values at the latter.
#pragma once

#include <Eigen/Core>

namespace palpate::plate {

struct Quadrature {
  Eigen::VectorXd points, weights;
};
// Exact to degree 2 count - 1 on (0, 1), count >= 1.
Quadrature GaussLegendre(int count);
// The ends of [0, 1] and the extrema between of the Legendre polynomial of degree `count - 1`,
// count >= 2.
Eigen::VectorXd LobattoPoints(int count);

// Interpolates polynomials on [0, 1] from their values at `nodes`: one row per place, one column
// per node.
struct Interpolation {
  Eigen::MatrixXd value, slope;
};
Interpolation Interpolate(const Eigen::VectorXd& nodes, const Eigen::VectorXd& places);

}  // namespace palpate::plate
