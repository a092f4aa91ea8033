#include "slave/mechanics/fem/tool_contact.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "slave/mechanics/footprint/rim_share.h"
#include "slave/mesh/index.h"
namespace palpate::fem {
namespace {

using Eigen::Vector3d;

constexpr double kMargin = 2;  // distance from the tool up to which nodes are examined [edges]
// Stiffness due to the rotation of friction of a node that has hardly slid, relative to that of the
// node.
constexpr double kMaxTurning = 1000;
constexpr int kMaxChanges = 25;  // changes of contact in one increment
// Number of updates after which a node that leaves the tool does not return to its place.
constexpr int kLateToLeave = 10;
constexpr double kMinSlack = 1e-9;
// Part of the tool's normal along which a node must be free to be touched.
constexpr double kMovable = 0.9;
// Share of the error at a touch that stays in the place where the node sticks [-]. [measured:
// bench_organ]
constexpr double kStays = 0.15;
// Smallest way on which the tolerance of gaps is based, relative to the depth [-].
constexpr double kLeastWay = 1e-3;

Vector3d AtNode(const NodeVector& of, int node) {
  return Eigen::Map<const Vector3d>(At(of, node).v);
}
Vector3d Across(const Vector3d& normal, const Vector3d& of) {
  return of - normal.dot(of) * normal;
}

}  // namespace

ToolContact::ToolContact(const Tool& tool, const Placement& placement, double friction,
                         double poisson_ratio, std::span<const TouchableNode> surface)
    : tool_(tool),
      placement_(placement),
      friction_(friction),
      poisson_ratio_(poisson_ratio),
      surface_(surface) {
  const auto away = [&](const TouchableNode& at) { return (at.rest - placement.p).squaredNorm(); };
  edge_ = surface.empty() ? 0 : std::ranges::min_element(surface, {}, away)->edge;
  for (auto* points : {&points_, &accepted_.points, &kept_.points}) points->reserve(surface.size());
}

bool ToolContact::settles() const {
  return changed_ < kMaxChanges;
}

void ToolContact::Reset() noexcept {
  displacement_.setZero();
  points_.clear();
  accepted_.points.clear();
  accepted_.displacement.setZero();
  accepted_.force.setZero();
  accepted_.moment.setZero();
  accepted_.touching = 0;
  accepted_.reach = accepted_.error = accepted_.error_at_touch = 0;
  accepted_.has_new_touch = false;
  shares_ = false;
}

void ToolContact::TakeBack() noexcept {
  accepted_ = kept_;
  points_ = kept_.points;
  displacement_ = kept_.displacement;
}

// Returns the centre of the tool's sphere nearest to `x`; a capsule has one at each point of its
// axis.
Vector3d ToolContact::CentreNear(const Vector3d& x, const Vector3d& displacement) const noexcept {
  const Vector3d centre = placement_.p + displacement + tool_.radius * placement_.normal;
  if (tool_.shape != Tool::Shape::kCapsule) return centre;
  const double half = 0.5 * tool_.length;
  return centre + std::clamp(tool_.axis_O.dot(x - centre), -half, half) * tool_.axis_O;
}

double ToolContact::DepthOf(const Vector3d& x, const Vector3d& displacement) const noexcept {
  if (is_face()) return placement_.normal.dot(x - placement_.p - displacement);
  return tool_.radius - (x - CentreNear(x, displacement)).norm();
}

// Returns the share of the node's part of the surface under a flat face; 1 under other tools.
double ToolContact::ShareOf(const TouchableNode& at, const Vector3d& moved) const noexcept {
  if (!is_face()) return 1;
  const Vector3d from_apex = at.rest + moved - displacement_ - placement_.p;
  const Vector3d across = Across(placement_.normal, from_apex);
  const double half_width = 0.5 * placement_.width;
  if (tool_.shape == Tool::Shape::kFlat) return ShareUnderDisc(half_width, at.part, across.norm());
  const Vector3d along = Across(placement_.normal, tool_.axis_O).normalized();
  const double x = along.dot(across), y = placement_.normal.cross(along).dot(across);
  return ShareUnderRectangle(0.5 * tool_.length, half_width, at.part, x, y);
}

// Returns whether a node of the deformed body faces the tool and can reach it in this increment.
bool ToolContact::IsNear(const TouchableNode& at, const Vector3d& moved) const noexcept {
  const double margin = kMargin * at.edge + (displacement_ - accepted_.displacement).norm();
  const Vector3d from_apex = at.rest + moved - displacement_ - placement_.p;
  const double reach = (is_face() ? 0.5 * std::hypot(placement_.width, tool_.length)
                                  : 2 * tool_.radius + 0.5 * tool_.length) +
                       margin;
  if (from_apex.squaredNorm() > 2 * reach * reach) return false;
  if (at.normal.dot(placement_.normal) <= 0) return false;
  if (at.free.cwiseProduct(placement_.normal).norm() < kMovable) return false;
  if (!is_face()) {
    const Vector3d x = at.rest + moved, from = x - CentreNear(x, displacement_);
    return placement_.normal.dot(from) < 0 && from.norm() <= tool_.radius + margin;
  }
  const double height = placement_.normal.dot(from_apex);
  return std::abs(height) <= 0.5 * placement_.width + margin &&
         Across(placement_.normal, from_apex).norm() <= reach;
}

void ToolContact::Begin(const Vector3d& displacement, const NodeVector& u) noexcept {
  displacement_ = displacement;
  way_ = way().norm();
  after_ = After::kPrediction;
  judged_ = changed_ = 0;
  shares_ = false;
  points_.clear();
  auto known = accepted_.points.begin();
  for (const TouchableNode& at : surface_) {
    while (known != accepted_.points.end() && known->at < &at) ++known;
    const bool is_known = known != accepted_.points.end() && known->at == &at;
    const Vector3d moved = AtNode(u, at.node);
    if (!IsNear(at, moved)) continue;
    Point point;
    if (is_known) point = *known;
    if (point.state == State::kApart || (point.state == State::kSlips && !IsAtRim(point))) {
      point.anchor = moved - accepted_.displacement;
    }
    point.first_anchor = point.anchor;  // of one that leaves and returns in this increment
    point.at = &at;
    point.before = moved;
    point.depth_before = DepthOf(at.rest + moved, accepted_.displacement);
    point.was_held = point.state != State::kApart;
    point.is_new = point.has_left = point.is_let_go = false;
    points_.push_back(point);
  }
}

bool ToolContact::IsAtRim(const Point& point) {
  return point.share < kWholeShare;
}

void ToolContact::Touch(Point* point) {
  point->anchor = point->first_anchor;
  point->is_new = point->is_new || !point->has_left || point->is_let_go;
}

Vector3d ToolContact::AnchorAt(const Point& point, const Vector3d& moved) const noexcept {
  const double depth = DepthOf(point.at->rest + moved, displacement_), before = point.depth_before;
  const Vector3d from = point.before - accepted_.displacement;
  if (before >= 0 || !(depth > before)) return from;
  const double part = std::min(1.0, before / (before - depth));
  return (1 - part) * from + part * (moved - displacement_);
}

void ToolContact::FindGap(const NodeVector& u, Point* point) const noexcept {
  const Vector3d moved = AtNode(u, point->at->node);
  if (is_face()) {
    point->reached = point->share > kLeastShare;
    point->normal = -placement_.normal;
    point->least = point->normal.dot(placement_.p + displacement_ - point->at->rest);
    return;
  }
  const Vector3d at = point->at->rest + moved;
  const Vector3d centre = CentreNear(at, displacement_), from = at - centre;
  const double distance = from.norm();
  // Nodes above the tool's centre are not pushed sideways.
  point->reached = distance > 0 && placement_.normal.dot(from) < 0;
  if (point->reached) point->normal = from / distance;
  point->least = tool_.radius + point->normal.dot(centre - point->at->rest);
}

Vector3d ToolContact::ForceOn(const Point& point, const NodeVector& reaction) const noexcept {
  if (point.state == State::kApart) return Vector3d::Zero();
  if (IsAtRim(point)) return point.spring;
  // A support carries its own components.
  const Vector3d force = point.at->free.cwiseProduct(AtNode(reaction, point.at->node));
  if (point.state == State::kSticks) return force;
  Vector3d direction = point.normal;
  const double size = point.friction.norm();
  if (size > 0) direction += friction_ / size * point.friction;
  return point.normal.dot(force) * direction;
}

// The force of the spring of a node at the rim, which a return to Coulomb's cone limits. Before a
// step has moved the nodes, and unless their state is `judged`, those that touch stay as they are,
// and so do those that the face held as a whole. As for whole nodes, the way that one slips counts
// with the stiffness of the node, because a stiff spring would reverse the friction at every step.
ToolContact::State ToolContact::PushBySpring(const Vector3d& moved, Judged judged,
                                             Point* point) const noexcept {
  const Vector3d& n = point->normal;
  const State last = point->state;
  const bool is_other = !std::exchange(point->on_spring, true);  // the face held the whole node
  const bool touched_first = (after_ == After::kPrediction || is_other) && last != State::kApart;
  const bool stays = touched_first || (judged != Judged::kState && last != State::kApart);
  const bool keeps = touched_first || judged == Judged::kNothing;
  const double depth = point->least - n.dot(moved);
  const Vector3d friction = Across(n, point->spring);
  point->spring.setZero();
  point->spring_stiffness.setZero();
  if (!(depth > 0) && !touched_first) return State::kApart;
  if (last == State::kApart) Touch(point);
  const DiscCompliance compliance = SpringAtRim(poisson_ratio_, point->at->part, point->share);
  const double normal = point->at->modulus / compliance.normal,
               across = point->at->modulus / compliance.across;
  point->spring = normal * depth * n;
  point->spring_stiffness = normal * n * n.transpose();
  if (!(friction_ > 0) || (std::isinf(friction_) && point->is_let_go)) return State::kSlips;
  const Vector3d held = across * Across(n, displacement_ + point->anchor - moved);
  const double most =
      has_friction() ? friction_ * normal * std::max(depth, 0.0) : friction_;  // infinite
  const double firm = last == State::kSlips ? std::min(across, point->at->stiffness) : across;
  const Vector3d moved_over = Across(n, moved - displacement_ - point->anchor);
  const Vector3d drag = last == State::kSlips && has_friction() ? DragAt(most, moved_over, *point)
                                                                : Vector3d(Vector3d::Zero());
  const Vector3d trial =
      last == State::kSlips ? Vector3d(drag + firm / across * (held - drag)) : held;
  const double size = trial.norm();
  if (stays ? last == State::kSticks : size <= most) {
    point->spring += held;
    point->spring_stiffness += across * (Eigen::Matrix3d::Identity() - n * n.transpose());
    point->turning = 0;
    return State::kSticks;
  }
  if (keeps) {
    point->spring += drag;
    return State::kSlips;
  }
  const double share = size > 0 ? most / size : 0;
  Turn(trial, share * firm / (1 - std::min(share, 1.0) + share * firm / across), point);
  if (last != State::kApart) point->spring += DragAt(most, moved_over, *point);
  return State::kSlips;
}

void ToolContact::UpdateSprings(const NodeVector& u) noexcept {
  for (Point& point : points_) {
    if (point.state == State::kApart || !IsAtRim(point)) continue;
    PushBySpring(AtNode(u, point.at->node), Judged::kNothing, &point);
  }
}

double ToolContact::UpdateShares(const NodeVector& u) noexcept {
  double largest = 0;
  for (Point& point : points_) {
    if (point.state == State::kSticks) continue;
    const double share = ShareOf(*point.at, AtNode(u, point.at->node));
    if (point.state == State::kSlips) largest = std::max(largest, std::abs(share - point.share));
    point.share = share;
  }
  return largest;
}

// The state of a node that a force pulls off the tool. A bonded one that is mainly pulled along the
// surface lets go of its place first.
ToolContact::State ToolContact::Pulled(const Vector3d& force, Point* point) const noexcept {
  if (after_ == After::kPrediction) return point->state;
  const double pull = -point->normal.dot(force);
  const bool is_bonded = std::isinf(friction_) && point->state == State::kSticks;
  if (after_ != After::kCorrection || !is_bonded || Across(point->normal, force).norm() < pull) {
    return State::kApart;
  }
  point->is_let_go = true;
  return State::kSlips;
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
    force = AtNode(reaction, node) + point->friction;
    pressed = n.dot(force);
    if (pressed < -force_slack) return Pulled(force, point);
    pressed = std::max(pressed, 0.0);
  }
  if (point->state == State::kApart) Touch(point);
  if (std::isinf(friction_)) return point->is_let_go ? State::kSlips : State::kSticks;
  // Before a step has moved them, nodes that touch stay as they are.
  if (after_ == After::kPrediction && point->state != State::kApart) return point->state;
  const bool was_apart = point->state == State::kApart;
  const double most = friction_ * pressed;
  if (friction_ > 0 && point->state == State::kSticks &&
      Across(n, force).norm() <= most + force_slack) {
    return State::kSticks;
  }
  const Vector3d slid = Across(n, moved - displacement_ - point->anchor);
  Vector3d across = Across(n, force);
  if (point->state == State::kSlips) {
    across = DragAt(most, slid, *point);
    // It slides along its friction, as at a turn of the tool. With the stiffness of one node, which
    // is more than that of all, its friction would turn at every step.
    if (across.dot(slid) > 0) return State::kSticks;
  }
  if (point->state != State::kSticks) across -= point->at->stiffness * slid;
  if (friction_ > 0 && point->state != State::kSticks && across.norm() <= most)
    return State::kSticks;
  Drag(was_apart ? 0 : most, across, slid, point);
  return State::kSlips;
}

// The friction of a node that slips, has slid by `slid` in this increment and bears at most `most`,
// by the last tangent: it turns with the sliding direction.
Vector3d ToolContact::DragAt(double most, const Vector3d& slid, const Point& point) const noexcept {
  const double aside = point.turning * point.aside.dot(slid);
  return most * point.aside.cross(point.normal) - std::clamp(aside, -most, most) * point.aside;
}

// Directs the friction of a node along `trial`.
void ToolContact::Turn(const Vector3d& trial, double turning, Point* point) {
  point->aside = point->normal.cross(trial).stableNormalized();
  point->turning = turning;
}

void ToolContact::Drag(double most, const Vector3d& trial, const Vector3d& slid,
                       Point* point) const noexcept {
  const double stiffest = kMaxTurning * point->at->stiffness, way = slid.norm();
  Turn(trial, most < stiffest * way ? most / way : (most > 0 ? stiffest : 0), point);
  point->friction = DragAt(most, slid, *point);
}

void ToolContact::UpdateFriction(const NodeVector& u, const NodeVector& reaction) noexcept {
  if (!has_friction()) return;
  for (Point& point : points_) {
    if (point.state != State::kSlips) continue;
    const Vector3d moved = AtNode(u, point.at->node);
    if (IsAtRim(point)) {
      PushBySpring(moved, Judged::kFriction, &point);
      continue;
    }
    const Vector3d force = AtNode(reaction, point.at->node) + point.friction;
    const double most = friction_ * std::max(0.0, point.normal.dot(force));
    const Vector3d slid = Across(point.normal, moved - displacement_ - point.anchor);
    Drag(most, DragAt(most, slid, point) - point.at->stiffness * slid, slid, &point);
  }
}

void ToolContact::AddFrictionOf(const NodeVector& motion, const BlockMatrix& tangent,
                                NodeVector* change) const noexcept {
  if (!has_friction()) return;
  for (const Point& point : points_) {
    if (point.state != State::kSlips) continue;
    const int node = point.at->node;
    const Vector3d& n = point.normal;
    const Vector3d along = point.aside.cross(n);
    double pressed = 0;
    if (IsAtRim(point)) {
      pressed = -n.dot(AtNode(motion, node)) * n.dot(point.spring_stiffness * n);
    } else {
      const NodeValue row = tangent.Row(node, motion);
      pressed = n.dot(Eigen::Map<const Vector3d>(row.v));
    }
    Eigen::Map<Vector3d>(At(*change, node).v) += friction_ * pressed * along;
  }
}

void ToolContact::Claim(int me, std::vector<int>* owner) const noexcept {
  for (const Point& point : points_) {
    int& owned = (*owner)[Index(point.at->node)];
    if (point.state != State::kApart && owned == kNoTool) owned = me;
  }
}

bool ToolContact::UpdateTouching(const NodeVector& u, const NodeVector& reaction, double slack,
                                 After after, int me, std::vector<int>* owner) noexcept {
  slack = std::max(slack, kMinSlack);
  after_ = after;
  const bool is_first = after == After::kPrediction;
  double largest = 0;
  for (Point& point : points_) {
    if (is_first && (point.state == State::kApart || point.is_new)) {
      point.first_anchor = AnchorAt(point, AtNode(u, point.at->node));
      if (point.is_new) point.anchor = point.first_anchor;
    }
    const bool returns = point.has_left && !point.is_let_go;
    if ((point.state == State::kApart && !returns) || (is_first && point.state == State::kSlips)) {
      point.share = ShareOf(*point.at, AtNode(u, point.at->node));
    }
    FindGap(u, &point);
    if (point.state == State::kApart) continue;
    const Vector3d force =
        IsAtRim(point) ? point.spring : Vector3d(AtNode(reaction, point.at->node) + point.friction);
    largest = std::max(largest, std::abs(point.normal.dot(force)));
  }
  const double depth = std::abs(placement_.normal.dot(displacement_));
  slack_ = slack * std::max(way_, kLeastWay * depth);
  bool changes = false;
  ++judged_;
  for (Point& point : points_) {
    int& owned = (*owner)[Index(point.at->node)];
    const bool is_mine = owned == me || owned == kNoTool;
    const Vector3d moved = AtNode(u, point.at->node);
    const bool inside = point.reached && point.least - point.normal.dot(moved) > slack_;
    const State last = point.state;
    if (after == After::kCorrection && point.has_left) point.is_let_go = true;
    if (!is_mine) shares_ = shares_ || inside;
    if (!is_mine || !point.reached) {
      point.state = State::kApart;
    } else if (IsAtRim(point)) {
      point.state = PushBySpring(moved, Judged::kState, &point);
    } else if (last != State::kApart || inside) {
      if (settles()) point.state = Next(u, reaction, slack * largest, &point);
    }
    const bool is_held = point.state != State::kApart && !IsAtRim(point);
    if (!is_held || point.state == State::kSticks) point.friction.setZero();
    point.on_spring = point.state != State::kApart && !is_held;
    if (point.state != State::kSlips) point.turning = 0;
    if (point.state == State::kApart || is_held) {
      point.spring.setZero(), point.spring_stiffness.setZero();
    }
    if (point.state == State::kApart && last != State::kApart) {
      const bool is_late = judged_ > kLateToLeave || after == After::kCorrection;
      point.is_let_go = point.is_let_go || point.has_left || is_late;
      point.has_left = true;
    }
    changes = changes || (point.state != last && (is_held || !IsAtRim(point)));
    if (is_mine) owned = point.state == State::kApart ? kNoTool : me;
  }
  if (changes) ++changed_;
  return changes;
}

void ToolContact::AddTouched(std::vector<TouchedNode>* touched) const noexcept {
  for (const Point& point : points_) {
    if (point.state == State::kApart || IsAtRim(point)) continue;
    const bool sticks = point.state == State::kSticks;
    Vector3d target = point.least * point.normal;
    if (sticks) {
      target += Across(point.normal, displacement_ + point.anchor);
    }
    touched->push_back({point.at->node, sticks, point.normal, target, slack_});
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
    if (point.state == State::kApart || (point.turning == 0 && !IsAtRim(point))) continue;
    const int row = point.at->node;
    Eigen::Map<Eigen::Matrix3d>(tangent->block(tangent->pattern().diagonal[Index(row)])) +=
        times * (point.turning * point.aside * point.aside.transpose() + point.spring_stiffness);
  }
}

void ToolContact::Unload(const NodeVector& base, NodeVector* f_ext) const noexcept {
  for (const Point& point : points_) At(*f_ext, point.at->node) = At(base, point.at->node);
}

void ToolContact::Load(NodeVector* f_ext) const noexcept {
  for (const Point& point : points_) {
    Eigen::Map<Vector3d>(At(*f_ext, point.at->node).v) += point.friction + point.spring;
  }
}

void ToolContact::Accept(const NodeVector& u, const NodeVector& reaction) noexcept {
  accepted_.displacement = displacement_;
  accepted_.points = points_;
  accepted_.force.setZero();
  accepted_.moment.setZero();
  accepted_.touching = 0;
  accepted_.reach = 0;
  accepted_.spring_work = 0;
  const Vector3d apex = placement_.p + displacement_;
  for (Point& point : accepted_.points) {
    if (point.state == State::kApart) continue;
    const Vector3d force = ForceOn(point, reaction), moved = AtNode(u, point.at->node);
    const Vector3d arm = point.at->rest + moved - apex;
    accepted_.force += force;
    accepted_.moment += arm.cross(force);
    accepted_.reach = std::max(accepted_.reach, arm.norm());
    ++accepted_.touching;
    if (IsAtRim(point)) {
      const double pressed = point.normal.dot(point.spring);
      const double compliance = SpringAtRim(poisson_ratio_, point.at->part, point.share).normal;
      accepted_.spring_work += pressed * pressed * compliance / point.at->modulus;
    }
    accepted_.has_new_touch = accepted_.has_new_touch || point.is_new;
    // A spring on Coulomb's cone slips until its force is on it.
    if (point.state == State::kSlips && IsAtRim(point)) {
      const double across = SpringAtRim(poisson_ratio_, point.at->part, point.share).across;
      point.anchor =
          moved - displacement_ + across / point.at->modulus * Across(point.normal, point.spring);
    }
  }
}

void ToolContact::EstimateError(const NodeVector& reaction, const NodeVector& u) noexcept {
  Vector3d sum = Vector3d::Zero();
  for (const Point& point : accepted_.points) {
    if (point.state == State::kApart) continue;
    sum += IsAtRim(point) ? Vector3d(-point.spring_stiffness * AtNode(u, point.at->node))
                          : ForceOn(point, reaction);
  }
  accepted_.error = sum.norm();
  if (accepted_.touching == 0) accepted_.error_at_touch = 0;
  if (accepted_.has_new_touch) {
    accepted_.error_at_touch = std::max(accepted_.error_at_touch, kStays * accepted_.error);
  }
  accepted_.has_new_touch = false;
}

}  // namespace palpate::fem
