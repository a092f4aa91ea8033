#include "slave/mechanics/fem/zone/zone_part.h"

#include <algorithm>
#include <stdexcept>

#include "shared/geometry/index.h"
#include "slave/mechanics/fem/zone/matrix_times.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Eigen::VectorXf;

// What a step lacks in all by what it lacks at once [-]. [tuned:
// TheRemainingChangeOfTheForceIsTold]
constexpr double kSlowness = 3;
constexpr int kContactSamples = 24;  // of a zone, on the contact
constexpr int kSamples = 64;         // of a zone

std::vector<Vector3d> PositionsOf(const NearGreen& green, std::span<const int> nodes) {
  std::vector<Vector3d> positions;
  for (const int node : nodes) positions.push_back(green.positions()[Index(node)]);
  return positions;
}

}  // namespace

ZonePart::ZonePart(NearGreen& green, Zone zone, double nu, ZoneContact contact)
    : zone_(std::move(zone)),
      contact_(std::move(contact)),
      tets_(zone_.corners, PositionsOf(green, zone_.nodes), nu),
      mixer_(3 * zone_.size()) {
  const int unknowns = 3 * zone_.size(), points = contact_.unknowns();
  u_ = load_ = r_ = mixed_ = moved_ = VectorXd::Zero(unknowns);
  lambda_ = gap_ = at_ = VectorXd::Zero(points);
  load_f_ = u_f_ = VectorXf::Zero(unknowns);
  gap_f_ = VectorXf::Zero(points);
  std::vector<int> touched;
  for (const auto& point : contact_.points) {
    for (const auto& [node, weight] : point) touched.push_back(zone_.nodes[Index(node)]);
  }
  SpreadNodes(green.positions(), touched, kContactSamples, &samples_.nodes);
  SpreadNodes(green.positions(), zone_.nodes, kSamples, &samples_.nodes);
  samples_.weights =
      SampleWeights(PositionsOf(green, samples_.nodes), PositionsOf(green, zone_.nodes));
  sampled_load_ = VectorXd::Zero(samples_.unknowns());
  dual_ = dual_load_ = MatrixXd::Zero(unknowns, 3);
  dual_forces_ = MatrixXd::Zero(points, 3);
  sampled_dual_ = MatrixXd::Zero(samples_.unknowns(), 3);
  Condense(green);
}

void ZonePart::Condense(NearGreen& green) {
  if (!green.Gather(zone_.nodes, zone_.nodes, &green_)) {
    throw std::runtime_error("a zone beyond the reach of its Green's functions");
  }
  const int points = contact_.unknowns();
  columns_.setZero(green_.rows(), points);
  for (int k = 0; k < points; ++k) {
    for (const auto& [node, weight] : contact_.points[Index(k / 3)]) {
      columns_.col(k) += static_cast<float>(weight) * green_.col(3 * node + k % 3);
    }
  }
  compliance_.setZero(points, points);
  for (int k = 0; k < points; ++k) {
    for (const auto& [node, weight] : contact_.points[Index(k / 3)]) {
      compliance_.row(k) += weight * columns_.row(3 * node + k % 3).cast<double>();
    }
  }
  compliance_ = 0.5 * (compliance_ + compliance_.transpose()).eval();
  const MatrixXd unit = Matrix3d::Identity().replicate(points / 3, 1);
  if (contact_.tool) {
    std::vector<Vector3d> rest;
    for (const auto& point : contact_.points) {
      rest.push_back(green.positions()[Index(zone_.nodes[Index(point.front().first)])]);
    }
    tool_ = std::make_unique<ToolContact>(*contact_.tool, contact_.placement, contact_.friction,
                                          std::move(rest), compliance_);
    return;
  }
  if (contact_.loaded) return SetDual(-unit);
  inverse_.compute(compliance_);
  if (inverse_.info() != Eigen::Success) throw std::runtime_error("a contact cannot be condensed");
  SetDual(inverse_.solve(unit));
}

void ZonePart::SetDual(const MatrixXd& forces) noexcept {
  for (int c = 0; c < 3; ++c) {
    gap_ = forces.col(c);
    gap_f_ = gap_.cast<float>();
    MatrixTimes(columns_, gap_f_, &u_f_);
    dual_.col(c) = u_f_.cast<double>();
    moved_.setZero();
    SpreadForces(gap_, &moved_);
    dual_load_.col(c) = moved_;
    samples_.SampleForces(moved_, &sampled_load_);
    sampled_dual_.col(c) = sampled_load_;
  }
  samples_.SampleForces(load_, &sampled_load_);
}

void ZonePart::RefreshDual() noexcept {
  if (tool_ == nullptr) return;
  dual_forces_.setZero();
  if (tool_->Factorise()) tool_->DualForces(&dual_forces_);
  SetDual(dual_forces_);
}

void ZonePart::Reset() {
  for (VectorXd* v : {&u_, &load_, &r_, &mixed_, &lambda_, &sampled_load_}) v->setZero();
  Restart();
  if (tool_ != nullptr) tool_->Reset();
  lack_ = change_ = 0;
}

void ZonePart::SpreadForces(const VectorXd& forces, VectorXd* load) const noexcept {
  for (std::size_t p = 0; p < contact_.points.size(); ++p) {
    for (const auto& [node, weight] : contact_.points[p]) {
      load->segment<3>(3 * node) += weight * forces.segment<3>(3 * static_cast<int>(p));
    }
  }
}

void ZonePart::Step(const VectorXd& prescribed, const VectorXd& others) noexcept {
  const Vector3d before = Force();
  if (!restarted_) mixer_.Advance(r_, &mixed_);
  restarted_ = false;
  if (contact_.loaded) {
    lambda_ = prescribed;
  } else {
    load_f_ = mixed_.cast<float>();
    TransposedTimes(columns_, load_f_, &gap_f_);
    TakePoints(others, &at_);
    at_ -= gap_f_.cast<double>();  // without forces
    if (tool_ != nullptr) {
      TakePoints(u_, &gap_);
      tool_->Move(prescribed.head<3>());
      tool_->FindGaps(gap_);
      tool_->Solve(at_, &lambda_);
    } else {
      lambda_ = prescribed - at_;
      inverse_.solveInPlace(lambda_);
    }
  }
  load_ = -mixed_;
  SpreadForces(lambda_, &load_);
  load_f_ = load_.cast<float>();
  MatrixTimes(green_, load_f_, &u_f_);
  u_ = u_f_.cast<double>() + others;
  samples_.SampleForces(load_, &sampled_load_);
  r_.setZero();
  tets_.AddNonlinearForce(u_.data(), r_.data());
  change_ = (Force() - before).norm();
  lack_ = (dual_.transpose() * (r_ - mixed_)).norm();
}

double ZonePart::Remaining() const {
  return tool_ != nullptr ? std::max(kSlowness * lack_, change_) : kSlowness * lack_;
}

Vector3d ZonePart::Force() const {
  Vector3d force = Vector3d::Zero();
  for (int k = 0; k < lambda_.size(); ++k) force[k % 3] += lambda_[k];
  return force;
}

Vector3d ZonePart::MeanDisplacement() const {
  Vector3d mean = Vector3d::Zero();
  for (const auto& point : contact_.points) {
    for (const auto& [node, weight] : point) {
      mean += weight * u_.segment<3>(3 * node) / static_cast<double>(contact_.points.size());
    }
  }
  return mean;
}

void ZonePart::HeldLoad(const VectorXd& moved, VectorXd* load) noexcept {
  load->setZero();
  if (contact_.loaded) return;
  moved_.setZero();
  samples_.AddField(moved, &moved_);
  TakePoints(moved_, &at_);
  if (tool_ != nullptr) {
    tool_->HeldForces(at_, &gap_);
  } else {
    gap_ = -at_;
    inverse_.solveInPlace(gap_);
  }
  moved_.setZero();
  SpreadForces(gap_, &moved_);
  samples_.SampleForces(moved_, load);
}

void ZonePart::Accept() noexcept {
  if (tool_ == nullptr) return;
  TakePoints(u_, &at_);
  tool_->Accept(at_);
}

void ZonePart::TakeState(const ZonePart& other, const std::vector<int>& number, VectorXd u) {
  u_ = std::move(u);
  r_.setZero();
  tets_.AddNonlinearForce(u_.data(), r_.data());
  Restart();
  std::vector<int> point_of(other.zone_.nodes.size(), -1), points;
  for (std::size_t p = 0; p < other.contact_.points.size(); ++p) {
    point_of[Index(other.contact_.points[p].front().first)] = static_cast<int>(p);
  }
  for (std::size_t p = 0; p < contact_.points.size(); ++p) {
    const int node = number[Index(contact_.points[p].front().first)];
    points.push_back(node < 0 ? -1 : point_of[Index(node)]);
    if (points.back() < 0) continue;
    lambda_.segment<3>(3 * static_cast<int>(p)) = other.lambda_.segment<3>(3 * points.back());
  }
  if (tool_ != nullptr && other.tool_ != nullptr) tool_->TakeState(*other.tool_, points);
}

void ZonePart::TakePoints(const VectorXd& u, VectorXd* at) const noexcept {
  for (std::size_t p = 0; p < contact_.points.size(); ++p) {
    Vector3d mean = Vector3d::Zero();
    for (const auto& [node, weight] : contact_.points[p]) mean += weight * u.segment<3>(3 * node);
    at->segment<3>(3 * static_cast<int>(p)) = mean;
  }
}

}  // namespace palpate
