#include "slave/mechanics/fem/zone/linear_rest.h"

#include <algorithm>
#include <map>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>

#include "shared/geometry/index.h"
#include "slave/mechanics/fem/zone/neo_hookean_tets.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kColumns = 48;  // right-hand sides of one solution

}  // namespace

LinearRest::LinearRest(const SolidMesh& mesh, const HeldNodes& held, double nu)
    : mesh_(mesh),
      nu_(nu),
      stiffness_(AssembleTetStiffness(mesh, held, nu, TetElement::kTet4)),
      factor_(stiffness_.lower) {}

std::size_t LinearRest::memory_bytes() const {
  return factor_.memory_bytes() + static_cast<std::size_t>(stiffness_.lower.nonZeros()) * 12;
}

MatrixXd LinearRest::Solve(const MatrixXd& forces) {
  MatrixXd x(stiffness_.lower.rows(), forces.cols());
  const int nodes = static_cast<int>(mesh_.nodes.size());
  for (int n = 0; n < nodes; ++n) {
    for (int c = 0; c < 3; ++c) {
      if (Row(n, c) >= 0) x.row(Row(n, c)) = forces.row(3 * n + c);
    }
  }
  if (x.cols() > 0) factor_.Solve(x.data(), static_cast<int>(x.cols()));
  MatrixXd u = MatrixXd::Zero(forces.rows(), forces.cols());
  for (int n = 0; n < nodes; ++n) {
    for (int c = 0; c < 3; ++c) {
      if (Row(n, c) >= 0) u.row(3 * n + c) = x.row(Row(n, c));
    }
  }
  return u;
}

// Columns of the inverse, each solved once for all zones.
void LinearRest::AddCompliances(const std::vector<Zone>& zones, std::vector<MatrixXd>* G) {
  struct Use {
    int zone, border;  // a zone, and the number of the node in its border
  };
  std::map<int, std::vector<Use>> uses;  // per node
  for (std::size_t z = 0; z < zones.size(); ++z) {
    for (int b = 0; b < zones[z].border(); ++b) {
      uses[zones[z].nodes[Index(zones[z].inner + b)]].push_back({static_cast<int>(z), b});
    }
  }
  struct Column {
    const std::vector<Use>* uses;
    int row, component;
  };
  std::vector<Column> columns;
  for (const auto& [node, at] : uses) {
    for (int c = 0; c < 3; ++c) {
      if (Row(node, c) >= 0) columns.push_back({&at, Row(node, c), c});
    }
  }
  MatrixXd x;
  for (std::size_t first = 0; first < columns.size(); first += kColumns) {
    const auto count = static_cast<int>(std::min<std::size_t>(kColumns, columns.size() - first));
    x.setZero(stiffness_.lower.rows(), count);
    for (int j = 0; j < count; ++j) x(columns[first + Index(j)].row, j) = 1;
    factor_.Solve(x.data(), count);
    for (int j = 0; j < count; ++j) {
      const Column& column = columns[first + Index(j)];
      for (const auto& [z, border] : *column.uses) {
        const Zone& zone = zones[Index(z)];
        auto target = (*G)[Index(z)].col(3 * border + column.component);
        for (int b = 0; b < zone.border(); ++b) {
          for (int c = 0; c < 3; ++c) {
            const int row = Row(zone.nodes[Index(zone.inner + b)], c);
            if (row >= 0) target[3 * b + c] = x(row, j);
          }
        }
      }
    }
  }
}

// Of the zone's linear tetrahedra onto its border. Held components count as free: the caller leaves
// out those of the border, and inner ones keep a unit diagonal.
MatrixXd LinearRest::ZoneSchur(const Zone& zone) const {
  std::vector<Eigen::Vector3d> nodes;
  for (const int node : zone.nodes) {
    nodes.push_back((mesh_.nodes[Index(node)] - mesh_.nodes.front()) / length_unit());
  }
  const NeoHookeanTets tets(zone.corners, nodes, nu_);
  const VectorXd rest = VectorXd::Zero(3 * zone.size());
  const int inner = 3 * zone.inner, border = 3 * zone.border();
  std::vector<Eigen::Triplet<double>> inside;
  MatrixXd across = MatrixXd::Zero(inner, border), schur = MatrixXd::Zero(border, border);
  const auto is_free = [&](int unknown) {
    return !is_held(zone.nodes[Index(unknown / 3)], unknown % 3);
  };
  NeoHookeanTets::Block block;
  for (int t = 0; t < tets.size(); ++t) {
    tets.Stiffness(t, rest.data(), &block);
    for (int j = 0; j < 12; ++j) {
      const int column = 3 * zone.corners[Index(t)][Index(j / 3)] + j % 3;
      if (!is_free(column)) continue;
      for (int i = 0; i < 12; ++i) {
        const int row = 3 * zone.corners[Index(t)][Index(i / 3)] + i % 3;
        if (!is_free(row)) continue;
        if (column < inner) {
          if (row < inner) inside.emplace_back(row, column, block(i, j));
        } else if (row < inner) {
          across(row, column - inner) += block(i, j);
        } else {
          schur(row - inner, column - inner) += block(i, j);
        }
      }
    }
  }
  for (int i = 0; i < inner; ++i) {
    if (!is_free(i)) inside.emplace_back(i, i, 1.0);
  }
  if (inner == 0) return schur;
  Eigen::SparseMatrix<double> K(inner, inner);
  K.setFromTriplets(inside.begin(), inside.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(K);
  if (factor.info() != Eigen::Success) throw std::runtime_error("a zone's stiffness is singular");
  const MatrixXd moved = factor.solve(across);
  schur.noalias() -= across.transpose() * moved;
  return schur;
}

std::vector<MatrixXd> LinearRest::Condense(const std::vector<Zone>& zones) {
  std::vector<MatrixXd> rest;
  for (const Zone& zone : zones)
    rest.push_back(MatrixXd::Zero(3 * zone.border(), 3 * zone.border()));
  AddCompliances(zones, &rest);
  for (std::size_t z = 0; z < zones.size(); ++z) {
    MatrixXd& S = rest[z];
    const Zone& zone = zones[z];
    if (zone.border() == 0) continue;
    std::vector<int> held;
    for (int i = 0; i < S.rows(); ++i) {
      if (is_held(zone.nodes[Index(zone.inner + i / 3)], i % 3)) held.push_back(i);
    }
    for (const int i : held) S(i, i) = 1;
    const Eigen::LLT<MatrixXd> factor(S);
    if (factor.info() != Eigen::Success) {
      throw std::runtime_error("a zone's compliance is not positive definite");
    }
    S = factor.solve(MatrixXd::Identity(S.rows(), S.cols()));
    for (const int i : held) S(i, i) = 0;
    S -= ZoneSchur(zone);
    S = 0.5 * (S + S.transpose()).eval();
  }
  return rest;
}

}  // namespace palpate
