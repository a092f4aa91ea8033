#include "slave/mechanics/fem/zone/zone_part.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "shared/geometry/index.h"
#include "slave/mechanics/fem/zone/matrix_times.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Eigen::VectorXf;

// What a step lacks in all by what it lacks at once [-]. [tuned:
// TheRemainingChangeOfTheForceIsTold]
constexpr double kSlowness = 3;
constexpr int kContactSamples = 24;  // of a zone, on the contact
constexpr int kSamples = 64;         // of a zone
// Nodes whose load is taken over in a step of few [nodes]. [tuned: bench_zone: p99_us]
constexpr int kFew = 64;
// What a change that waits would do to the force, by the force: that of all nodes of a zone
// together is a tenth of what steps may lack [-]. [derived: 2e-3 / 10 / sqrt(250) / 3]
constexpr double kUnseen = 4e-6;
// Steps of few after which the rounding of single precision is removed: sqrt(1000) times 1e-7.
constexpr int kMostFew = 1000;

std::vector<Vector3d> PositionsOf(const NearGreen& green, std::span<const int> nodes) {
  std::vector<Vector3d> positions;
  for (const int node : nodes) positions.push_back(green.positions()[Index(node)]);
  return positions;
}

// By a share of its change since `before`, which becomes what it was.
template <class Scalar, class Vector>
void Extrapolate(Scalar share, Vector* now, Vector* before) {
  before->swap(*now);
  *now = *before + share * (*before - *now);
}

}  // namespace

ZonePart::ZonePart(NearGreen& green, Zone zone, double nu, ZoneContact contact)
    : zone_(std::move(zone)),
      contact_(std::move(contact)),
      tets_(zone_.corners, PositionsOf(green, zone_.nodes), nu, zone_.moduli),
      mixer_(3 * zone_.size()) {
  const int unknowns = 3 * zone_.size(), points = contact_.unknowns();
  for (VectorXd* v :
       {&u_, &load_, &r_, &taken_, &next_, &before_.r, &before_.taken, &room_.moved}) {
    v->setZero(unknowns);
  }
  prescribed_ = way_ = VectorXd::Zero(contact_.tool ? 3 : points);
  room_.gap = room_.at = VectorXd::Zero(points);
  moved_ = before_.moved = room_.u = VectorXf::Zero(unknowns);
  room_.load = VectorXf::Zero(unknowns);
  room_.points = pressed_forces_ = VectorXf::Zero(points);
  pressed_points_.reserve(contact_.points.size());
  room_.changed.resize(Index(zone_.size()));
  room_.places.reserve(Index(kFew));
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
  pressed_points_.clear();
  for (int p = 0; 3 * p < forces.size(); ++p) {
    if (!forces.segment<3>(3 * p).isZero(0)) pressed_points_.push_back(p);
  }
  pressed_forces_ = forces.cast<float>();
}

void ZonePart::Reset() {
  for (VectorXd* v :
       {&u_, &load_, &r_, &taken_, &next_, &before_.r, &before_.taken, &prescribed_, &way_}) {
    v->setZero();
  }
  moved_.setZero();
  before_.moved.setZero();
  mixer_.Reset();
  forces_->Reset();
  SetPressed();
  steps_ = few_ = 0;
  lack_ = last_ = 0;
  smallest_jacobian_ = 1;
}

// Along the way of before: r follows what is prescribed, and with r as taken goes what it moves.
void ZonePart::Begin(const VectorXd& prescribed) noexcept {
  const double before = way_.squaredNorm(), ahead = way_.dot(prescribed - prescribed_);
  const double share = before > 0 ? std::clamp(ahead / before, -1.0, 1.0) : 0;
  way_ = prescribed - prescribed_;
  prescribed_ = prescribed;
  next_ = r_ + share * (r_ - before_.r);
  before_.r = r_;
  Extrapolate(share, &taken_, &before_.taken);
  Extrapolate(static_cast<float>(share), &moved_, &before_.moved);
  mixer_.Reset();
  steps_ = 0;
}

void ZonePart::TakeLoads(bool all) noexcept {
  if (steps_ > 0) next_ = r_;
  if (!all && ++few_ < kMostFew) {
    TakeMostChanged();
    return;
  }
  few_ = 0;
  if (steps_ > 0) {
    mixer_.Advance(r_, &taken_);
  } else {
    taken_ = next_;
  }
  room_.load = taken_.cast<float>();
  MatrixTimes(green_, room_.load, &moved_);
}

// By what the change does to the force.
void ZonePart::TakeMostChanged() noexcept {
  const double least = std::pow(kUnseen, 2) * Force().squaredNorm();
  auto end = room_.changed.begin();
  for (int n = 0; n < zone_.size(); ++n) {
    const double change = (next_.segment<3>(3 * n) - taken_.segment<3>(3 * n)).squaredNorm();
    const double seen = change * dual_.u.middleRows<3>(3 * n).squaredNorm();
    if (seen > least) *end++ = {seen, n};
  }
  if (end - room_.changed.begin() > kFew) {
    const auto last = room_.changed.begin() + kFew;
    std::nth_element(room_.changed.begin(), last, end, std::greater<>());
    end = last;
  }
  room_.places.clear();
  for (auto at = room_.changed.begin(); at != end; ++at) {
    const int n = at->second;
    const Vector3d change = next_.segment<3>(3 * n) - taken_.segment<3>(3 * n);
    room_.load.segment<3>(3 * n) = change.cast<float>();
    taken_.segment<3>(3 * n) = next_.segment<3>(3 * n);
    room_.places.push_back(n);
  }
  AddPlaces(green_, room_.places, room_.load, &moved_);
}

void ZonePart::Press(const VectorXd& at_others) noexcept {
  TakePoints(contact_, moved_, &room_.at);
  room_.at = at_others - room_.at;  // without forces
  TakePoints(contact_, u_, &room_.gap);
  forces_->Solve(prescribed_, room_.gap, room_.at);
  SetPressed();
}

void ZonePart::Move(const VectorXd& others) noexcept {
  const Vector3d before = last_force_;
  last_force_ = Force();
  last_ = (last_force_ - before).norm();
  room_.u.setZero();
  AddPlaces(columns_, pressed_points_, pressed_forces_, &room_.u);
  u_ = (room_.u - moved_).cast<double>() + others;
  load_ = -taken_;
  SpreadForces(contact_, forces_->forces(), &load_);
  r_.setZero();
  smallest_jacobian_ = tets_.AddNonlinearForce(u_.data(), r_.data());
  lack_ = (dual_.u.transpose() * (r_ - taken_)).norm();
  ++steps_;
}

// The first step of a tool does not tell what the next one changes.
double ZonePart::Remaining() const {
  if (forces_->tool() == nullptr) return kSlowness * lack_;
  if (steps_ < 2) return std::numeric_limits<double>::infinity();
  return std::max(kSlowness * lack_, last_);
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
  taken_.setZero();
  for (int n = 0; n < zone_.size(); ++n) {
    const int old = number[Index(n)];
    if (old >= 0) taken_.segment<3>(3 * n) = other.taken_.segment<3>(3 * old);
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
  room_.load = taken_.cast<float>();
  MatrixTimes(green_, room_.load, &moved_);
  Move(others);
  before_.r = next_ = r_;
  before_.taken = taken_;
  before_.moved = moved_;
}

}  // namespace palpate
