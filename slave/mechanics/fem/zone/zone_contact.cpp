#include "slave/mechanics/fem/zone/zone_contact.h"

#include <stdexcept>

#include "slave/mesh/index.h"

namespace palpate {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

ContactForces::ContactForces(const ZoneContact& contact, std::vector<Vector3d> rest,
                             MatrixXd compliance)
    : loaded_(contact.loaded),
      compliance_(std::move(compliance)),
      forces_(VectorXd::Zero(compliance_.rows())) {
  if (contact.tool) {
    tool_ = std::make_unique<ToolContact>(*contact.tool, contact.placement, contact.friction,
                                          std::move(rest), compliance_);
  } else if (!loaded_) {
    inverse_.compute(compliance_);
    if (inverse_.info() != Eigen::Success) {
      throw std::runtime_error("a contact cannot be condensed");
    }
  }
}

void ContactForces::Reset() {
  forces_.setZero();
  if (tool_ != nullptr) tool_->Reset();
}

void ContactForces::Solve(const VectorXd& prescribed, const VectorXd& now,
                          const VectorXd& free) noexcept {
  if (loaded_) {
    forces_ = prescribed;
  } else if (tool_ != nullptr) {
    tool_->Move(prescribed.head<3>());
    tool_->FindGaps(now);
    tool_->Solve(free, &forces_);
  } else {
    forces_ = prescribed - free;
    inverse_.solveInPlace(forces_);
  }
}

void ContactForces::Hold(const VectorXd& moved, VectorXd* forces) noexcept {
  if (loaded_) {
    forces->setZero();
  } else if (tool_ != nullptr) {
    tool_->HeldForces(moved, forces);
  } else {
    *forces = -moved;
    inverse_.solveInPlace(*forces);
  }
}

MatrixXd ContactForces::DualForces() noexcept {
  const MatrixXd unit = Matrix3d::Identity().replicate(forces_.size() / 3, 1);
  if (loaded_) return -unit;
  if (tool_ == nullptr) return inverse_.solve(unit);
  MatrixXd forces = MatrixXd::Zero(forces_.size(), 3);
  if (tool_->Factorise()) tool_->DualForces(&forces);
  return forces;
}

void ContactForces::Accept(const VectorXd& now) noexcept {
  if (tool_ != nullptr) tool_->Accept(now);
}

void ContactForces::TakeState(const ContactForces& other, const std::vector<int>& number) {
  for (std::size_t p = 0; p < number.size(); ++p) {
    if (number[p] < 0) continue;
    forces_.segment<3>(3 * static_cast<int>(p)) = other.forces_.segment<3>(3 * number[p]);
  }
  if (tool_ != nullptr && other.tool_ != nullptr) tool_->TakeState(*other.tool_, number);
}

Vector3d ContactForces::Sum() const {
  Vector3d sum = Vector3d::Zero();
  for (int k = 0; k < forces_.size(); ++k) sum[k % 3] += forces_[k];
  return sum;
}

void SpreadForces(const ZoneContact& contact, const VectorXd& forces, VectorXd* load) noexcept {
  for (std::size_t p = 0; p < contact.points.size(); ++p) {
    for (const auto& [node, weight] : contact.points[p]) {
      load->segment<3>(3 * node) += weight * forces.segment<3>(3 * static_cast<int>(p));
    }
  }
}

}  // namespace palpate
