#include "slave/mechanics/fem/solid/supports.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include "shared/geometry/symmetric_eigen.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// Nodes without an element are ignored.
Eigen::AlignedBox3d BoxOf(const TetMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const int node : mesh.connectivity) box.extend(mesh.nodes[Index(node)]);
  return box;
}

}  // namespace

Supports::Supports(const TetMesh& mesh, const BlockLayout& layout, const HeldNodes& held,
                   VectorXd volumes)
    : mesh_(mesh),
      layout_(layout),
      held_(HeldWithMiddles(mesh, held)),
      volumes_(std::move(volumes)),
      motions_(BoxOf(mesh)) {
  used_.assign(Index(mesh.node_count()), false);
  for (const int node : mesh.connectivity) used_[Index(node)] = true;
  node_of_.assign(Index(layout.size()), -1);
  component_of_ = node_of_;
  for (int node = 0; node < mesh.node_count(); ++node) {
    for (int c = 0; c < 3; ++c) {
      node_of_[Index(layout.first(node) + c)] = node;
      component_of_[Index(layout.first(node) + c)] = c;
    }
  }
}

void Supports::Hold(Balance* balance) const {
  balance->fixed.assign(Index(layout_.size()), 0);
  for (int node = 0; node < mesh_.node_count(); ++node) {
    for (int c = 0; c < 3; ++c) {
      if (!Used(node) || held_[Index(node)][Index(c)]) {
        balance->fixed[Index(layout_.first(node) + c)] = 1;
      }
    }
    if (!Used(node) && layout_.has_pressure() && node < mesh_.vertex_count) {
      balance->fixed[Index(layout_.pressure(node))] = 1;
    }
  }
}

bool Supports::Forbids(int node, const Vector3d& displacement) const {
  for (int c = 0; c < 3; ++c) {
    if (held_[Index(node)][Index(c)] && displacement[c] != 0) return true;
  }
  return false;
}

fem::HeldMotions Supports::Held(const Balance& balance) const {
  fem::HeldMotions held = motions_;
  for (int i = 0; i < layout_.size(); ++i) {
    const int node = node_of_[Index(i)];
    if (!balance.fixed[Index(i)] || node < 0 || !Used(node)) continue;
    held.Hold(Row(node, component_of_[Index(i)]));
  }
  for (const auto& point : balance.rows) {
    Motion row = Motion::Zero();
    for (const auto& [unknown, weight] : point.weights) {
      row += weight * Row(node_of_[Index(unknown)], component_of_[Index(unknown)]);
    }
    held.Hold(row);
  }
  return held;
}

void Supports::Pin(Balance* balance) {
  pins_.clear();
  free_motions_ = Held(*balance).Free();

  // Fixes unknowns one by one, each time the one with the largest displacement under the remaining
  // free motions.
  auto left = free_motions_;
  while (left.cols() > 0) {
    int pin = -1;
    double most = 0;
    for (int i = 0; i < layout_.size(); ++i) {
      const int node = node_of_[Index(i)];
      if (node < 0 || balance->fixed[Index(i)]) continue;
      const double moved = (left.transpose() * Row(node, component_of_[Index(i)])).squaredNorm();
      if (moved > most) most = moved, pin = i;
    }
    if (pin < 0) break;
    balance->fixed[Index(pin)] = 1;
    pins_.push_back(pin);
    const VectorXd row = left.transpose() * Row(node_of_[Index(pin)], component_of_[Index(pin)]);
    // The remaining free motions are the combinations that do not move this unknown.
    const Eigen::MatrixXd outer = row * row.transpose() / row.squaredNorm();
    const SymmetricEigen split = EigenOf(outer);
    left = (left * split.vectors.leftCols(left.cols() - 1)).eval();
  }
}

double Supports::Imbalance(const VectorXd& force) const {
  Motion work = Motion::Zero();
  double total = 0;
  for (int i = 0; i < layout_.size(); ++i) {
    const int node = node_of_[Index(i)];
    if (node < 0 || !Used(node)) continue;
    work += force[i] * Row(node, component_of_[Index(i)]);
    total += std::abs(force[i]);
  }
  const VectorXd free_work = free_motions_.transpose() * work;
  return total > 0 ? free_work.norm() / total : 0;
}

double Supports::PinForce(const VectorXd& unbalanced) const {
  double sum = 0;
  for (const int pin : pins_) sum += unbalanced[pin] * unbalanced[pin];
  return std::sqrt(sum);
}

void Supports::RemoveFreeMotion(VectorXd* x) const {
  const auto count = free_motions_.cols();
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(count, count);
  VectorXd right = VectorXd::Zero(count);
  for (int node = 0; node < mesh_.node_count(); ++node) {
    Eigen::Matrix<double, 3, 6> rows;
    for (int c = 0; c < 3; ++c) rows.row(c) = Row(node, c);
    const Eigen::MatrixXd moved = rows * free_motions_;
    normal += volumes_[node] * moved.transpose() * moved;
    right += volumes_[node] * moved.transpose() * x->segment<3>(layout_.first(node));
  }
  const VectorXd amount = normal.ldlt().solve(right);
  const Motion motion = free_motions_ * amount;
  for (int node = 0; node < mesh_.node_count(); ++node) {
    for (int c = 0; Used(node) && c < 3; ++c) {
      (*x)[layout_.first(node) + c] -= Row(node, c).dot(motion);
    }
  }
}

}  // namespace palpate
