#include "slave/mechanics/fem/solid/sparse_system.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "slave/mechanics/linear/block_matrix.h"
#include "slave/mechanics/linear/elimination_order.h"
#include "slave/mechanics/linear/two_grid.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::VectorXd;

constexpr int kMaxIterations = 20'000;  // of conjugate gradients
constexpr int kMaxRestarts = 4;
constexpr double kGridsWorth = 10;            // iterations that a new preconditioner must save
constexpr int kIterationsBeforeFactor = 200;  // iterations before a factor is tried instead
// Operations of a factorisation in the time of one iteration per block.
constexpr double kFactorSpeed = 600;

// Returns the neighbours of every node, including itself, in rising order.
std::vector<std::vector<int>> NeighboursOf(const TetMesh& mesh) {
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

BlockLayout::BlockLayout(const TetMesh& mesh, bool pressure) : mesh_(mesh), pressure_(pressure) {
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

std::vector<Eigen::Vector3d> BlockLayout::Points() const {
  std::vector<Eigen::Vector3d> points;
  for (const int node : order_) points.push_back(mesh_.nodes[Index(node)]);
  return points;
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

// Conjugate gradients on blocks of three, whose pattern is that of the scalars.
struct SymmetricSolver::Iterative {
  fem::BlockPattern pattern;
  fem::BlockMatrix matrix;
  fem::TwoGrid grids;
  fem::NodeVector free, x, r, z, d, Ad;
  // Smallest number of iterations per digit, and excess iterations since.
  double fewest = 0, excess = 0;

  Iterative(const SparseMatrix& scalars, std::span<const Eigen::Vector3d> points)
      : pattern(PatternOf(scalars)), matrix(pattern), grids(points, pattern) {
    for (auto* vector : {&free, &x, &r, &z, &d, &Ad}) vector->resize(points.size());
  }

  static fem::BlockPattern PatternOf(const SparseMatrix& upper) {
    const int nodes = static_cast<int>(upper.cols()) / 3;
    std::vector<std::vector<int>> columns(Index(nodes));
    for (int node = 0; node < nodes; ++node) {
      for (SparseMatrix::InnerIterator entry(upper, 3 * node); entry; ++entry) {
        if (entry.row() % 3 != 0) continue;
        const int other = static_cast<int>(entry.row()) / 3;
        columns[Index(node)].push_back(other);
        if (other != node) columns[Index(other)].push_back(node);
      }
    }
    fem::NodeGraph graph{{0}, {}};
    // Each row is in rising order: the lower half was added first, the rest node by node.
    for (const auto& row : columns) {
      graph.column.insert(graph.column.end(), row.begin(), row.end());
      graph.begin.push_back(static_cast<int>(graph.column.size()));
    }
    return fem::MakePattern(std::move(graph));
  }

  // Copies both halves from the upper triangle of the scalars.
  void Copy(const SparseMatrix& upper) {
    const int* outer = upper.outerIndexPtr();
    const double* values = upper.valuePtr();
    for (int node = 0; node < pattern.rows(); ++node) {
      const int first = pattern.graph.begin[Index(node)], last = pattern.diagonal[Index(node)];
      for (int k = first; k <= last; ++k) {
        double* lower = matrix.block(k);
        double* mirrored = matrix.block(pattern.transpose[Index(k)]);
        for (int c = 0; c < 3; ++c) {
          const double* column = values + outer[3 * node + c] + 3 * (k - first);
          for (int i = 0; i < (k == last ? c + 1 : 3); ++i) {
            lower[c + 3 * i] = mirrored[i + 3 * c] = column[i];
          }
        }
      }
    }
  }

  static void Load(const VectorXd& from, fem::NodeVector* to) {
    for (std::size_t i = 0; i < to->size(); ++i) {
      Eigen::Map<Eigen::Vector3d>((*to)[i].v) = from.segment<3>(3 * static_cast<Eigen::Index>(i));
    }
  }
  void Store(VectorXd* to) const {
    for (std::size_t i = 0; i < x.size(); ++i) {
      to->segment<3>(3 * static_cast<Eigen::Index>(i)) = Eigen::Map<const Eigen::Vector3d>(x[i].v);
    }
  }

  bool Factorize(const SparseMatrix& upper, const std::vector<char>& fixed, bool renew) {
    Copy(upper);
    if (!renew && excess < kGridsWorth) return true;
    for (std::size_t i = 0; i < 3 * free.size(); ++i) {
      free[i / 3].v[i % 3] = i < fixed.size() && fixed[i] ? 0 : 1;
    }
    excess = 0;
    fewest = std::numeric_limits<double>::infinity();
    return grids.Factor(matrix, free);
  }

  // Accumulates how many more iterations per digit solutions take than the best one with these
  // grids.
  void CountAge(double digits, long taken) {
    if (taken == 0 || digits <= 0) return;
    fewest = std::min(fewest, static_cast<double>(taken) / digits);
    excess += static_cast<double>(taken) - fewest * digits;
  }

  enum class Outcome { kConverged, kIndefinite, kSlow, kStopped };
  // Restarts from the true residual until it is small, not only the residual of the recurrence.
  Outcome Solve(const VectorXd& b, double goal, int most, long* iterations,
                fem::SearchProgress* progress) {
    for (int restart = 0; restart < kMaxRestarts; ++restart) {
      Load(b, &r);
      matrix.Multiply(x, Ad);
      fem::Add(-1, Ad, r);
      if (fem::Norm(r) <= goal) return Outcome::kConverged;
      double rho = 0;
      for (int step = 0;; ++step, ++*iterations) {
        const double size = fem::Norm(r);
        if (size <= goal) break;
        if (step >= most) return Outcome::kSlow;
        if (progress != nullptr) {
          progress->ReachInner(size, goal);
          if (!progress->Continue()) return Outcome::kStopped;
        }
        grids.Solve(r, z);
        const double next = fem::Dot(r, z);
        if (!(next > 0)) return Outcome::kIndefinite;
        if (step == 0) {
          d = z;
        } else {
          fem::ScaleAndAdd(next / rho, z, d);
        }
        rho = next;
        matrix.Multiply(d, Ad);
        const double curvature = fem::Dot(d, Ad);
        if (!(curvature > 0)) return Outcome::kIndefinite;
        fem::Add(rho / curvature, d, x);
        fem::Add(-rho / curvature, Ad, r);
      }
    }
    return Outcome::kSlow;
  }
};

SymmetricSolver::SymmetricSolver(const SparseMatrix& pattern, const Limits& limits,
                                 std::span<const Eigen::Vector3d> points,
                                 fem::SearchProgress* progress)
    : progress_(progress), factor_(std::make_unique<SparseLdlt<double>>(pattern)) {
  memory_bytes_ = factor_->entries() * sizeof(double);
  const double flops = factor_->flops();
  const bool fits = memory_bytes_ <= limits.factor_bytes && flops <= limits.factor_flops;
  direct_ = fits && (points.empty() || flops <= limits.iterated_flops);
  if (direct_) {
    factor_->Allocate(pattern);
    return;
  }
  if (points.empty()) return;
  iterative_ = std::make_unique<Iterative>(pattern, points);
  const auto worth = flops / (kFactorSpeed * iterative_->pattern.blocks());
  if (fits) {
    worth_ = kIterationsBeforeFactor + static_cast<int>(worth);
  } else {
    factor_.reset();
  }
  memory_bytes_ =
      Index(iterative_->pattern.blocks()) * 9 * sizeof(double) + iterative_->grids.memory_bytes();
}

SymmetricSolver::~SymmetricSolver() = default;

bool SymmetricSolver::FactorizeDirectly(const SparseMatrix& matrix, bool definite) {
  const auto go_on = [this](double done) {
    return progress_ == nullptr || progress_->ContinueFactor(done);
  };
  if (!factor_->Factorize(matrix, definite, go_on)) return false;
  negative_pivots_ = factor_->negative_pivots();
  return true;
}

bool SymmetricSolver::Factorize(const SparseMatrix& matrix, bool definite,
                                const std::vector<char>& fixed, bool renew) {
  indefinite_ = false;
  if (direct_) return FactorizeDirectly(matrix, definite);
  matrix_ = &matrix;
  if (iterative_->Factorize(matrix, fixed, renew)) return true;
  indefinite_ = true;
  return false;
}

bool SymmetricSolver::Solve(const VectorXd& b, double tolerance, VectorXd* x) {
  if (!direct_) {
    using Outcome = Iterative::Outcome;
    const int most = worth_ > 0 ? worth_ : kMaxIterations;
    Iterative::Load(*x, &iterative_->x);
    const long before = iterations_;
    const Outcome outcome =
        iterative_->Solve(b, tolerance * b.norm(), most, &iterations_, progress_);
    if (outcome == Outcome::kConverged) {
      iterative_->CountAge(-std::log10(tolerance), iterations_ - before);
      iterative_->Store(x);
      return x->allFinite();
    }
    indefinite_ = outcome == Outcome::kIndefinite;
    if (outcome != Outcome::kSlow || worth_ == 0) return false;
    // Iterations are slow for this body, so a factor is used from now on.
    factor_->Allocate(*matrix_);
    memory_bytes_ = factor_->entries() * sizeof(double);
    direct_ = true;
    if (!FactorizeDirectly(*matrix_, true)) {
      indefinite_ = true;
      return false;
    }
  }
  *x = b;
  factor_->Solve(x);
  return x->allFinite();
}

}  // namespace palpate
