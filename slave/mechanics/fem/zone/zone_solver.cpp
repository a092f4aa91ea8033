#include "slave/mechanics/fem/zone/zone_solver.h"

#include <algorithm>
#include <utility>

#include "shared/geometry/index.h"
#include "slave/mechanics/linear/mumps.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kSlowest = 0.9;  // part of a change that the next step still changes by [-]

// Inner nodes in an order that keeps their factor sparse, then the border, which is full.
std::vector<int> OrderOf(const Zone& zone) {
  std::vector<std::vector<int>> neighbours(Index(zone.inner));
  for (const auto& tet : zone.corners) {
    for (const int a : tet) {
      for (const int b : tet) {
        if (a < zone.inner && b < zone.inner) neighbours[Index(a)].push_back(b);
      }
    }
  }
  for (auto& list : neighbours) {
    std::ranges::sort(list);
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  std::vector<int> order;
  if (zone.inner > 0) order = EliminationOrder(neighbours);
  for (int n = zone.inner; n < zone.size(); ++n) order.push_back(n);
  return order;
}

SparseLdlt::Matrix PatternOf(const Zone& zone, const std::vector<int>& unknown) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](int i, int j) {
    const int row = unknown[Index(i)], column = unknown[Index(j)];
    if (row <= column) entries.emplace_back(row, column, 0.0);
  };
  for (const auto& tet : zone.corners) {
    for (int i = 0; i < 12; ++i) {
      for (int j = 0; j < 12; ++j)
        add(3 * tet[Index(i / 3)] + i % 3, 3 * tet[Index(j / 3)] + j % 3);
    }
  }
  for (int i = 3 * zone.inner; i < 3 * zone.size(); ++i) {
    for (int j = 3 * zone.inner; j < 3 * zone.size(); ++j) add(i, j);
  }
  SparseLdlt::Matrix pattern(3 * zone.size(), 3 * zone.size());
  pattern.setFromTriplets(entries.begin(), entries.end());
  return pattern;
}

int EntryAt(const SparseLdlt::Matrix& matrix, int row, int column) {
  const int* first = matrix.innerIndexPtr() + matrix.outerIndexPtr()[column];
  const int* last = matrix.innerIndexPtr() + matrix.outerIndexPtr()[column + 1];
  return static_cast<int>(std::lower_bound(first, last, row) - matrix.innerIndexPtr());
}

}  // namespace

ZoneBody MakeZoneBody(Zone zone, const std::vector<Vector3d>& nodes, std::vector<char> held,
                      MatrixXd rest, double nu) {
  std::vector<Vector3d> positions;
  for (const int node : zone.nodes) positions.push_back(nodes[Index(node)]);
  NeoHookeanTets tets(zone.corners, positions, nu);
  std::vector<int> unknown(3 * zone.nodes.size());
  int next = 0;
  for (const int node : OrderOf(zone)) {
    for (int c = 0; c < 3; ++c) unknown[Index(3 * node + c)] = next++;
  }
  SparseLdlt::Matrix pattern = PatternOf(zone, unknown);
  return {std::move(zone), std::move(tets),    std::move(rest),
          std::move(held), std::move(pattern), std::move(unknown)};
}

Vector3d MeanOf(const VectorXd& u, const ZoneContact::Point& point) {
  Vector3d mean = Vector3d::Zero();
  for (const auto& [node, weight] : point) mean += weight * u.segment<3>(3 * node);
  return mean;
}

ZoneTangent::ZoneTangent(const ZoneBody& body, ZoneContact contact)
    : body_(body),
      contact_(std::move(contact)),
      matrix_(body.pattern),
      factor_(matrix_),
      permuted_(VectorXd::Zero(matrix_.cols())),
      columns_(MatrixXd::Zero(matrix_.cols(), contact_.unknowns())),
      compliance_matrix_(columns_.cols(), columns_.cols()),
      compliance_(columns_.cols()) {
  factor_.Allocate(matrix_);
  const auto entry = [&](int i, int j) {
    const int row = body_.unknown[Index(i)], column = body_.unknown[Index(j)];
    const bool counts = row <= column && !body_.held[Index(i)] && !body_.held[Index(j)];
    return counts ? EntryAt(matrix_, row, column) : -1;
  };
  for (const auto& tet : body_.zone.corners) {
    auto& block = entry_.emplace_back();
    for (int j = 0; j < 12; ++j) {
      for (int i = 0; i < 12; ++i) {
        block[Index(12 * j + i)] =
            entry(3 * tet[Index(i / 3)] + i % 3, 3 * tet[Index(j / 3)] + j % 3);
      }
    }
  }
  const int first = 3 * body_.zone.inner;
  for (int j = 0; j < body_.rest.cols(); ++j) {
    for (int i = 0; i < body_.rest.rows(); ++i) {
      const int at = entry(first + i, first + j);
      if (at >= 0) rest_.emplace_back(at, body_.rest(i, j));
    }
  }
}

void ZoneTangent::Assemble(const VectorXd& u) {
  double* values = matrix_.valuePtr();
  std::fill_n(values, matrix_.nonZeros(), 0.0);
  NeoHookeanTets::Block block;
  for (int t = 0; t < body_.tets.size(); ++t) {
    body_.tets.Stiffness(t, u.data(), &block);
    const auto& entry = entry_[Index(t)];
    for (std::size_t k = 0; k < entry.size(); ++k) {
      if (entry[k] >= 0) values[entry[k]] += block.data()[k];
    }
  }
  for (const auto& [at, value] : rest_) values[at] += value;
  for (std::size_t i = 0; i < body_.held.size(); ++i) {
    const int row = body_.unknown[i];
    if (body_.held[i]) values[EntryAt(matrix_, row, row)] = 1;
  }
}

bool ZoneTangent::Compute(const VectorXd& u) {
  Assemble(u);
  if (!factor_.Factorize(matrix_, false)) return false;
  VectorXd x(matrix_.cols());
  for (int k = 0; k < columns_.cols(); ++k) {
    x.setZero();
    for (const auto& [node, weight] : contact_.points[Index(k / 3)]) x[3 * node + k % 3] = weight;
    Solve(&x);
    columns_.col(k) = x;
  }
  if (contact_.loaded) return true;
  compliance_matrix_.setZero();
  for (int k = 0; k < columns_.cols(); ++k) {
    for (const auto& [node, weight] : contact_.points[Index(k / 3)]) {
      compliance_matrix_.row(k) += weight * columns_.row(3 * node + k % 3);
    }
  }
  compliance_.compute(compliance_matrix_);
  return compliance_.info() == Eigen::Success;
}

void ZoneTangent::Solve(VectorXd* x) {
  for (std::size_t i = 0; i < body_.unknown.size(); ++i) {
    permuted_[body_.unknown[i]] = body_.held[i] ? 0 : (*x)[static_cast<int>(i)];
  }
  factor_.Solve(&permuted_);
  for (std::size_t i = 0; i < body_.unknown.size(); ++i) {
    (*x)[static_cast<int>(i)] = permuted_[body_.unknown[i]];
  }
}

ZoneSolver::ZoneSolver(const ZoneBody& body, ZoneContact contact)
    : body_(body), contact_(std::move(contact)) {
  u_ = load_ = residual_ = VectorXd::Zero(static_cast<int>(body.unknown.size()));
  lambda_ = gap_ = VectorXd::Zero(contact_.unknowns());
}

void ZoneSolver::Reset() {
  change_.setZero();
  u_.setZero();
  lambda_.setZero();
  load_.setZero();
}

void ZoneSolver::AddRest(const VectorXd& u, VectorXd* f) const noexcept {
  const int border = static_cast<int>(body_.rest.rows());
  f->tail(border).noalias() += body_.rest * u.tail(border);
}

void ZoneSolver::InternalForce(const VectorXd& u, VectorXd* f) const noexcept {
  f->setZero();
  body_.tets.AddForce(u.data(), f->data());
  AddRest(u, f);
}

void ZoneSolver::LinearForce(const VectorXd& u, VectorXd* f) const noexcept {
  f->setZero();
  body_.tets.AddLinearForce(u.data(), f->data());
  AddRest(u, f);
}

void ZoneSolver::Step(ZoneTangent& tangent, const VectorXd& prescribed) noexcept {
  change_before_ = change_.norm();
  if (contact_.loaded) lambda_ = prescribed;
  InternalForce(u_, &residual_);
  residual_ = load_ - residual_;
  for (std::size_t p = 0; p < contact_.points.size(); ++p) {
    for (const auto& [node, weight] : contact_.points[p]) {
      residual_.segment<3>(3 * node) += weight * lambda_.segment<3>(3 * static_cast<int>(p));
    }
  }
  tangent.Solve(&residual_);
  u_ += residual_;
  change_.setZero();
  if (contact_.loaded) {
    for (const auto& [node, weight] : contact_.points.front()) {
      change_ += weight * residual_.segment<3>(3 * node);
    }
    return;
  }
  for (std::size_t p = 0; p < contact_.points.size(); ++p) {
    const int at = 3 * static_cast<int>(p);
    gap_.segment<3>(at) = prescribed.segment<3>(at) - MeanOf(u_, contact_.points[p]);
  }
  tangent.compliance().solveInPlace(gap_);
  lambda_ += gap_;
  u_.noalias() += tangent.columns() * gap_;
  for (int k = 0; k < gap_.size(); ++k) change_[k % 3] += gap_[k];
}

double ZoneSolver::Remaining() const {
  const double change = change_.norm();
  if (!(change > 0)) return change;
  const double part = std::min(kSlowest, change / change_before_);
  return change * std::max(1.0, part / (1 - part));
}

Vector3d ZoneSolver::Force() const {
  Vector3d force = Vector3d::Zero();
  for (int k = 0; k < lambda_.size(); ++k) force[k % 3] += lambda_[k];
  return force;
}

}  // namespace palpate
