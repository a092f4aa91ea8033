#include "slave/mechanics/fem/solid/symmetric_solver.h"

#include <algorithm>
#include <cmath>

#include <Eigen/IterativeLinearSolvers>

namespace palpate {
namespace {

using Eigen::VectorXd;

constexpr int kMostIterations = 20'000;

}  // namespace

// Conjugate gradients, preconditioned by Eigen's incomplete Cholesky factor (Lin and More 1999).
struct SymmetricSolver::Iterative {
  Eigen::IncompleteCholesky<double, Eigen::Upper, Eigen::NaturalOrdering<int>> factor;
  const SparseMatrix* matrix = nullptr;
  VectorXd r, z, d, Ad;

  int Solve(const VectorXd& b, double tolerance, VectorXd* x) {
    x->setZero();
    r = b;
    const double goal = tolerance * b.norm();
    int steps = 0;
    // Restarted from the true residual until that one, not the recurrence, is small.
    for (int restart = 0; restart < 4 && r.norm() > goal; ++restart) {
      z = factor.solve(r);
      d = z;
      double rz = r.dot(z);
      while (steps < kMostIterations && r.norm() > goal && rz > 0) {
        ++steps;
        Multiply(*matrix, d, &Ad);
        const double curvature = d.dot(Ad);
        if (!(curvature > 0)) break;
        *x += rz / curvature * d;
        r -= rz / curvature * Ad;
        z = factor.solve(r);
        const double before = rz;
        rz = r.dot(z);
        d = z + rz / before * d;
      }
      Multiply(*matrix, *x, &Ad);
      r = b - Ad;
    }
    return r.norm() <= goal ? steps : -1;
  }
};

SymmetricSolver::SymmetricSolver(const SparseMatrix& pattern, const Limits& limits)
    : factor_(std::make_unique<SparseLdlt>(pattern)) {
  memory_bytes_ = factor_->entries() * sizeof(double);
  factor_flops_ = factor_->flops();
  direct_ = memory_bytes_ <= limits.factor_bytes && factor_flops_ <= limits.factor_flops;
  if (direct_) {
    factor_->Allocate(pattern);
    return;
  }
  factor_.reset();
  iterative_ = std::make_unique<Iterative>();
  iterative_->r.resize(pattern.cols());
  iterative_->z = iterative_->d = iterative_->Ad = iterative_->r;
  memory_bytes_ = static_cast<std::size_t>(pattern.nonZeros()) * (sizeof(double) + sizeof(int));
}

SymmetricSolver::~SymmetricSolver() = default;

bool SymmetricSolver::Factorize(const SparseMatrix& matrix, bool definite) {
  if (direct_) {
    if (!factor_->Factorize(matrix, definite)) return false;
    negative_pivots_ = factor_->negative_pivots();
    return true;
  }
  iterative_->matrix = &matrix;
  if (!(matrix.diagonal().minCoeff() > 0)) return false;
  iterative_->factor.compute(matrix);
  return iterative_->factor.info() == Eigen::Success;
}

bool SymmetricSolver::Solve(const VectorXd& b, double tolerance, VectorXd* x) {
  if (direct_) {
    *x = b;
    factor_->Solve(x);
    return x->allFinite();
  }
  iterations_ = iterative_->Solve(b, tolerance, x);
  return iterations_ >= 0;
}

}  // namespace palpate
