#include "slave/mechanics/fem/green/rest_stiffness.h"

#include <algorithm>
#include <span>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>

#include "shared/text/text.h"
#include "slave/mechanics/fem/green/column_cache.h"
#include "slave/mechanics/fem/held_motions.h"
#include "slave/mechanics/fem/solid/elastic_body.h"
#include "slave/mechanics/fem/solid/supports.h"
#include "slave/mesh/index.h"
#include "slave/mesh/mesh_census.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Element = FemOptions::Element;

constexpr int kAssembly = 3;  // increase it when the same inputs produce another matrix
// Poisson's ratio from which elements have a pressure unknown [-]. [measured under a disc of four
// elements: four nodes without it are 2 % too soft at 0.3, 6 % too stiff at 0.45 and 33 % at 0.49;
// with it 4 to 5 % too soft at every ratio up to 0.4999]
constexpr double kMixedFrom = 0.4;
constexpr double kMaxNu = 0.5;
constexpr double kResidual = 1e-12;  // of a solution with pressure, relative
constexpr int kMaxRefinements = 8;

void RequirePoissonRatio(double nu) {
  if (!(nu > -1 && nu <= kMaxNu)) RefuseValue("poisson_ratio", nu, "-1 < nu <= 0.5");
}

// Throws unless the held components fix all six rigid motions of every connected part. O(N).
void RequireSupported(const SolidMesh& mesh, const HeldNodes& held) {
  int parts = 0;
  const std::vector<int> part = PartsOf(mesh.tets, mesh.nodes.size(), &parts);
  std::vector<Eigen::AlignedBox3d> box(Index(parts));
  for (std::size_t n = 0; n < part.size(); ++n) {
    if (part[n] >= 0) box[Index(part[n])].extend(mesh.nodes[n]);
  }
  std::vector<fem::HeldMotions> motions(box.begin(), box.end());
  for (std::size_t n = 0; n < part.size(); ++n) {
    for (int c = 0; part[n] >= 0 && c < 3; ++c) {
      auto& part_motions = motions[Index(part[n])];
      if (held[n][Index(c)]) part_motions.Hold(part_motions.Row(mesh.nodes[n], c));
    }
  }
  for (int p = 0; p < parts; ++p) {
    if (motions[Index(p)].Free().cols() == 0) continue;
    throw std::invalid_argument(
        "object.fixed: fem-green needs a fixed body: expected supports that prevent all six "
        "rigid motions of every part; the part with node " +
        std::to_string(std::ranges::find(part, p) - part.begin()) + " is free to move");
  }
}

std::uint64_t HashOf(const SolidMesh& mesh, const HeldNodes& held, double nu, Element element,
                     bool pressure) {
  Hash hash;
  if (!mesh.modulus.empty()) hash.Add(std::as_bytes(std::span(mesh.modulus)));
  hash.Add(kAssembly).Add(element).Add(pressure).Add(nu);
  hash.Add(mesh.nodes.size()).Add(mesh.tets.size());
  hash.Add(std::as_bytes(std::span(mesh.nodes))).Add(std::as_bytes(std::span(mesh.tets)));
  return hash.Add(std::as_bytes(std::span(held))).value();
}

// Rows of the unknowns that are free, in their order; -1: fixed.
std::vector<int> FreeRows(const TetMesh& elements, const BlockLayout& layout,
                          const ElasticBody& body, const HeldNodes& held) {
  Balance balance;
  Supports(elements, layout, held, body.NodeVolumes()).Hold(&balance);
  std::vector<int> rows;
  int free = 0;
  for (const char fixed : balance.fixed) rows.push_back(fixed != 0 ? -1 : free++);
  return rows;
}

// Returns the lower triangle of the free rows of a matrix that is given by its upper triangle.
SparseMatrix FreeLower(const SparseMatrix& upper, const std::vector<int>& rows) {
  const int order = std::ranges::max(rows) + 1;
  SparseMatrix free(order, order);
  free.reserve(upper.nonZeros());
  for (int column = 0; column < upper.cols(); ++column) {
    if (rows[Index(column)] < 0) continue;
    free.startVec(rows[Index(column)]);
    for (SparseMatrix::InnerIterator entry(upper, column); entry; ++entry) {
      const int row = rows[static_cast<std::size_t>(entry.row())];
      if (row >= 0) free.insertBack(row, rows[Index(column)]) = entry.value();
    }
  }
  free.finalize();
  return free.transpose();
}

}  // namespace

RestStiffness AssembleAtRest(const SolidMesh& mesh, const HeldNodes& held, double nu,
                             Element element) {
  RequirePoissonRatio(nu);
  RequireTets(mesh, held);
  RestStiffness stiffness;
  stiffness.held = held;
  stiffness.poisson_ratio = nu;
  stiffness.length_unit = LargerSide(mesh.nodes);
  stiffness.elements =
      MakeTetMesh(mesh, element == Element::kTet10 ? 10 : 4, stiffness.length_unit);
  RequireSupported(mesh, held);
  const bool pressure = nu >= kMixedFrom;
  stiffness.inputs = HashOf(mesh, held, nu, element, pressure);
  const BlockLayout layout(stiffness.elements, pressure);
  const ElasticBody body(stiffness.elements, layout, MaterialLaw(FemOptions::Law::kLinear, nu));
  const std::vector<int> rows = FreeRows(stiffness.elements, layout, body, held);
  for (int node = 0; node < stiffness.elements.node_count(); ++node) {
    const auto first = Index(layout.first(node));
    stiffness.row.push_back({rows[first], rows[first + 1], rows[first + 2]});
  }
  const auto assemble = [&](bool regularised) {
    SparseMatrix tangent = layout.pattern();
    body.AddTangent(VectorXd::Zero(layout.size()), kExactTangent, regularised, &tangent);
    return FreeLower(tangent, rows);
  };
  stiffness.lower = assemble(false);
  if (pressure) stiffness.regularised = assemble(true);
  return stiffness;
}

void RestStiffness::Spread(const Eigen::Ref<const VectorXd>& x,
                           std::vector<Eigen::Vector3d>* u) const {
  u->assign(row.size(), Eigen::Vector3d::Zero());
  for (std::size_t n = 0; n < u->size(); ++n) {
    for (int c = 0; c < 3; ++c) {
      const int at = row[n][Index(c)];
      if (at >= 0) (*u)[n][c] = x[at];
    }
  }
}

RestFactor::RestFactor(const RestStiffness& stiffness) : stiffness_(stiffness) {
  if (!stiffness.has_pressure()) {
    definite_.emplace(stiffness.lower);
    return;
  }
  const SparseMatrix upper = stiffness.regularised.transpose();
  mixed_.emplace(upper);
  mixed_->Allocate(upper);
  if (!mixed_->Factorize(upper, false)) {
    throw std::invalid_argument("the stiffness with pressure has no factor: a pivot is zero");
  }
}

void RestFactor::Solve(Eigen::Ref<MatrixXd> columns) {
  if (definite_) {
    definite_->Solve(columns.data(), static_cast<int>(columns.cols()));
    return;
  }
  const auto K = stiffness_.lower.selfadjointView<Eigen::Lower>();
  const MatrixXd right = columns;
  MatrixXd left = right;
  columns.setZero();
  for (int k = 0; k < kMaxRefinements && left.norm() > kResidual * right.norm(); ++k) {
    mixed_->Solve(left);
    columns += left;
    left = right - K * columns;
  }
}

std::size_t RestFactor::memory_bytes() const {
  return definite_ ? definite_->memory_bytes() : mixed_->memory_bytes();
}

}  // namespace palpate
