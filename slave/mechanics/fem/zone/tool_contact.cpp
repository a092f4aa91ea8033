#include "slave/mechanics/fem/zone/tool_contact.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kMostSweeps = 40;
constexpr double kSettled = 1e-5;  // change of a force in a sweep, by the largest force [-]

}  // namespace

ToolContact::ToolContact(const Tool& tool, const Placement& placement, double friction,
                         std::vector<Vector3d> rest, const MatrixXd& compliance)
    : tool_(tool),
      placement_(placement),
      friction_(friction),
      points_(rest.size()),
      compliance_(compliance),
      moved_(VectorXd::Zero(compliance.rows())) {
  for (std::size_t k = 0; k < rest.size(); ++k) points_[k].rest = rest[k];
}

void ToolContact::Reset() {
  displacement_.setZero();
  for (Point& point : points_) {
    point.anchor.setZero();
    point.state = State::kApart;
  }
}

void ToolContact::FindGaps(const VectorXd& u) noexcept {
  const Vector3d apex = placement_.p + displacement_;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    Point& point = points_[k];
    const Vector3d at = point.rest + u.segment<3>(3 * static_cast<int>(k));
    if (tool_.shape == Tool::Shape::kFlat) {
      // By the last accepted state: a point at the rim does not come and go within one update.
      const Vector3d from = point.rest + point.anchor - placement_.p;
      point.normal = -placement_.normal;
      point.reached = (from - placement_.normal.dot(from) * placement_.normal).norm() <=
                      0.5 * placement_.width * (1 + 1e-9);
      point.least = point.normal.dot(apex - point.rest);
    } else {
      Vector3d centre = apex + tool_.radius * placement_.normal;
      if (tool_.shape == Tool::Shape::kCapsule) {
        const double half = 0.5 * tool_.length;
        centre += std::clamp(tool_.axis_O.dot(at - centre), -half, half) * tool_.axis_O;
      }
      const Vector3d from = at - centre;
      const double distance = from.norm();
      // Points beside the tool's middle and above it are not pushed sideways.
      point.reached = distance > 0 && placement_.normal.dot(from) < 0;
      if (point.reached) point.normal = from / distance;
      point.least = tool_.radius + point.normal.dot(centre - point.rest);
    }
    const int row = 3 * static_cast<int>(k);
    const Matrix3d own = compliance_.block<3, 3>(row, row);
    point.along = point.normal.dot(own * point.normal);
    point.across = 0.5 * (own.trace() - point.along);
  }
}

Vector3d ToolContact::NextForce(const Point& point, const Vector3d& moved, const Vector3d& force,
                                State* state, Vector3d* drag) const noexcept {
  *state = State::kApart;
  if (!point.reached || !(point.along > 0)) return Vector3d::Zero();
  const Vector3d& n = point.normal;
  const double before = n.dot(force);
  const double pressed = before + (point.least - n.dot(moved)) / point.along;
  if (pressed <= 0) return Vector3d::Zero();
  if (friction_ == 0) {
    *state = State::kSlips;
    drag->setZero();
    return pressed * n;
  }
  const Vector3d slid = moved - displacement_ - point.anchor;
  Vector3d across = force - before * n - (slid - n.dot(slid) * n) / point.across;
  across -= n.dot(across) * n;
  const double most = friction_ * pressed, size = across.norm();
  *state = State::kSticks;
  if (size > most) {
    *state = State::kSlips;
    across *= most / size;
    *drag = across / pressed;
  }
  return pressed * n + across;
}

void ToolContact::Solve(const VectorXd& free, VectorXd* forces) noexcept {
  moved_ = free;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const int row = 3 * static_cast<int>(k);
    if (!forces->segment<3>(row).isZero(0)) {
      moved_.noalias() += compliance_.middleCols<3>(row) * forces->segment<3>(row);
    }
  }
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double largest = 0, change = 0;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      Point& point = points_[k];
      const int row = 3 * static_cast<int>(k);
      const Vector3d force = forces->segment<3>(row);
      State state = State::kApart;
      const Vector3d next = NextForce(point, moved_.segment<3>(row), force, &state, &point.drag);
      point.state = state;
      const Vector3d step = next - force;
      if (step.isZero(0)) continue;
      moved_.noalias() += compliance_.middleCols<3>(row) * step;
      forces->segment<3>(row) = next;
      change = std::max(change, step.squaredNorm());
      largest = std::max(largest, next.squaredNorm());
    }
    if (change <= kSettled * kSettled * largest) break;
  }
}

void ToolContact::Accept(const VectorXd& u) noexcept {
  for (std::size_t k = 0; k < points_.size(); ++k) {
    Point& point = points_[k];
    if (point.state == State::kSticks) continue;
    point.anchor = u.segment<3>(3 * static_cast<int>(k)) - displacement_;
  }
}

Vector3d ToolContact::Dragged(const Vector3d& normal) const {
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    if (points_[k].state == State::kApart) continue;
    sum += moved_.segment<3>(3 * static_cast<int>(k));
    ++count;
  }
  if (count > 0) sum /= count;
  return sum - normal.dot(sum) * normal;
}

int ToolContact::touching() const {
  return static_cast<int>(
      std::ranges::count_if(points_, [](const Point& p) { return p.state != State::kApart; }));
}

bool ToolContact::Factorise() noexcept {
  directions_.clear();
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const Point& point = points_[k];
    const int row = 3 * static_cast<int>(k);
    if (point.state == State::kSticks) {
      for (int c = 0; c < 3; ++c)
        directions_.push_back({row, Vector3d::Unit(c), Vector3d::Unit(c)});
    } else if (point.state == State::kSlips) {
      directions_.push_back({row, point.normal, point.normal + point.drag});
    }
  }
  const auto count = static_cast<int>(directions_.size());
  if (count == 0) return false;
  among_.resize(count, count);
  for (int i = 0; i < count; ++i) {
    const Direction& to = directions_[Index(i)];
    for (int j = 0; j < count; ++j) {
      const Direction& from = directions_[Index(j)];
      among_(i, j) = to.test.dot(compliance_.block<3, 3>(to.row, from.row) * from.drive);
    }
  }
  inverse_.compute(among_);
  return true;
}

void ToolContact::DualForces(MatrixXd* forces) noexcept {
  forces->setZero();
  const auto count = static_cast<int>(directions_.size());
  MatrixXd unit(count, 3);
  for (int i = 0; i < count; ++i) unit.row(i) = directions_[Index(i)].drive;
  const MatrixXd solved = inverse_.transpose().solve(unit);
  for (int i = 0; i < count; ++i) {
    const Direction& at = directions_[Index(i)];
    forces->middleRows<3>(at.row) += at.test * solved.row(i);
  }
}

void ToolContact::HeldForces(const VectorXd& moved, VectorXd* forces) noexcept {
  forces->setZero();
  const auto count = static_cast<int>(directions_.size());
  VectorXd gap(count);
  for (int i = 0; i < count; ++i) {
    const Direction& at = directions_[Index(i)];
    gap[i] = -at.test.dot(moved.segment<3>(at.row));
  }
  const VectorXd solved = inverse_.solve(gap);
  for (int i = 0; i < count; ++i) {
    const Direction& at = directions_[Index(i)];
    forces->segment<3>(at.row) += solved[i] * at.drive;
  }
}

void ToolContact::TakeState(const ToolContact& other, const std::vector<int>& number) {
  displacement_ = other.displacement_;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    if (number[k] < 0) {
      points_[k].anchor = -displacement_;  // so far from the tool it has hardly moved
      continue;
    }
    const Point& from = other.points_[Index(number[k])];
    points_[k].anchor = from.anchor;
    points_[k].state = from.state;
    points_[k].normal = from.normal;
  }
}

}  // namespace palpate
