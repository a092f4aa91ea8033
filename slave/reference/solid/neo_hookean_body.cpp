#include "slave/reference/solid/neo_hookean_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "slave/mesh/index.h"

namespace palpate::simulation {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Matrix3d CofactorOf(const Matrix3d& F) {
  Matrix3d cofactor;
  cofactor << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  return cofactor;
}

// Returns the zero of an increasing function.
template <typename Function>
double RootOf(double low, double high, const Function& function) {
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (function(middle) < 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

NeoHookean::NeoHookean(double nu, double tension)
    : mu_(0.5 / (1 + nu)), bulk_(1 / (3 * (1 - 2 * nu))) {
  if (tension == 0) return;
  const auto across = [&](double along) {
    return RootOf(0.01, 10, [&](double x) { return Stretched(along, x, 2); });
  };
  const double along = RootOf(1, 4, [&](double x) { return Stretched(x, across(x), 0) - tension; });
  stretch_ << along, along, across(along);
}

// Cauchy stress of a sheet.
double NeoHookean::Stretched(double along, double across, int component) const {
  const Eigen::Vector3d stretch(along, along, across);
  Stress stress;
  FromFree(Matrix3d((stretch.array() - 1).matrix().asDiagonal()), false, &stress);
  return stress.P(component, component) * stretch[component] / stretch.prod();
}

bool NeoHookean::At(const Matrix3d& H, bool with_tangent, Stress* stress) const {
  Matrix3d from_free = H * stretch_.asDiagonal();
  from_free.diagonal().array() += stretch_.array() - 1;
  if (!FromFree(from_free, with_tangent, stress)) return false;
  const double volume = stretch_.prod();
  stress->P = stress->P * stretch_.asDiagonal() / volume;
  if (!with_tangent) return true;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      stress->tangent.block<3, 3>(3 * i, 3 * j) *= stretch_[i] * stretch_[j] / volume;
    }
  }
  return true;
}

// With G = F^-T, c = mu J^(-2/3) and q = K J (J - 1),
//
//   P = c (F - tr(F^T F) / 3 G) + q G
//   dP_ai / dF_bj = c (d_ab d_ij - 2/3 (F_ai G_bj + G_ai F_bj)) + (c tr / 3 - q) G_aj G_bi
//                   + (2/9 c tr + K J (2 J - 1)) G_ai G_bj
bool NeoHookean::FromFree(const Matrix3d& H, bool with_tangent, Stress* stress) const {
  const Matrix3d minors = CofactorOf(H);
  const Matrix3d area = H.trace() * Matrix3d::Identity() - H.transpose() + minors;  // cof F - I
  const double volume = H.trace() + minors.trace() + H.determinant();               // J - 1
  const double stretch = 2 * H.trace() + H.squaredNorm();                           // tr F^T F - 3
  const double J = 1 + volume;
  if (!(J > 0)) return false;
  const Matrix3d F = Matrix3d::Identity() + H, G = (Matrix3d::Identity() + area) / J;
  const double c = mu_ / std::cbrt(J * J), q = bulk_ * J * volume, trace = 3 + stretch;
  stress->P = c / J * (H - area + volume * F - stretch / 3 * (Matrix3d::Identity() + area)) + q * G;
  if (!with_tangent) return true;
  const auto f = F.reshaped(), g = G.reshaped();
  stress->tangent = (2 * c * trace / 9 + bulk_ * J * (2 * J - 1)) * g * g.transpose() -
                    2 * c / 3 * (f * g.transpose() + g * f.transpose());
  stress->tangent.diagonal().array() += c;
  const double crossed = c * trace / 3 - q;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      stress->tangent.block<3, 3>(3 * i, 3 * j) += crossed * G.col(j) * G.col(i).transpose();
    }
  }
  return true;
}

// Work arrays of one element. For components a <= b the stiffness of all its nodes is the product
// of the shape functions' gradients and these gradients times dP_a / dF_b. The blocks are stored
// side by side.
struct NeoHookeanBody::Work {
  static constexpr std::array<int, 6> kFirst{0, 0, 0, 1, 1, 2}, kSecond{0, 1, 2, 1, 2, 2};
  // Numbers of the blocks that components (a, b) and (b, a) share.
  static constexpr std::array<std::array<int, 3>, 3> kBlock{{{0, 1, 2}, {1, 3, 4}, {2, 4, 5}}};

  void Resize(int nodes, int points) {
    u.resize(3, nodes);
    P.resize(3, 3 * points);
    turned.resize(6 * nodes, 3 * points);
  }
  // Stiffness between component a of node i and b of node j.
  [[nodiscard]] double entry(int i, int a, int j, int b) const {
    const auto nodes = static_cast<int>(stiffness.rows());
    const int first = nodes * kBlock[Index(a)][Index(b)];
    return a <= b ? stiffness(i, first + j) : stiffness(j, first + i);
  }

  MatrixXd u, forces;  // 3 x nodes
  MatrixXd H;          // displacement gradients, 3 x (3 per point)
  MatrixXd P;          // stresses, times weights
  MatrixXd turned;  // product of gradients, tangents and weights: (nodes per block) x (3 per point)
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
      // dP_ai / dF_bj: row i, column j.
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
        // A node may occur twice in an element.
        const int rows = nodes[Index(i)] == column ? b + 1 : 3;
        for (int a = 0; a < rows; ++a) to[a] += work.entry(i, a, j, b);
      }
    }
  }
}

}  // namespace palpate::simulation
