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
      tets_(zone_.corners, PositionsOf(green, zone_.nodes), nu, zone_.moduli),
      mixer_(3 * zone_.size()) {
  const int unknowns = 3 * zone_.size(), points = contact_.unknowns();
  u_ = load_ = r_ = mixed_ = room_.moved = VectorXd::Zero(unknowns);
  room_.gap = room_.at = VectorXd::Zero(points);
  room_.load = room_.u = VectorXf::Zero(unknowns);
  room_.points = VectorXf::Zero(points);
  dual_.u = dual_.load = MatrixXd::Zero(unknowns, 3);
  SampleZone(green);
  Condense(green);
  RefreshDual();
}

void ZonePart::SampleZone(const NearGreen& green) {
  std::vector<int> touched;
  for (const auto& point : contact_.points) {
    for (const auto& [node, weight] : point) touched.push_back(zone_.nodes[Index(node)]);
  }
  SpreadNodes(green.positions(), touched, kContactSamples, &samples_.nodes);
  SpreadNodes(green.positions(), zone_.nodes, kSamples, &samples_.nodes);
  samples_.weights =
      SampleWeights(PositionsOf(green, samples_.nodes), PositionsOf(green, zone_.nodes));
  sampled_load_ = VectorXd::Zero(samples_.unknowns());
  dual_.sampled_load = MatrixXd::Zero(samples_.unknowns(), 3);
}

void ZonePart::Condense(NearGreen& green) {
  if (!green.Gather(zone_.nodes, zone_.nodes, &green_)) {
    throw std::runtime_error("a zone beyond the reach of its Green's functions");
  }
  const int points = contact_.unknowns();
  columns_.setZero(green_.rows(), points);
  MatrixXd compliance = MatrixXd::Zero(points, points);
  for (int k = 0; k < points; ++k) {
    for (const auto& [node, weight] : contact_.points[Index(k / 3)]) {
      columns_.col(k) += static_cast<float>(weight) * green_.col(3 * node + k % 3);
    }
  }
  for (int k = 0; k < points; ++k) {
    for (const auto& [node, weight] : contact_.points[Index(k / 3)]) {
      compliance.row(k) += weight * columns_.row(3 * node + k % 3).cast<double>();
    }
  }
  compliance = 0.5 * (compliance + compliance.transpose()).eval();
  std::vector<Vector3d> rest;
  for (const auto& point : contact_.points) {
    rest.push_back(green.positions()[Index(zone_.nodes[Index(point.front().first)])]);
  }
  forces_ = std::make_unique<ContactForces>(contact_, std::move(rest), std::move(compliance));
}

void ZonePart::RefreshDual() noexcept {
  const MatrixXd forces = forces_->DualForces();
  for (int c = 0; c < 3; ++c) {
    room_.gap = forces.col(c);
    room_.points = room_.gap.cast<float>();
    MatrixTimes(columns_, room_.points, &room_.u);
    dual_.u.col(c) = room_.u.cast<double>();
    room_.moved.setZero();
    SpreadForces(contact_, room_.gap, &room_.moved);
    dual_.load.col(c) = room_.moved;
    samples_.SampleForces(room_.moved, &sampled_load_);
    dual_.sampled_load.col(c) = sampled_load_;
  }
  samples_.SampleForces(load_, &sampled_load_);
}

void ZonePart::Reset() {
  for (VectorXd* v : {&u_, &load_, &r_, &mixed_, &sampled_load_}) v->setZero();
  Restart();
  forces_->Reset();
  lack_ = change_ = 0;
}

// E lambda less what the tetrahedra resist.
void ZonePart::SetLoad() noexcept {
  load_ = -mixed_;
  SpreadForces(contact_, forces_->forces(), &load_);
  samples_.SampleForces(load_, &sampled_load_);
}

void ZonePart::Step(const VectorXd& prescribed, const VectorXd& others) noexcept {
  const Vector3d before = Force();
  if (!restarted_) mixer_.Advance(r_, &mixed_);
  restarted_ = false;
  is_alone_ = others.isZero(0);
  room_.load = mixed_.cast<float>();
  TransposedTimes(columns_, room_.load, &room_.points);
  TakePoints(contact_, others, &room_.at);
  room_.at -= room_.points.cast<double>();  // without forces
  TakePoints(contact_, u_, &room_.gap);
  forces_->Solve(prescribed, room_.gap, room_.at);
  SetLoad();
  room_.load = load_.cast<float>();
  MatrixTimes(green_, room_.load, &room_.u);
  u_ = room_.u.cast<double>() + others;
  r_.setZero();
  tets_.AddNonlinearForce(u_.data(), r_.data());
  change_ = (Force() - before).norm();
  lack_ = (dual_.u.transpose() * (r_ - mixed_)).norm();
}

double ZonePart::Remaining() const {
  const bool alone = is_alone_ && forces_->tool() == nullptr;
  return std::max(kSlowness * lack_, alone ? 0 : change_);
}

Vector3d ZonePart::MeanDisplacement() const {
  VectorXd at(contact_.unknowns());
  TakePoints(contact_, u_, &at);
  Vector3d mean = Vector3d::Zero();
  for (int k = 0; k < at.size(); ++k) mean[k % 3] += 3 * at[k] / static_cast<double>(at.size());
  return mean;
}

void ZonePart::HeldLoad(const VectorXd& moved, VectorXd* load) noexcept {
  room_.moved.setZero();
  samples_.AddField(moved, &room_.moved);
  TakePoints(contact_, room_.moved, &room_.at);
  forces_->Hold(room_.at, &room_.gap);
  room_.moved.setZero();
  SpreadForces(contact_, room_.gap, &room_.moved);
  samples_.SampleForces(room_.moved, load);
}

void ZonePart::Accept() noexcept {
  TakePoints(contact_, u_, &room_.at);
  forces_->Accept(room_.at);
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
  for (const auto& point : contact_.points) {
    const int node = number[Index(point.front().first)];
    points.push_back(node < 0 ? -1 : point_of[Index(node)]);
  }
  forces_->TakeState(*other.forces_, points);
  SetLoad();
}

}  // namespace palpate
