// Eigenvalues and eigenvectors of symmetric matrices of any size. Eigen's solver is compiled only
// here, because it takes four seconds. This function allocates, so real-time code uses Eigen
// directly.
#pragma once

#include <Eigen/Core>

namespace palpate {

// A = V diag(w) V^T.
struct SymmetricEigen {
  Eigen::VectorXd values;   // w, n, ascending
  Eigen::MatrixXd vectors;  // V, n x n, orthonormal columns
};

// `A`: n x n; only the lower triangle is read.
SymmetricEigen EigenOf(const Eigen::MatrixXd& A);

}  // namespace palpate
