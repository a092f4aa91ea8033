#include "shared/geometry/symmetric_eigen.h"

#include <Eigen/Eigenvalues>

namespace palpate {

SymmetricEigen EigenOf(const Eigen::MatrixXd& A) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace palpate
