#include "slave/mechanics/fem/zone/zone_part.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "slave/mechanics/fem/zone/near/matrix_times.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Eigen::VectorXf;

// What a step lacks in all by what it lacks at once [-]. [tuned:
// TheRemainingChangeOfTheForceIsReported]
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
      tets_(zone_.corners, PositionsOf(green, zone_.nodes), nu, zone_.moduli) {
  const int unknowns = 3 * zone_.size(), points = contact_.unknowns();
  u_ = load_ = room_.moved = VectorXd::Zero(unknowns);
  prescribed_ = way_ = VectorXd::Zero(contact_.tool ? 3 : points);
  room_.gap = room_.at = VectorXd::Zero(points);
  room_.u = VectorXf::Zero(unknowns);
  room_.points = pressed_.forces = VectorXf::Zero(points);
  pressed_.points.reserve(contact_.points.size());
  dual_.u = MatrixXd::Zero(unknowns, 3);
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
  dual_.sampled_load = MatrixXd::Zero(samples_.unknowns(), 3);
}

void ZonePart::Condense(NearGreen& green) {
  Eigen::MatrixXf gathered;
  if (!green.Gather(zone_.nodes, zone_.nodes, &gathered)) {
    throw std::runtime_error("a zone beyond the reach of its Green's functions");
  }
  loads_ = std::make_unique<ZoneLoads>(3 * zone_.size(), std::move(gathered));
  const Eigen::MatrixXf& own = loads_->green();
  const int points = contact_.unknowns();
  columns_.setZero(own.rows(), points);
  MatrixXd compliance = MatrixXd::Zero(points, points);
  for (int k = 0; k < points; ++k) {
    for (const auto& [node, weight] : contact_.points[Index(k / 3)]) {
      columns_.col(k) += static_cast<float>(weight) * own.col(3 * node + k % 3);
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
  dual_.forces = forces_->DualForces();
  VectorXd sampled(samples_.unknowns());
  for (int c = 0; c < 3; ++c) {
    room_.gap = dual_.forces.col(c);
    room_.points = room_.gap.cast<float>();
    MatrixTimes(columns_, room_.points, &room_.u);
    dual_.u.col(c) = room_.u.cast<double>();
    room_.moved.setZero();
    SpreadForces(contact_, room_.gap, &room_.moved);
    samples_.SampleForces(room_.moved, &sampled);
    dual_.sampled_load.col(c) = sampled;
  }
}

void ZonePart::SetPressed() noexcept {
  const VectorXd& forces = forces_->forces();
  pressed_.points.clear();
  for (int p = 0; 3 * p < forces.size(); ++p) {
    if (!forces.segment<3>(3 * p).isZero(0)) pressed_.points.push_back(p);
  }
  pressed_.forces = forces.cast<float>();
}

void ZonePart::Reset() {
  for (VectorXd* v : {&u_, &load_, &prescribed_, &way_}) v->setZero();
  loads_->Reset();
  forces_->Reset();
  SetPressed();
  step_ = {};
}

// Along the way of before, which r follows.
void ZonePart::Begin(const VectorXd& prescribed) noexcept {
  const double before = way_.squaredNorm(), ahead = way_.dot(prescribed - prescribed_);
  loads_->Begin(before > 0 ? std::clamp(ahead / before, -1.0, 1.0) : 0);
  way_ = prescribed - prescribed_;
  prescribed_ = prescribed;
  step_.count = 0;
}

void ZonePart::TakeLoads(bool all) noexcept {
  if (all) {
    loads_->TakeAll();
  } else {
    loads_->TakeMostChanged(dual_.u, Force().norm());
  }
}

void ZonePart::Press(const VectorXd& at_others) noexcept {
  TakePoints(contact_, loads_->moved(), &room_.at);
  room_.at = at_others - room_.at;  // without forces
  TakePoints(contact_, u_, &room_.gap);
  forces_->Solve(prescribed_, room_.gap, room_.at);
  SetPressed();
}

void ZonePart::Move(const VectorXd& others) noexcept {
  step_.change = (Force() - step_.force).norm();
  step_.force = Force();
  room_.u.setZero();
  AddPlaces(columns_, pressed_.points, pressed_.forces, &room_.u);
  u_ = (room_.u - loads_->moved()).cast<double>() + others;
  load_ = -loads_->taken();
  SpreadForces(contact_, forces_->forces(), &load_);
  loads_->r().setZero();
  step_.smallest_jacobian = tets_.AddNonlinearForce(u_.data(), loads_->r().data());
  step_.lack = (dual_.u.transpose() * (loads_->r() - loads_->taken())).norm();
  ++step_.count;
}

// The first step of a tool does not tell what the next one changes.
double ZonePart::Remaining() const {
  if (forces_->tool() == nullptr) return kSlowness * step_.lack;
  if (step_.count < 2) return std::numeric_limits<double>::infinity();
  return std::max(kSlowness * step_.lack, step_.change);
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

void ZonePart::TakeState(const ZonePart& other, const std::vector<int>& number,
                         const VectorXd& others) {
  VectorXd taken = VectorXd::Zero(u_.size());
  for (int n = 0; n < zone_.size(); ++n) {
    const int old = number[Index(n)];
    if (old >= 0) taken.segment<3>(3 * n) = other.taken().segment<3>(3 * old);
  }
  std::vector<int> point_of(other.zone_.nodes.size(), -1), points;
  for (std::size_t p = 0; p < other.contact_.points.size(); ++p) {
    point_of[Index(other.contact_.points[p].front().first)] = static_cast<int>(p);
  }
  for (const auto& point : contact_.points) {
    const int node = number[Index(point.front().first)];
    points.push_back(node < 0 ? -1 : point_of[Index(node)]);
  }
  forces_->TakeState(*other.forces_, points);
  SetPressed();
  if (other.prescribed_.size() == prescribed_.size()) prescribed_ = other.prescribed_;
  loads_->SetTaken(taken);
  Move(others);
  loads_->SetTaken(taken);  // with the zone's r
}

}  // namespace palpate
