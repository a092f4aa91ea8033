#include "slave/mechanics/fem/solid/block_layout.h"

#include <algorithm>
#include <stdexcept>

#include "shared/geometry/index.h"
#include "slave/mechanics/linear/mumps.h"

namespace palpate {
namespace {

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

int BlockLayout::element_size() const {
  return 3 * mesh_.nodes_per_element + (pressure_ ? 4 : 0);
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

}  // namespace palpate
