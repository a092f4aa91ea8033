#include "slave/site/solid/neo_hookean_body.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "shared/geometry/index.h"

namespace palpate::site {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace

// Of one element. The stiffness between components a <= b of all its nodes is the product of the
// shape functions' gradients with theirs times dP_a / dF_b, one such block beside the other.
struct NeoHookeanBody::Work {
  static constexpr std::array<int, 6> kFirst{0, 0, 0, 1, 1, 2}, kSecond{0, 1, 2, 1, 2, 2};
  // Of the blocks that components (a, b) and (b, a) share.
  static constexpr std::array<std::array<int, 3>, 3> kBlock{{{0, 1, 2}, {1, 3, 4}, {2, 4, 5}}};

  void Resize(int nodes, int points) {
    u.resize(3, nodes);
    P.resize(3, 3 * points);
    turned.resize(6 * nodes, 3 * points);
  }
  // Of the component a of node i and b of node j.
  [[nodiscard]] double entry(int i, int a, int j, int b) const {
    const auto nodes = static_cast<int>(stiffness.rows());
    const int first = nodes * kBlock[Index(a)][Index(b)];
    return a <= b ? stiffness(i, first + j) : stiffness(j, first + i);
  }

  MatrixXd u, forces;  // 3 x nodes
  MatrixXd H;          // displacement gradients, 3 x (3 per point)
  MatrixXd P;          // stresses, times weights
  MatrixXd turned;     // gradients times tangents, times weights: (nodes per block) x (3 per point)
  MatrixXd stiffness;  // nodes x (nodes per block)
};

NeoHookeanBody::NeoHookeanBody(std::vector<PlacedElement> elements, int free_nodes,
                               const NeoHookean& rubber)
    : elements_(std::move(elements)), rubber_(rubber), upper_(Index(free_nodes)) {
  FindPattern();
}

void NeoHookeanBody::FindPattern() {
  for (const PlacedElement& element : elements_) {
    for (const int column : element.nodes) {
      if (!has_unknowns(column)) continue;
      auto& rows = upper_[Index(column)];
      std::ranges::copy_if(element.nodes, std::back_inserter(rows),
                           [&](int row) { return row <= column; });
    }
  }
  for (auto& rows : upper_) {
    std::ranges::sort(rows);
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  }
  for (const PlacedElement& element : elements_) {
    auto& positions = positions_.emplace_back();
    for (const int column : element.nodes) {
      for (const int row : element.nodes) {
        if (!has_unknowns(column) || row > column) {
          positions.push_back(-1);
          continue;
        }
        const auto& rows = upper_[Index(column)];
        positions.push_back(static_cast<int>(std::ranges::lower_bound(rows, row) - rows.begin()));
      }
    }
  }
}

NeoHookeanBody::Matrix NeoHookeanBody::EmptyMatrix() const {
  std::size_t blocks = 0;
  for (const auto& rows : upper_) blocks += rows.size();
  Matrix matrix(size(), size());
  matrix.reserve(static_cast<Eigen::Index>(9 * blocks));
  for (int column = 0; column < size(); ++column) {
    matrix.startVec(column);
    for (const int node : upper_[Index(column / 3)]) {
      for (int row = 3 * node; row < 3 * node + 3 && row <= column; ++row) {
        matrix.insertBack(row, column) = 0;
      }
    }
  }
  matrix.finalize();
  return matrix;
}

void NeoHookeanBody::Hold(const VectorXd& free, Matrix* stiffness) {
  for (int column = 0; column < stiffness->cols(); ++column) {
    for (Matrix::InnerIterator entry(*stiffness, column); entry; ++entry) {
      if (free[entry.row()] * free[column] == 0) {
        entry.valueRef() = entry.row() == column ? 1 : 0;
      }
    }
  }
}

bool NeoHookeanBody::Forces(const VectorXd& u, VectorXd* forces) const {
  return Accumulate(u, forces, nullptr);
}

bool NeoHookeanBody::Linearise(const VectorXd& u, VectorXd* forces, Matrix* stiffness) const {
  return Accumulate(u, forces, stiffness);
}

bool NeoHookeanBody::Accumulate(const VectorXd& u, VectorXd* forces, Matrix* stiffness) const {
  Work work;
  forces->setZero(size());
  if (stiffness != nullptr) stiffness->coeffs().setZero();
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    if (!Integrate(elements_[e], u, stiffness != nullptr, &work)) return false;
    AddForces(elements_[e], work, forces);
    if (stiffness != nullptr) AddStiffness(e, work, stiffness);
  }
  return true;
}

bool NeoHookeanBody::Integrate(const PlacedElement& element, const VectorXd& u, bool with_stiffness,
                               Work* work) const {
  const auto nodes = static_cast<int>(element.nodes.size());
  const auto points = static_cast<int>(element.weights.size());
  work->Resize(nodes, points);
  for (int i = 0; i < nodes; ++i) {
    const int node = element.nodes[Index(i)];
    work->u.col(i).setZero();
    if (has_unknowns(node)) work->u.col(i) = u.segment<3>(3 * node);
  }
  work->H.noalias() = work->u * element.gradients;
  NeoHookean::Stress stress;
  for (int p = 0; p < points; ++p) {
    const Matrix3d H = work->H.middleCols<3>(3 * p);
    if (!rubber_.At(H, with_stiffness, &stress)) return false;
    const double weight = element.weights[p];
    work->P.middleCols<3>(3 * p) = weight * stress.P;
    if (!with_stiffness) continue;
    for (int k = 0; k < 6; ++k) {
      // Of dP_ai / dF_bj: row i, column j.
      const Matrix3d of_pair = weight * stress.tangent(Eigen::seqN(Work::kFirst[Index(k)], 3, 3),
                                                       Eigen::seqN(Work::kSecond[Index(k)], 3, 3));
      work->turned.block(k * nodes, 3 * p, nodes, 3).noalias() =
          element.gradients.middleCols<3>(3 * p) * of_pair.transpose();
    }
  }
  work->forces.noalias() = work->P * element.gradients.transpose();
  if (with_stiffness) work->stiffness.noalias() = element.gradients * work->turned.transpose();
  return true;
}

void NeoHookeanBody::AddForces(const PlacedElement& element, const Work& work,
                               VectorXd* forces) const {
  for (std::size_t i = 0; i < element.nodes.size(); ++i) {
    const int node = element.nodes[i];
    if (!has_unknowns(node)) continue;
    forces->segment<3>(3 * node) += work.forces.col(static_cast<Eigen::Index>(i));
  }
}

void NeoHookeanBody::AddStiffness(std::size_t element, const Work& work, Matrix* stiffness) const {
  const std::vector<int>& nodes = elements_[element].nodes;
  const auto count = static_cast<int>(nodes.size());
  for (int j = 0; j < count; ++j) {
    const int column = nodes[Index(j)];
    if (!has_unknowns(column)) continue;
    for (int i = 0; i < count; ++i) {
      if (nodes[Index(i)] > column) continue;
      const int position = 3 * positions_[element][Index(i + count * j)];
      for (int b = 0; b < 3; ++b) {
        double* to = stiffness->valuePtr() + stiffness->outerIndexPtr()[3 * column + b] + position;
        const int rows = nodes[Index(i)] == column ? b + 1 : 3;  // a node may stand in it twice
        for (int a = 0; a < rows; ++a) to[a] += work.entry(i, a, j, b);
      }
    }
  }
}

}  // namespace palpate::site
