#include "slave/mechanics/fem/solid/sparse_system.h"

#include <algorithm>
#include <stdexcept>

#include <Eigen/IterativeLinearSolvers>

#include "shared/geometry/index.h"
#include "slave/mechanics/linear/mumps.h"

namespace palpate {
namespace {

using Eigen::VectorXd;

constexpr int kMostIterations = 20'000;  // of conjugate gradients

// Of every node, itself included, rising.
std::vector<std::vector<int>> NeighboursOf(const ElementMesh& mesh) {
  std::vector<std::vector<int>> neighbours(Index(mesh.node_count()));
  for (int node = 0; node < mesh.node_count(); ++node) neighbours[Index(node)].push_back(node);
  for (int e = 0; e < mesh.element_count(); ++e) {
    const auto nodes = mesh.element(e);
    for (const int a : nodes) {
      neighbours[Index(a)].insert(neighbours[Index(a)].end(), nodes.begin(), nodes.end());
    }
  }
  for (auto& list : neighbours) {
    std::ranges::sort(list);
    list.erase(std::unique(list.begin(), list.end()), list.end());
    list.shrink_to_fit();
  }
  return neighbours;
}

}  // namespace

BlockLayout::BlockLayout(const ElementMesh& mesh, bool pressure)
    : mesh_(mesh), pressure_(pressure) {
  auto neighbours = NeighboursOf(mesh);
  order_ = EliminationOrder(neighbours);
  rank_.resize(order_.size());
  first_.resize(order_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) {
    rank_[Index(order_[i])] = static_cast<int>(i);
    first_[Index(order_[i])] = size_;
    size_ += block_size(order_[i]);
  }
  for (int node = 0; node < mesh.node_count(); ++node) {
    auto& upper = neighbours[Index(node)];
    std::erase_if(upper, [&](int other) { return rank_[Index(other)] > rank_[Index(node)]; });
    std::ranges::sort(upper, {}, [&](int other) { return rank_[Index(other)]; });
  }
  BuildPattern(neighbours);
  FindPositions(neighbours);
}

void BlockLayout::BuildPattern(const std::vector<std::vector<int>>& upper) {
  std::size_t entries = 0;
  for (int node = 0; node < mesh_.node_count(); ++node) {
    std::size_t rows = 0;
    for (const int other : upper[Index(node)]) rows += Index(block_size(other));
    entries += rows * Index(block_size(node));
  }
  if (entries > 2'000'000'000) {
    throw std::invalid_argument("mesh: too fine, its matrix has more than 2e9 entries");
  }
  pattern_.resize(size_, size_);
  pattern_.reserve(static_cast<Eigen::Index>(entries));
  for (const int node : order_) {
    for (int c = 0; c < block_size(node); ++c) {
      const int column = first(node) + c;
      pattern_.startVec(column);
      for (const int other : upper[Index(node)]) {
        for (int r = 0; r < block_size(other); ++r) {
          const int row = first(other) + r;
          if (row <= column) pattern_.insertBack(row, column) = 0;
        }
      }
    }
  }
  pattern_.finalize();
}

void BlockLayout::FindPositions(const std::vector<std::vector<int>>& upper) {
  const int n = mesh_.nodes_per_element;
  positions_.reserve(Index(mesh_.element_count()) * Index(n * (n + 1) / 2));
  const auto row_of = [&](int row_node, int column_node) {
    int row = 0;
    for (const int other : upper[Index(column_node)]) {
      if (other == row_node) break;
      row += block_size(other);
    }
    return row;
  };
  for (int e = 0; e < mesh_.element_count(); ++e) {
    const auto nodes = mesh_.element(e);
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i <= j; ++i) {
        const int a = nodes[Index(i)], b = nodes[Index(j)];
        const bool is_upper = rank_[Index(a)] <= rank_[Index(b)];
        positions_.push_back(is_upper ? row_of(a, b) : row_of(b, a));
      }
    }
  }
}

void BlockLayout::Add(int element, const ElementMatrix& block, SparseMatrix* matrix) const {
  const auto nodes = mesh_.element(element);
  const int n = mesh_.nodes_per_element;
  const int* position = &positions_[Index(element) * Index(n * (n + 1) / 2)];
  const int* outer = matrix->outerIndexPtr();
  double* values = matrix->valuePtr();
  std::array<int, kMaxNodes + 1> start{};
  for (int i = 0; i < n; ++i) start[Index(i) + 1] = start[Index(i)] + local_size(i);
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i <= j; ++i, ++position) {
      const bool is_upper = rank_[Index(nodes[Index(i)])] <= rank_[Index(nodes[Index(j)])];
      const int row = is_upper ? i : j, column = is_upper ? j : i;
      const int first_column = first(nodes[Index(column)]);
      for (int c = 0; c < local_size(column); ++c) {
        double* target = values + outer[first_column + c] + *position;
        const int rows = row == column ? c + 1 : local_size(row);
        for (int r = 0; r < rows; ++r) {
          target[r] += block(start[Index(row)] + r, start[Index(column)] + c);
        }
      }
    }
  }
}

void Multiply(const SparseMatrix& upper, const Eigen::VectorXd& x, Eigen::VectorXd* y) {
  const int* outer = upper.outerIndexPtr();
  const int* inner = upper.innerIndexPtr();
  const double* values = upper.valuePtr();
  const double* from = x.data();
  double* to = y->data();
  y->setZero();
  for (int column = 0; column < upper.cols(); ++column) {
    const int last = outer[column + 1] - 1;  // the diagonal
    const double here = from[column];
    double sum = values[last] * here;
    for (int k = outer[column]; k < last; ++k) {
      sum += values[k] * from[inner[k]];
      to[inner[k]] += values[k] * here;
    }
    to[column] += sum;
  }
}

// Conjugate gradients, preconditioned by Eigen's incomplete Cholesky factor (Lin and More 1999).
struct SymmetricSolver::Iterative {
  Eigen::IncompleteCholesky<double, Eigen::Upper, Eigen::NaturalOrdering<int>> factor;
  const SparseMatrix* matrix = nullptr;
  VectorXd r, z, d, Ad;

  bool Solve(const VectorXd& b, double tolerance, VectorXd* x) {
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
    return r.norm() <= goal;
  }
};

SymmetricSolver::SymmetricSolver(const SparseMatrix& pattern, const Limits& limits)
    : factor_(std::make_unique<SparseLdlt>(pattern)) {
  memory_bytes_ = factor_->entries() * sizeof(double);
  direct_ = memory_bytes_ <= limits.factor_bytes && factor_->flops() <= limits.factor_flops;
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
  return iterative_->Solve(b, tolerance, x);
}

}  // namespace palpate
