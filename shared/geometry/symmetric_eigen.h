// Eigenvalues and eigenvectors of symmetric matrices of any size, compiled once: a unit that has
// Eigen's solver for itself takes four seconds longer. It allocates: live loops take Eigen's own.
#pragma once

#include <Eigen/Core>

namespace palpate {

// A = V diag(w) V^T.
struct SymmetricEigen {
  Eigen::VectorXd values;   // w, n, ascending
  Eigen::MatrixXd vectors;  // V, n x n, orthonormal columns
};

// `A`: n x n, whose lower triangle is read.
SymmetricEigen EigenOf(const Eigen::MatrixXd& A);

}  // namespace palpate
