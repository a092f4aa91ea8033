#include "slave/mechanics/fem/tool_contact.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "slave/mesh/index.h"

namespace palpate::fem {
namespace {

using Eigen::Vector3d;

constexpr double kRim = 1e-9;  // tolerance of the rim relative to a flat tool's extent
constexpr double kMargin = 2;  // distance from the tool up to which nodes are examined [edges]
// Stiffness due to the rotation of friction, relative to that of the node.
constexpr double kMaxTurning = 3;
constexpr int kMaxChanges = 25;  // changes of contact in one increment
// Number of updates after which friction changes by half and keeps its direction between steps.
// This is slower, but converges for nodes that alternate between sticking and slipping.
constexpr int kDamped = 10;
constexpr double kMinSlack = 1e-9;

Vector3d AtNode(const NodeVector& of, int node) {
  return Eigen::Map<const Vector3d>(At(of, node).v);
}
Vector3d Across(const Vector3d& normal, const Vector3d& of) {
  return of - normal.dot(of) * normal;
}

}  // namespace

ToolContact::ToolContact(const Tool& tool, const Placement& placement, double friction,
                         std::span<const TouchableNode> surface)
    : tool_(tool), placement_(placement), friction_(friction), surface_(surface) {
  const auto away = [&](const TouchableNode& at) { return (at.rest - placement.p).squaredNorm(); };
  edge_ = surface.empty() ? 0 : std::ranges::min_element(surface, {}, away)->edge;
  points_.reserve(surface.size());
  accepted_.reserve(surface.size());
}

bool ToolContact::settles() const {
  return changed_ < kMaxChanges;
}

void ToolContact::Reset() noexcept {
  accepted_displacement_.setZero();
  displacement_.setZero();
  accepted_.clear();
  points_.clear();
  force_.setZero();
  moment_.setZero();
  touching_ = 0;
  reach_ = 0;
  shares_ = false;
}

// Returns the centre of the tool's sphere nearest to `x`; a capsule has one at each point of its
// axis.
Vector3d ToolContact::CentreNear(const Vector3d& x) const noexcept {
  const Vector3d centre = placement_.p + displacement_ + tool_.radius * placement_.normal;
  if (tool_.shape != Tool::Shape::kCapsule) return centre;
  const double half = 0.5 * tool_.length;
  return centre + std::clamp(tool_.axis_O.dot(x - centre), -half, half) * tool_.axis_O;
}

bool ToolContact::IsUnderFace(const Vector3d& from_apex) const noexcept {
  const Vector3d across = Across(placement_.normal, from_apex);
  const double half_width = 0.5 * placement_.width * (1 + kRim);
  if (tool_.shape == Tool::Shape::kFlat) return across.norm() <= half_width;
  const Vector3d along = Across(placement_.normal, tool_.axis_O).normalized();
  const double x = across.dot(along);
  return std::abs(x) <= 0.5 * tool_.length * (1 + kRim) &&
         (across - x * along).norm() <= half_width;
}

// Returns whether a node of the deformed body faces the tool and can reach it in this increment.
bool ToolContact::IsNear(const TouchableNode& at, const Vector3d& moved) const noexcept {
  if (at.normal.dot(placement_.normal) <= 0) return false;
  const double margin = kMargin * at.edge + (displacement_ - accepted_displacement_).norm();
  const Vector3d x = at.rest + moved;
  if (tool_.shape == Tool::Shape::kRound || tool_.shape == Tool::Shape::kCapsule) {
    const Vector3d from = x - CentreNear(x);
    return placement_.normal.dot(from) < 0 && from.norm() <= tool_.radius + margin;
  }
  // Uses the accepted state, so that a node at the rim does not change within one increment.
  if (!IsUnderFace(at.rest + moved - accepted_displacement_ - placement_.p)) return false;
  const double height = placement_.normal.dot(x - placement_.p - displacement_);
  return std::abs(height) <= 0.5 * placement_.width + margin;
}

void ToolContact::Begin(const Vector3d& displacement, const NodeVector& u) noexcept {
  displacement_ = displacement;
  is_first_ = true;
  judged_ = changed_ = 0;
  shares_ = false;
  points_.clear();
  auto known = accepted_.begin();
  for (const TouchableNode& at : surface_) {
    while (known != accepted_.end() && known->at < &at) ++known;
    const bool is_known = known != accepted_.end() && known->at == &at;
    const Vector3d moved = AtNode(u, at.node);
    if (!IsNear(at, moved)) continue;
    Point point;
    if (is_known) point = *known;
    if (point.state != State::kSticks) point.anchor = moved - accepted_displacement_;
    point.at = &at;
    points_.push_back(point);
  }
}

void ToolContact::FindGap(const NodeVector& u, Point* point) const noexcept {
  const Vector3d apex = placement_.p + displacement_;
  point->reached = true;
  if (tool_.shape == Tool::Shape::kFlat || tool_.shape == Tool::Shape::kRectangle) {
    point->normal = -placement_.normal;
    point->least = point->normal.dot(apex - point->at->rest);
    return;
  }
  const Vector3d at = point->at->rest + AtNode(u, point->at->node);
  const Vector3d centre = CentreNear(at), from = at - centre;
  const double distance = from.norm();
  // Nodes above the tool's centre are not pushed sideways.
  point->reached = distance > 0 && placement_.normal.dot(from) < 0;
  if (point->reached) point->normal = from / distance;
  point->least = tool_.radius + point->normal.dot(centre - point->at->rest);
}

Vector3d ToolContact::ForceOn(const Point& point, const NodeVector& reaction,
                              const Vector3d& unit_friction) const noexcept {
  if (point.state == State::kApart) return Vector3d::Zero();
  const Vector3d force = AtNode(reaction, point.at->node);
  if (point.state == State::kSticks) return force;
  return point.normal.dot(force) * (point.normal + friction_ * unit_friction);
}

ToolContact::State ToolContact::Next(const NodeVector& u, const NodeVector& reaction,
                                     double force_slack, Point* point) const noexcept {
  const Vector3d& n = point->normal;
  const int node = point->at->node;
  const Vector3d moved = AtNode(u, node);
  const double gap = point->least - n.dot(moved);  // > 0: inside the tool
  double pressed = point->at->stiffness * std::max(gap, 0.0);
  Vector3d force = Vector3d::Zero();
  if (point->state != State::kApart) {
    force = AtNode(reaction, node) + point->friction -
            point->turning * point->aside.dot(moved - point->judged) * point->aside;
    pressed = n.dot(force);
    if (pressed < -force_slack) return is_first_ ? point->state : State::kApart;
    pressed = std::max(pressed, 0.0);
  }
  if (std::isinf(friction_)) return State::kSticks;
  const Vector3d slid = Across(n, moved - displacement_ - point->anchor);
  Vector3d across = Across(n, force);
  // The displacement of a sticking node is not evaluated before a step has moved it.
  if (point->state != State::kSticks) across -= point->at->stiffness * slid;
  const double most = friction_ * pressed, size = across.norm();
  const bool sticks =
      friction_ > 0 && size <= most + (point->state == State::kSticks ? force_slack : 0);
  if (sticks || (is_first_ && point->state == State::kSticks)) {
    point->friction.setZero();
    point->turning = 0;
    return State::kSticks;
  }
  const bool was_apart = point->state == State::kApart;
  const Vector3d next =
      was_apart || !(size > 0) ? Vector3d(Vector3d::Zero()) : Vector3d(most / size * across);
  point->friction = judged_ > kDamped ? Vector3d(0.5 * (point->friction + next)) : next;
  point->judged = moved;
  // The friction rotates with the sliding direction: d t = -mu lambda_n / |slid| times the lateral
  // motion.
  point->aside = n.cross(across).stableNormalized();
  const double stiffest = kMaxTurning * point->at->stiffness;
  point->turning = most < stiffest * slid.norm() ? most / slid.norm() : stiffest;
  if (!(next.squaredNorm() > 0) || judged_ > kDamped) point->turning = 0;
  return State::kSlips;
}

void ToolContact::Claim(int me, std::vector<int>* owner) const noexcept {
  for (const Point& point : points_) {
    int& owned = (*owner)[Index(point.at->node)];
    if (point.state != State::kApart && owned == kNoTool) owned = me;
  }
}

bool ToolContact::UpdateTouching(const NodeVector& u, const NodeVector& reaction, double slack,
                                 bool steps, int me, std::vector<int>* owner) noexcept {
  slack = std::max(slack, kMinSlack);
  is_first_ = !steps;
  double largest = 0;
  for (Point& point : points_) {
    FindGap(u, &point);
    if (point.state == State::kApart) continue;
    const Vector3d force = AtNode(reaction, point.at->node) + point.friction;
    largest = std::max(largest, std::abs(point.normal.dot(force)));
  }
  const double gap_slack = slack * depth();
  bool changes = false;
  ++judged_;
  for (Point& point : points_) {
    int& owned = (*owner)[Index(point.at->node)];
    const bool inside =
        point.reached && point.least - point.normal.dot(AtNode(u, point.at->node)) > gap_slack;
    State next = point.state;
    if (owned != me && owned != kNoTool) {
      shares_ = shares_ || inside;
      next = State::kApart;
    } else if (!point.reached) {
      next = State::kApart;
    } else if (point.state != State::kApart || inside) {
      if (settles()) next = Next(u, reaction, slack * largest, &point);
    }
    if (next == State::kApart) point.friction.setZero(), point.turning = 0;
    changes = changes || next != point.state;
    point.state = next;
    if (owned == me || owned == kNoTool) owned = next == State::kApart ? kNoTool : me;
  }
  if (changes) ++changed_;
  return changes;
}

void ToolContact::AddTouched(std::vector<TouchedNode>* touched) const noexcept {
  for (const Point& point : points_) {
    if (point.state == State::kApart) continue;
    const bool sticks = point.state == State::kSticks;
    Vector3d target = point.least * point.normal;
    if (sticks) {
      target += Across(point.normal, displacement_ + point.anchor);
    }
    touched->push_back({point.at->node, sticks, point.normal, target});
  }
}

void ToolContact::Carry(const Vector3d& way, NodeVector* moved) const noexcept {
  for (const Point& point : points_) {
    if (point.state == State::kApart) continue;
    Eigen::Map<Vector3d>(At(*moved, point.at->node).v) = way;
  }
}

void ToolContact::AddStiffness(double times, BlockMatrix* tangent) const noexcept {
  for (const Point& point : points_) {
    if (point.turning == 0) continue;
    const int row = point.at->node;
    Eigen::Map<Eigen::Matrix3d>(tangent->block(tangent->pattern().diagonal[Index(row)])) +=
        times * point.turning * point.aside * point.aside.transpose();
  }
}

void ToolContact::Load(const NodeVector& base, NodeVector* f_ext) const noexcept {
  for (const Point& point : points_) {
    Eigen::Map<Vector3d>(At(*f_ext, point.at->node).v) =
        AtNode(base, point.at->node) + point.friction;
  }
}

void ToolContact::Accept(const NodeVector& u, const NodeVector& reaction) noexcept {
  accepted_displacement_ = displacement_;
  accepted_ = points_;
  force_.setZero();
  moment_.setZero();
  touching_ = 0;
  reach_ = 0;
  const Vector3d apex = placement_.p + displacement_;
  for (const Point& point : points_) {
    if (point.state == State::kApart) continue;
    const double size = point.friction.norm();
    const Vector3d force = ForceOn(
        point, reaction, size > 0 ? Vector3d(point.friction / size) : Vector3d(Vector3d::Zero()));
    const Vector3d arm = point.at->rest + AtNode(u, point.at->node) - apex;
    force_ += force;
    moment_ += arm.cross(force);
    reach_ = std::max(reach_, arm.norm());
    ++touching_;
  }
}

Vector3d ToolContact::ForceOf(const NodeVector& reaction) const noexcept {
  Vector3d sum = Vector3d::Zero();
  for (const Point& point : accepted_) {
    const double size = point.friction.norm();
    sum += ForceOn(point, reaction,
                   size > 0 ? Vector3d(point.friction / size) : Vector3d(Vector3d::Zero()));
  }
  return sum;
}

}  // namespace palpate::fem
